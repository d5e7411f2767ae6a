//! Animation clips.
use super::error::ImportError;
use super::hierarchy::Tree;
use super::source::Source;
use super::warnings::Warnings;
use gibs_passes::scene::{Animation, Channel, Interpolation, Keyframes, NodeId};
use glam::{DQuat, DVec3};
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::animation::{Interpolation as Kind, Property};
use gltf::json::validation::Checked;

/// Every clip of the file, in its order, so that clip numbers stay; only channels that move nodes of the scene.
pub(super) fn read(
    source: &Source,
    tree: &Tree,
    warnings: &mut Warnings,
) -> Result<Vec<Animation>, ImportError> {
    let mut animations = Vec::with_capacity(source.root.animations.len());
    for (a, animation) in source.root.animations.iter().enumerate() {
        let mut channels = Vec::with_capacity(animation.channels.len());
        for (c, channel) in animation.channels.iter().enumerate() {
            let element = || format!("animations[{a}].channels[{c}]");
            source.get(&source.root.nodes, "node", channel.target.node, element)?;
            let sampler = source.get(&animation.samplers, "sampler", channel.sampler, element)?;
            let property = match channel.target.path {
                Checked::Valid(Property::MorphTargetWeights) => {
                    warnings.once("morph", || {
                        "morph targets are not supported; meshes keep their base shape".to_owned()
                    });
                    continue;
                }
                Checked::Valid(property) => property,
                Checked::Invalid => {
                    warnings.once("animation path", || {
                        format!("{} animates something other than a node's transform, which stays still", element())
                    });
                    continue;
                }
            };
            if let Some(node) = tree.id(channel.target.node) {
                let found = || {
                    let s = channel.sampler.value();
                    source.stated(&format!("/animations/{a}/samplers/{s}/interpolation"))
                };
                channels.push(read_channel(
                    source, node, property, sampler, &element, found,
                )?);
            }
        }
        animations.push(Animation {
            name: animation.name.clone().unwrap_or_default(),
            channels,
        });
    }
    Ok(animations)
}

fn read_channel(
    source: &Source,
    node: NodeId,
    property: Property,
    sampler: &json::animation::Sampler,
    element: &dyn Fn() -> String,
    stated_interpolation: impl FnOnce() -> String,
) -> Result<Channel, ImportError> {
    let interpolation = match sampler.interpolation {
        Checked::Valid(Kind::Linear) => Interpolation::Linear,
        Checked::Valid(Kind::Step) => Interpolation::Step,
        Checked::Valid(Kind::CubicSpline) => Interpolation::CubicSpline,
        Checked::Invalid => {
            let found = stated_interpolation();
            let problem =
                format!("has interpolation {found}; it must be LINEAR, STEP or CUBICSPLINE");
            return Err(source.error(element(), problem));
        }
    };
    let times = source.reals(sampler.input, &[Type::Scalar], element)?;
    let times: Vec<f32> = (0..times.count).map(|i| times.real::<1>(i)[0]).collect();
    let kind = if property == Property::Rotation {
        Type::Vec4
    } else {
        Type::Vec3
    };
    let values = source.reals(sampler.output, &[kind], element)?;
    let vectors = || {
        (0..values.count)
            .map(|i| DVec3::from(values.real::<3>(i).map(f64::from)))
            .collect()
    };
    let keyframes = match property {
        Property::Rotation => Keyframes::Rotation(
            (0..values.count)
                .map(|i| DQuat::from_array(values.real::<4>(i).map(f64::from)))
                .collect(),
        ),
        Property::Scale => Keyframes::Scale(vectors()),
        _ => Keyframes::Translation(vectors()),
    };
    Ok(Channel {
        node,
        times,
        keyframes,
        interpolation,
    })
}
