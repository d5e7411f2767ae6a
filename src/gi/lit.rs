//! A scene as it is lit: on the device, and what of the host's is needed to tell what changed.
use crate::renderer::{RenderError, device_scene, refused};
use crate::view::View;
use bytemuck::cast_slice;
use gibs_passes::data::Light;
use gibs_passes::device::{DeviceScene, EnvironmentTable};
use gibs_passes::frame::SceneSizes;
use gibs_passes::scene::{Environment, MOST_RADIANCE, Pose, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// A scene in a pose, lit by a view.
#[derive(Clone, Debug)]
pub(super) struct Lit {
    pub device: DeviceScene,
    pub sizes: SceneSizes,
    pub drawn: Drawn,
    /// What the device's sky was made from, since making it takes longer than a frame; `None` where making it warns.
    sky: Option<Environment>,
}

/// Light of a scene before it changed.
pub(super) struct Before {
    lights: Vec<Light>,
    warnings: Vec<String>,
    sizes: SceneSizes,
    /// `None` where the sky is the same.
    sky: Option<(EnvironmentTable, Option<Environment>)>,
}

impl Lit {
    pub fn new(scene: &Scene, view: &View, origin: DVec3) -> Result<Self, RenderError> {
        let device = device_scene(scene, view, origin)?;
        Ok(Self {
            sizes: SceneSizes::of(&device),
            drawn: Drawn::of(scene, &scene.pose(&view.animation)),
            sky: sound(&view.environment),
            device,
        })
    }

    /// Takes other lights, another sun or sky for the same geometry, and gives what there was.
    ///
    /// # Errors
    /// As [`DeviceScene::relight`]; nothing has changed then.
    pub fn relight(
        &mut self,
        scene: &Scene,
        pose: &Pose,
        view: &View,
    ) -> Result<Before, RenderError> {
        let device = &mut self.device;
        let (lights, warnings) = (device.lights.clone(), device.warnings.clone());
        let table = std::mem::take(&mut device.environment);
        let stays = self.sky.as_ref() == Some(&view.environment);
        // As dark or bright as the sky that stays.
        let brightness = if table.is_black() { 0.0 } else { 1.0 };
        let alike = Environment::Constant(Vec3::splat(brightness));
        let environment = if stays { &alike } else { &view.environment };
        let lit = device.relight(scene, pose, view.sun.as_ref(), environment);
        if let Err(error) = lit {
            device.environment = table;
            return Err(refused(scene)(error));
        }
        let sky = match stays {
            true => {
                device.environment = table;
                None
            }
            false => {
                let before = std::mem::replace(&mut self.sky, sound(&view.environment));
                Some((table, before))
            }
        };
        let sizes = std::mem::replace(&mut self.sizes, SceneSizes::of(&self.device));
        Ok(Before {
            lights,
            warnings,
            sizes,
            sky,
        })
    }

    /// Takes back what [`Lit::relight`] changed.
    pub fn restore(&mut self, before: Before) {
        self.device.lights = before.lights;
        self.device.warnings = before.warnings;
        self.sizes = before.sizes;
        if let Some((table, sky)) = before.sky {
            (self.device.environment, self.sky) = (table, sky);
        }
    }

    /// Whether the input with this key holds other bytes than for `other`.
    pub fn has_other(&self, key: &str, other: &Self) -> bool {
        let (a, b) = (&self.device, &other.device);
        let differ = |a: &[u8], b: &[u8]| a != b;
        match key {
            "scene_nodes" => differ(cast_slice(&a.tree.nodes), cast_slice(&b.tree.nodes)),
            "scene_triangles" => {
                differ(cast_slice(&a.tree.triangles), cast_slice(&b.tree.triangles))
            }
            "scene_corners" => differ(cast_slice(&a.corners), cast_slice(&b.corners)),
            "scene_materials" => differ(cast_slice(&a.materials), cast_slice(&b.materials)),
            "scene_texels" => a.texels != b.texels,
            "scene_environment" => differ(
                cast_slice(&a.environment.texels),
                cast_slice(&b.environment.texels),
            ),
            "scene_emitters" => differ(
                cast_slice(&a.emitters.emitters),
                cast_slice(&b.emitters.emitters),
            ),
            "scene_wide_nodes" => differ(cast_slice(&a.wide.nodes), cast_slice(&b.wide.nodes)),
            "scene_wide_packets" => {
                differ(cast_slice(&a.wide.packets), cast_slice(&b.wide.packets))
            }
            // Small, or all of it changes with anything that moves.
            _ => true,
        }
    }
}

/// An environment of which nothing has to be put right.
fn sound(environment: &Environment) -> Option<Environment> {
    let is_light = |texel: &Vec3| {
        texel.cmpge(Vec3::ZERO).all() && texel.cmple(Vec3::splat(MOST_RADIANCE)).all()
    };
    let sound = match environment {
        Environment::Constant(_) => true,
        Environment::Map(map) => map.texels.iter().all(is_light),
        _ => false,
    };
    sound.then(|| environment.clone())
}

impl Before {
    /// Whether the lights and whether the sky are others now.
    pub fn differs(&self, lit: &Lit) -> (bool, bool) {
        let now: &[u8] = cast_slice(&lit.device.lights);
        (
            cast_slice::<Light, u8>(&self.lights) != now,
            self.sky.is_some(),
        )
    }
}

/// What can be told cheaply of the geometry of a scene in a pose.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Vertices, triangles and material of each mesh.
    meshes: Vec<(usize, usize, u32)>,
    materials: usize,
    nodes: Vec<DrawnNode>,
}

#[derive(Clone, Debug)]
struct DrawnNode {
    node: usize,
    meshes: Vec<u32>,
    /// Of the node, or of the joints that move its meshes.
    places: Vec<DAffine3>,
}

impl Drawn {
    fn of(scene: &Scene, pose: &Pose) -> Self {
        let drawn = scene.nodes.iter().enumerate();
        let drawn = drawn.filter(|(_, node)| !node.meshes.is_empty());
        let place = |node: usize| pose.world.get(node).copied().unwrap_or_default();
        Self {
            meshes: scene
                .meshes
                .iter()
                .map(|mesh| (mesh.positions.len(), mesh.triangles.len(), mesh.material))
                .collect(),
            materials: scene.materials.len(),
            nodes: drawn
                .map(|(i, node)| {
                    let skin = node.skin.and_then(|skin| scene.skins.get(skin as usize));
                    let places = match skin {
                        Some(skin) => skin.joints.iter().map(|&j| place(j as usize)).collect(),
                        None => vec![place(i)],
                    };
                    DrawnNode {
                        node: i,
                        meshes: node.meshes.clone(),
                        places,
                    }
                })
                .collect(),
        }
    }

    /// What tells a scene's geometry from this one, if anything does.
    pub fn difference(&self, scene: &Scene, pose: &Pose) -> Option<String> {
        let other = Self::of(scene, pose);
        let counts = [
            ("meshes", self.meshes.len(), other.meshes.len()),
            ("materials", self.materials, other.materials),
            ("nodes that draw", self.nodes.len(), other.nodes.len()),
        ];
        for (what, had, has) in counts {
            if had != has {
                return Some(format!("{has} {what} instead of {had}"));
            }
        }
        let mut meshes = self.meshes.iter().zip(&other.meshes);
        if let Some(i) = meshes.position(|(a, b)| a != b) {
            return Some(format!(
                "mesh {i} has other vertices or triangles, or another material"
            ));
        }
        self.nodes.iter().zip(&other.nodes).find_map(|(a, b)| {
            let node = b.node;
            if (a.node, &a.meshes) != (node, &b.meshes) {
                Some(format!("node {node} draws other meshes"))
            } else if a.places != b.places {
                Some(format!("node {node} has moved"))
            } else {
                None
            }
        })
    }
}
