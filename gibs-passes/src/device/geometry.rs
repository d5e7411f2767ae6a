//! Meshes into bottom levels, nodes into instances.
use super::{DeviceSceneError, relative};
use crate::accel::{BlasInput, InstanceInput, LeftOut, MAX_COORDINATE, MeshPart, TwoLevel, Wide};
use crate::data::{Corners, Instance, NONE};
use crate::scene::{AlphaMode, Material, Mesh, Pose, SceneDataError, Sound, label, posed};
use crate::shared::octahedral;
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// The geometry of a posed scene.
pub(super) struct Geometry {
    pub tree: TwoLevel,
    pub wide: Wide,
    pub corners: Vec<Corners>,
    pub bounds: (Vec3, Vec3),
    pub warnings: Vec<String>,
}

/// A mesh of a bottom level, before borrowing.
struct Part {
    mesh: u32,
    /// Posed positions; `None` takes those of the mesh.
    positions: Option<Vec<Vec3>>,
    transform_ids: Vec<u32>,
    first_primitive: u32,
}

struct Level {
    parts: Vec<Part>,
}

pub(super) fn build(
    scene: &Sound<'_>,
    pose: &Pose,
    origin: DVec3,
) -> Result<Geometry, DeviceSceneError> {
    let mut corners = Vec::new();
    let mut levels: Vec<Level> = Vec::new();
    let mut instances = Vec::new();
    // Nodes that draw the same rigid meshes share a bottom level.
    let mut shared: HashMap<&[u32], u32> = HashMap::new();
    for (id, node) in scene
        .nodes
        .iter()
        .enumerate()
        .filter(|(_, node)| !node.meshes.is_empty())
    {
        let id = id as u32;
        if node.skin.is_some() {
            let level = skinned_level(scene, pose, origin, id, &mut corners)?;
            levels.push(level);
            instances.push(InstanceInput {
                blas: levels.len() as u32 - 1,
                object_to_world: DAffine3::IDENTITY,
                transform_id: id,
            });
            continue;
        }
        let blas = *shared.entry(&node.meshes).or_insert_with(|| {
            levels.push(rigid_level(scene, &node.meshes, &mut corners));
            levels.len() as u32 - 1
        });
        let object_to_world = relative(&pose.world[id as usize], origin);
        instances.push(InstanceInput {
            blas,
            object_to_world,
            transform_id: id,
        });
    }
    let parts: Vec<Vec<MeshPart<'_>>> = levels
        .iter()
        .map(|level| level.parts.iter().map(|part| borrow(scene, part)).collect())
        .collect();
    let inputs: Vec<BlasInput<'_>> = parts.iter().map(|parts| BlasInput { parts }).collect();
    let tree = TwoLevel::build(&inputs, &instances)?;
    let wide = Wide::build(&tree);
    let warnings = left_out(scene, &tree);
    let bounds = bounds(scene, &levels, &instances, &tree);
    Ok(Geometry {
        tree,
        wide,
        corners,
        bounds,
        warnings,
    })
}

/// One warning for each reason to leave nodes out, and one if none is left.
fn left_out(scene: &Sound<'_>, tree: &TwoLevel) -> Vec<String> {
    let left_out = &tree.stats.left_out;
    let mut reasons: Vec<LeftOut> = Vec::new();
    for &(_, why) in left_out {
        if !reasons.contains(&why) {
            reasons.push(why);
        }
    }
    let mut warnings: Vec<String> = reasons
        .iter()
        .filter_map(|why| {
            let mut nodes = left_out.iter().filter(|(_, other)| other == why);
            let first = tree.instances[nodes.next()?.0 as usize].transform_id as usize;
            let first = label("node", first, &scene.nodes[first].name);
            Some(match nodes.count() {
                0 => format!("{first} is left out: {why}"),
                more => format!(
                    "{} nodes are left out; of the first, {first}: {why}",
                    more + 1
                ),
            })
        })
        .collect();
    if left_out.len() == tree.instances.len() {
        warnings.push(
            "the scene has no triangles to draw, the picture shows only the sky; give a node a mesh with triangles"
                .to_owned(),
        );
    }
    warnings
}

fn borrow<'a>(scene: &'a Sound<'_>, part: &'a Part) -> MeshPart<'a> {
    let mesh = &scene.meshes[part.mesh as usize];
    MeshPart {
        positions: part.positions.as_deref().unwrap_or(&mesh.positions),
        triangles: &mesh.triangles,
        material: mesh.material,
        alpha_test: needs_alpha(&scene.materials[mesh.material as usize]),
        first_primitive: part.first_primitive,
        transform_id: NONE,
        transform_ids: &part.transform_ids,
    }
}

/// Light can pass through some of the surface.
pub(super) fn needs_alpha(material: &Material) -> bool {
    material.alpha_mode != AlphaMode::Opaque || material.transmission > 0.0
}

fn rigid_level(scene: &Sound<'_>, meshes: &[u32], corners: &mut Vec<Corners>) -> Level {
    let parts = meshes
        .iter()
        .map(|&mesh| {
            let first_primitive = corners.len() as u32;
            let drawn = &scene.meshes[mesh as usize];
            push_corners(drawn, &drawn.normals, corners);
            Part {
                mesh,
                positions: None,
                transform_ids: Vec::new(),
                first_primitive,
            }
        })
        .collect();
    Level { parts }
}

/// Skinned meshes are posed in the world; each triangle moves with the joint that most of its vertices follow.
fn skinned_level(
    scene: &Sound<'_>,
    pose: &Pose,
    origin: DVec3,
    node: u32,
    corners: &mut Vec<Corners>,
) -> Result<Level, DeviceSceneError> {
    let drawing = &scene.nodes[node as usize];
    let skin = drawing.skin.map(|skin| &scene.skins[skin as usize]);
    let parts = drawing
        .meshes
        .iter()
        .map(|&mesh| {
            let first_primitive = corners.len() as u32;
            let drawn: &Mesh = &scene.meshes[mesh as usize];
            let posed = posed(drawn, skin, pose, node);
            let positions: Vec<Vec3> = posed
                .positions
                .iter()
                .map(|&p| (p - origin).as_vec3())
                .collect();
            // Not `>`: the comparison must also fail for NaN.
            let is_near = |p: &Vec3| p.abs().cmplt(Vec3::splat(MAX_COORDINATE)).all();
            if let Some(v) = positions.iter().position(|p| !is_near(p)) {
                let node = label("node", node as usize, &drawing.name);
                let mesh = label("mesh", mesh as usize, &drawn.name);
                return Err(DeviceSceneError::Scene(SceneDataError::Value {
                    element: format!("{mesh}, vertex {v}, as the skin of {node} poses it"),
                    what: "position".to_owned(),
                    value: posed.positions[v].to_string(),
                    expected: "finite and less than 1e12 away; bring the joints closer",
                }));
            }
            push_corners(drawn, &posed.normals, corners);
            let joint = |v: u32| posed.dominant_joint[v as usize];
            let follows = |t: &[u32; 3]| {
                let [a, b, c] = t.map(joint);
                if b == c { b } else { a }
            };
            Ok(Part {
                mesh,
                positions: Some(positions),
                transform_ids: drawn.triangles.iter().map(follows).collect(),
                first_primitive,
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(Level { parts })
}

fn push_corners(mesh: &Mesh, normals: &[Vec3], corners: &mut Vec<Corners>) {
    let smooth = u32::from(!normals.is_empty());
    corners.extend(mesh.triangles.iter().map(|triangle| Corners {
        normals: triangle.map(|v| normals.get(v as usize).map_or(0, |&n| packed(n))),
        smooth,
        uvs: triangle.map(|v| mesh.uvs.get(v as usize).copied().unwrap_or(Vec2::ZERO)),
    }));
}

/// Packing takes a normal of any length whose components sum up to a number.
fn packed(normal: Vec3) -> u32 {
    if normal.length_squared().is_finite() {
        octahedral::pack(normal)
    } else {
        octahedral::pack(normal.as_dvec3().normalize().as_vec3())
    }
}

/// Corners of the box of all that rays can hit.
fn bounds(
    scene: &Sound<'_>,
    levels: &[Level],
    instances: &[InstanceInput],
    tree: &TwoLevel,
) -> (Vec3, Vec3) {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (instance, placed) in instances.iter().zip(&tree.instances) {
        if placed.flags & Instance::LEFT_OUT != 0 {
            continue;
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in &levels[instance.blas as usize].parts {
            let own = &scene.meshes[part.mesh as usize].positions;
            for &p in part.positions.as_ref().unwrap_or(own) {
                low = low.min(p);
                high = high.max(p);
            }
        }
        for i in 0..8 {
            let pick = |bit: u32, low: f32, high: f32| {
                f64::from(if i >> bit & 1 == 0 { low } else { high })
            };
            let corner = DVec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            );
            let p = instance.object_to_world.transform_point3(corner);
            min = min.min(p);
            max = max.max(p);
        }
    }
    if min.x > max.x {
        (Vec3::ZERO, Vec3::ZERO)
    } else {
        (min.as_vec3(), max.as_vec3())
    }
}
