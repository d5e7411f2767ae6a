//! From a file's bytes to the typed glTF document.
use super::error::ImportError;
use super::warnings::Warnings;
use gltf::json;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Extensions that are read.
pub(super) const SUPPORTED: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions without effect on diffuse light, passed over in silence.
const WITHOUT_EFFECT: &[&str] = &[
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_volume",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Extensions that store the same content differently, with what to do; optional uses are judged where they occur.
const OTHER_STORAGE: &[(&str, &str)] = &[
    (
        "KHR_draco_mesh_compression",
        "export it without Draco compression",
    ),
    (
        "EXT_meshopt_compression",
        "export it without meshopt compression",
    ),
    (
        "KHR_meshopt_compression",
        "export it without meshopt compression",
    ),
    (
        "KHR_texture_basisu",
        "convert its KTX2 textures to PNG or JPEG",
    ),
    (
        "EXT_texture_webp",
        "convert its WebP textures to PNG or JPEG",
    ),
    (
        "EXT_texture_avif",
        "convert its AVIF textures to PNG or JPEG",
    ),
    (
        "MSFT_texture_dds",
        "convert its DDS textures to PNG or JPEG",
    ),
];

/// A parsed document.
pub(super) struct Document {
    /// The glTF file.
    pub(super) file: PathBuf,
    /// Its JSON.
    pub(super) root: json::Root,
    /// The same as text says it, for what the typed form cannot hold.
    pub(super) value: Value,
    /// The binary chunk of a GLB.
    pub(super) bin: Option<Vec<u8>>,
}

/// Reads and parses a file, and judges its version and extensions.
pub(super) fn read(path: &Path, warnings: &mut Warnings) -> Result<Document, ImportError> {
    let bytes = crate::files::read(path).map_err(|source| ImportError::Read {
        file: path.to_owned(),
        source,
    })?;
    let format = |problem| ImportError::Format {
        file: path.to_owned(),
        problem,
    };
    let (text, bin) = if bytes.starts_with(b"glTF") {
        split_glb(&bytes).map_err(format)?
    } else {
        (bytes.as_slice(), None)
    };
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut value: Value = serde_json::from_slice(text)
        .map_err(|e| format(format!("its JSON is broken: {e}; export it again")))?;
    check_version(&value).map_err(format)?;
    tidy(&mut value, warnings);
    let root = match json::Root::deserialize(&value) {
        Ok(root) => root,
        Err(error) => {
            let place = locate(&value).unwrap_or_else(|| error.to_string());
            return Err(format(format!("{place}; correct it or export it again")));
        }
    };
    check_extensions(path, &root, warnings)?;
    Ok(Document {
        file: path.to_owned(),
        root,
        value,
        bin: bin.map(<[u8]>::to_vec),
    })
}

/// JSON and binary chunk of a GLB (glTF 2.0, 4.4). Chunks of other types are skipped.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the GLB header is cut off; copy or export it again".to_owned());
    };
    if version != 2 {
        return Err(format!(
            "it is a GLB of version {version}, only version 2 is read; export it as glTF 2.0"
        ));
    }
    let end = length as usize;
    if end > bytes.len() {
        return Err(format!(
            "the GLB is cut off: its header says {end} bytes, it has {}; copy or export it again",
            bytes.len()
        ));
    }
    let (mut text, mut bin) = (None, None);
    let mut at = 12usize;
    while at.saturating_add(8) <= end {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            break;
        };
        let chunk = (at + 8)
            .checked_add(size as usize)
            .filter(|&to| to <= end)
            .map(|to| &bytes[at + 8..to]);
        let chunk = chunk.ok_or_else(|| {
            format!(
                "the GLB chunk at byte {at} says {size} bytes, more than there are; copy or export it again"
            )
        })?;
        match &kind.to_le_bytes() {
            b"JSON" if text.is_none() => text = Some(chunk),
            b"BIN\0" if bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        at += 8 + chunk.len();
    }
    let text = text.ok_or("the GLB has no JSON chunk; copy or export it again")?;
    Ok((text, bin))
}

fn check_version(value: &Value) -> Result<(), String> {
    let asset = |key: &str| {
        value
            .get("asset")
            .and_then(|asset| asset.get(key))
            .and_then(Value::as_str)
    };
    let version = asset("version")
        .ok_or("it has no asset.version, so it is no glTF; give a glTF 2.0 file")?;
    if version.split('.').next() != Some("2") {
        return Err(format!(
            "it is glTF {version}, only 2.0 is read; export it as glTF 2.0"
        ));
    }
    match asset("minVersion") {
        Some(least) if least != "2.0" => Err(format!(
            "it needs glTF {least}, only 2.0 is read; export it as glTF 2.0"
        )),
        _ => Ok(()),
    }
}

/// Takes away what the document's types cannot hold although glTF allows it: free-form `extras`, channels that target
/// no node; and adds the node list that a scene may omit.
fn tidy(value: &mut Value, warnings: &mut Warnings) {
    for scene in list(value, "scenes") {
        if let Some(scene) = scene.as_object_mut() {
            scene
                .entry("nodes")
                .or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    for animation in list(value, "animations") {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            channels.retain(|channel| {
                let target = channel.get("target");
                let kept = target.is_none_or(|target| !target.is_object() || target.get("node").is_some());
                if !kept {
                    warnings.once("channel target", || {
                        "animation channels that target no node are not supported and stay still".to_owned()
                    });
                }
                kept
            });
        }
    }
    drop_extras(value);
}

fn list<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    value
        .get_mut(key)
        .and_then(Value::as_array_mut)
        .into_iter()
        .flatten()
}

/// Removes `extras` everywhere. The parser bounds the depth of the JSON, and so this recursion.
fn drop_extras(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.remove("extras");
            map.values_mut().for_each(drop_extras);
        }
        Value::Array(list) => list.iter_mut().for_each(drop_extras),
        _ => {}
    }
}

/// Names the first element that does not parse, by its place in the JSON.
fn locate(value: &Value) -> Option<String> {
    fn first<T: DeserializeOwned>(value: &Value, key: &str) -> Option<String> {
        let elements = match value.get(key)? {
            Value::Array(elements) => elements,
            _ => return Some(format!("{key} is not a list")),
        };
        elements.iter().enumerate().find_map(|(i, element)| {
            let error = serde_json::from_value::<T>(element.clone()).err()?;
            Some(format!("{key}[{i}]: {error}"))
        })
    }
    first::<json::Accessor>(value, "accessors")
        .or_else(|| first::<json::Animation>(value, "animations"))
        .or_else(|| first::<json::Buffer>(value, "buffers"))
        .or_else(|| first::<json::buffer::View>(value, "bufferViews"))
        .or_else(|| first::<json::Camera>(value, "cameras"))
        .or_else(|| first::<json::Image>(value, "images"))
        .or_else(|| first::<json::Material>(value, "materials"))
        .or_else(|| first::<json::Mesh>(value, "meshes"))
        .or_else(|| first::<json::Node>(value, "nodes"))
        .or_else(|| first::<json::texture::Sampler>(value, "samplers"))
        .or_else(|| first::<json::Scene>(value, "scenes"))
        .or_else(|| first::<json::Skin>(value, "skins"))
        .or_else(|| first::<json::Texture>(value, "textures"))
}

fn check_extensions(
    path: &Path,
    root: &json::Root,
    warnings: &mut Warnings,
) -> Result<(), ImportError> {
    let known = |name: &str| SUPPORTED.contains(&name) || WITHOUT_EFFECT.contains(&name);
    let storage = |name: &str| OTHER_STORAGE.iter().find(|(other, _)| *other == name);
    let required: Vec<&str> = root
        .extensions_required
        .iter()
        .map(String::as_str)
        .filter(|name| !known(name))
        .collect();
    if !required.is_empty() {
        let mut remedies: Vec<&str> = required
            .iter()
            .filter_map(|name| storage(name))
            .map(|&(_, remedy)| remedy)
            .collect();
        remedies.dedup();
        if remedies.is_empty() {
            remedies.push("export it without them");
        }
        return Err(ImportError::Extensions {
            file: path.to_owned(),
            names: required.join(", "),
            remedy: remedies.join(" and "),
        });
    }
    for name in root
        .extensions_used
        .iter()
        .filter(|name| !known(name) && storage(name).is_none())
    {
        warnings.push(format!(
            "the glTF extension {name} is not supported and has no effect"
        ));
    }
    Ok(())
}
