//! A view of a scene that came without one.
use super::{DEFAULT_RESOLUTION, View};
use gibs_passes::accel::MAX_WORLD_COORDINATE;
use gibs_passes::scene::{Camera, Environment, NodeId, Pose, Scene, Sun};
use glam::{DVec3, Vec3};

/// Vertical field of view of a camera that is made up, radians (45 degrees).
const VFOV: f64 = std::f64::consts::FRAC_PI_4;

/// From the scene's middle to a camera that is made up: from the front (+z), somewhat right and above.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.55, 0.4, 1.0);

impl View {
    /// A view of `scene` in its rest pose.
    ///
    /// - Camera: the scene's first one, which is in world space at rest; else one outside that shows the bounding
    ///   sphere of everything that is drawn.
    /// - Light: if the scene has neither lights that shine nor emission, a soft sky (0.35, 0.45, 0.6) and a sun of 5 W/m^2;
    ///   else nothing beside the scene's own.
    /// - Size: [`DEFAULT_RESOLUTION`].
    ///
    /// What was made up is named in [`View::warnings`]. Of a scene that does not pass [`Scene::validate`], what does not
    /// exist does not count.
    pub fn framing(scene: &Scene) -> View {
        let mut warnings = Vec::new();
        let camera = match scene.cameras.first() {
            Some((_, camera)) => *camera,
            None => {
                warnings.push(
                    "the scene has no camera and is seen from in front of it; a view file can place one"
                        .to_owned(),
                );
                around(bounds(scene, &scene.pose(&[])))
            }
        };
        let (sun, environment) = match is_lit(scene) {
            true => (None, Environment::default()),
            false => {
                warnings.push(
                    "the scene has no light and gets a sun and a soft sky; a view file can set others"
                        .to_owned(),
                );
                (
                    Some(Sun {
                        direction: DVec3::new(-0.45, -0.8, -0.4).normalize(),
                        irradiance: Vec3::new(5.0, 4.7, 4.2),
                    }),
                    Environment::Constant(Vec3::new(0.35, 0.45, 0.6)),
                )
            }
        };
        View {
            scene: None,
            camera,
            resolution: DEFAULT_RESOLUTION,
            sun,
            environment,
            animation: Vec::new(),
            exposure: 1.0,
            warnings,
        }
    }
}

/// A camera that shows a box.
fn around([low, high]: [DVec3; 2]) -> Camera {
    let target = (low + high) / 2.0;
    let radius = match (high - low).length() / 2.0 {
        radius if radius > 0.0 => radius,
        // A point still needs a distance.
        _ => 1e-3,
    };
    let position = target + TOWARDS_CAMERA.normalize() * radius / (VFOV / 2.0).sin();
    Camera {
        position,
        target,
        up: DVec3::Y,
        vfov: VFOV,
    }
}

/// Whether anything in the scene shines.
fn is_lit(scene: &Scene) -> bool {
    let shines = |mesh: &u32| {
        (scene.meshes.get(*mesh as usize))
            .and_then(|mesh| scene.materials.get(mesh.material as usize))
            .is_some_and(|material| material.emission.max_element() > 0.0)
    };
    scene
        .lights
        .iter()
        .any(|light| light.intensity.max_element() > 0.0)
        || scene
            .nodes
            .iter()
            .any(|node| node.meshes.iter().any(shines))
}

/// Least and greatest coordinates of what is drawn; of the unit cube if that is nothing. A node out of the range that
/// can be drawn does not count, since it would take everything else out of sight.
fn bounds(scene: &Scene, pose: &Pose) -> [DVec3; 2] {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (id, node) in scene.nodes.iter().enumerate() {
        for &mesh in &node.meshes {
            let (mut least, mut greatest) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let mut is_near = true;
            for point in scene.skinned_positions(pose, id as NodeId, mesh).positions {
                is_near &= point.abs().cmplt(DVec3::splat(MAX_WORLD_COORDINATE)).all();
                (least, greatest) = (least.min(point), greatest.max(point));
            }
            if is_near {
                (low, high) = (low.min(least), high.max(greatest));
            }
        }
    }
    if low.x > high.x {
        [DVec3::splat(-0.5), DVec3::splat(0.5)]
    } else {
        [low, high]
    }
}
