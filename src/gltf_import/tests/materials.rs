use super::*;
use gibs_passes::scene::{AlphaMode, LightKind, Wrap};
use glam::{Vec2, Vec3};

/// Gives the triangle material 0 with a 2x1 texture in the buffer, and texture coordinates where it has none.
pub(super) fn add_texture(gltf: &mut Gltf) {
    let view = gltf.view(&png(2, 1, [10, 20, 30, 40]));
    gltf.root["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    gltf.root["textures"] = json!([{"source": 0}]);
    gltf.root["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    if gltf.primitive()["attributes"].get("TEXCOORD_0").is_none() {
        let uvs = gltf.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
        gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    }
    gltf.primitive()["material"] = json!(0);
}

fn textured() -> Gltf {
    let mut gltf = Gltf::triangle();
    add_texture(&mut gltf);
    gltf
}

#[test]
fn without_a_material_the_default_one_is_white_and_opaque() {
    let scene = Gltf::triangle().scene();
    let material = &scene.materials[scene.meshes[0].material as usize];
    assert_eq!(
        (material.base_color, material.alpha, material.emission),
        (Vec3::ONE, 1.0, Vec3::ZERO)
    );
    assert_eq!(material.alpha_mode, AlphaMode::Opaque);
    assert!(!material.double_sided);
}

#[test]
fn factors_and_modes_are_read() {
    let mut gltf = Gltf::triangle();
    gltf.root["materials"] = json!([{
        "name": "m",
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 1},
        "emissiveFactor": [0.5, 0, 1],
        "alphaMode": "MASK",
        "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_transmission": {"transmissionFactor": 0.75},
            "KHR_materials_ior": {"ior": 1.3},
        },
    }]);
    gltf.root["extensionsUsed"] = json!([
        "KHR_materials_emissive_strength",
        "KHR_materials_transmission",
        "KHR_materials_ior"
    ]);
    gltf.primitive()["material"] = json!(0);
    let material = gltf.scene().materials.remove(0);
    assert_eq!(material.name, "m");
    assert_eq!(
        (material.base_color, material.alpha),
        (Vec3::new(0.1, 0.2, 0.3), 0.4)
    );
    assert_eq!(material.emission, Vec3::new(4.0, 0.0, 8.0));
    assert_eq!(
        (material.alpha_mode, material.transmission),
        (AlphaMode::Mask(0.5), 0.75)
    );
    assert!(material.double_sided);
    gltf.root["materials"][0]["alphaCutoff"] = json!(0.25);
    assert_eq!(gltf.scene().materials[0].alpha_mode, AlphaMode::Mask(0.25));
    gltf.root["materials"][0]["alphaMode"] = json!("BLEND");
    assert_eq!(gltf.scene().materials[0].alpha_mode, AlphaMode::Blend);
}

#[test]
fn the_diffuse_part_of_specular_glossiness_is_the_base_colour() {
    let mut gltf = textured();
    gltf.root["materials"] = json!([{"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": {"index": 0}, "glossinessFactor": 0.1,
    }}}]);
    let material = gltf.scene().materials.remove(0);
    assert_eq!(
        (material.base_color, material.alpha),
        (Vec3::new(0.1, 0.2, 0.3), 0.4)
    );
    assert_eq!(material.base_color_texture.map(|t| t.texture), Some(0));
}

#[test]
fn textures_are_decoded_with_their_sampler() {
    let mut gltf = textured();
    gltf.root["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    gltf.root["textures"][0]["sampler"] = json!(0);
    let scene = gltf.scene();
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height), (2, 1));
    assert_eq!(texture.texels, [[10, 20, 30, 40]; 2]);
    let used = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(
        (
            used.sampler.wrap_u,
            used.sampler.wrap_v,
            used.sampler.nearest
        ),
        (Wrap::Clamp, Wrap::Mirror, true)
    );
    assert_eq!(
        used.transform.transform_point2(Vec2::new(0.3, 0.7)),
        Vec2::new(0.3, 0.7)
    );
    assert_eq!(scene.meshes[0].uvs, [Vec2::ZERO, Vec2::X, Vec2::Y]);
}

/// Offset times rotation times scale; with v pointing down, a quarter turn counter-clockwise takes +u to -v.
#[test]
fn texture_transforms_scale_then_turn_then_shift() {
    let mut gltf = textured();
    gltf.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = json!({
        "KHR_texture_transform":
            {"offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1}
    });
    let uvs = gltf.floats("VEC2", &[1., 1., 0., 0., 1., 0.]);
    gltf.primitive()["attributes"]["TEXCOORD_1"] = json!(uvs);
    let scene = gltf.scene();
    let transform = scene.materials[0].base_color_texture.unwrap().transform;
    let corner = transform.transform_point2(Vec2::X);
    assert!(
        (corner - Vec2::new(0.25, 0.5 - 2.0)).length() < 1e-6,
        "{corner}"
    );
    let corner = transform.transform_point2(Vec2::Y);
    assert!(
        (corner - Vec2::new(0.25 + 3.0, 0.5)).length() < 1e-6,
        "{corner}"
    );
    // The set named by the transform counts.
    assert_eq!(scene.meshes[0].uvs[0], Vec2::ONE);
}

#[test]
fn a_second_set_of_coordinates_for_emission_is_a_warning() {
    let mut gltf = textured();
    gltf.root["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    gltf.root["materials"][0]["emissiveTexture"] = json!({"index": 0});
    let scene = gltf.scene();
    assert_eq!(
        scene.materials[0].emission_texture,
        scene.materials[0].base_color_texture
    );
    assert_eq!(scene.textures.len(), 1);
    gltf.root["materials"][0]["emissiveTexture"]["texCoord"] = json!(1);
    only_warning(&gltf.import(), "texture coordinates 1");
}

/// Emission alone decides the set; black emission needs no texture.
#[test]
fn emission_textures_are_read_where_they_show() {
    let mut gltf = textured();
    let uvs = gltf.floats("VEC2", &[1., 1., 0., 0., 1., 0.]);
    gltf.primitive()["attributes"]["TEXCOORD_2"] = json!(uvs);
    gltf.root["materials"] =
        json!([{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0, "texCoord": 2}}]);
    let scene = gltf.scene();
    assert_eq!(scene.meshes[0].uvs[0], Vec2::ONE);
    assert_eq!(
        scene.materials[0].emission_texture.map(|t| t.texture),
        Some(0)
    );
    gltf.root["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    let scene = gltf.scene();
    assert!(scene.textures.is_empty() && scene.materials[0].emission_texture.is_none());
}

#[test]
fn images_that_no_surface_shows_are_not_read() {
    let mut gltf = textured();
    push(&mut gltf.root["images"], json!({"uri": "missing.png"}));
    push(&mut gltf.root["textures"], json!({"source": 1}));
    gltf.root["materials"][0]["occlusionTexture"] = json!({"index": 1});
    let unused = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}});
    push(&mut gltf.root["materials"], unused);
    let scene = gltf.scene();
    assert_eq!((scene.textures.len(), scene.materials.len()), (1, 1));
}

#[test]
fn images_that_cannot_be_read_leave_the_factor_and_a_warning() {
    let mut broken = png(2, 1, [0; 4]);
    broken.truncate(40);
    for (image, part) in [
        (json!({"uri": "missing.png"}), "missing.png"),
        (json!({"uri": data_uri(&broken)}), "cannot be decoded"),
        (json!({"uri": data_uri(b"RIFF\0\0\0\0WEBPVP8 ")}), "WebP"),
        (json!({"uri": data_uri(b"\xabKTX 20\xbb\r\n\x1a\n")}), "KTX"),
        (json!({"uri": "data:image/png;base64,???"}), "base64"),
        (json!({"bufferView": 77}), "bufferView 77"),
        (json!({}), "neither"),
    ] {
        let mut gltf = textured();
        gltf.root["images"][0] = image;
        let imported = gltf.import();
        only_warning(&imported, part);
        only_warning(&imported, "images[0]");
        only_warning(&imported, "test.gltf");
        assert!(imported.scene.materials[0].base_color_texture.is_none());
        assert!(imported.scene.textures.is_empty());
    }
}

#[test]
fn textures_in_other_formats_fall_back_to_their_plain_image() {
    let mut gltf = textured();
    gltf.root["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    gltf.root["textures"][0]["extensions"] = json!({"KHR_texture_basisu": {"source": 0}});
    assert_eq!(gltf.scene().textures.len(), 1);
    gltf.root["textures"][0]
        .as_object_mut()
        .unwrap()
        .remove("source");
    let imported = gltf.import();
    only_warning(&imported, "KHR_texture_basisu");
    only_warning(&imported, "PNG or JPEG");
    assert!(imported.scene.textures.is_empty());
}

#[test]
fn what_is_not_supported_is_named_once() {
    let mut gltf = textured();
    let transmission = json!({"KHR_materials_transmission":
        {"transmissionFactor": 0.5, "transmissionTexture": {"index": 0}}});
    gltf.root["materials"][0]["normalTexture"] = json!({"index": 0});
    gltf.root["materials"][0]["extensions"] = transmission;
    let (material, primitive) = (gltf.root["materials"][0].clone(), gltf.primitive().clone());
    push(&mut gltf.root["materials"], material);
    push(&mut gltf.root["meshes"][0]["primitives"], primitive);
    gltf.root["meshes"][0]["primitives"][1]["material"] = json!(1);
    gltf.root["extensionsUsed"] = json!([
        "KHR_materials_unlit",
        "KHR_materials_clearcoat",
        "KHR_materials_volume"
    ]);
    let warnings = gltf.import().warnings;
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    for (warning, part) in
        warnings
            .iter()
            .zip(["KHR_materials_unlit", "transmission texture", "normal maps"])
    {
        assert!(warning.contains(part), "{warning}");
    }
}

#[test]
fn a_texture_without_coordinates_is_a_warning() {
    let mut gltf = textured();
    gltf.primitive()["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_0");
    only_warning(&gltf.import(), "TEXCOORD_0");
}

#[test]
fn punctual_lights_of_all_kinds_sit_in_their_nodes() {
    let mut gltf = Gltf::triangle();
    gltf.root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    gltf.root["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 4},
        {"type": "point", "range": 3},
        {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "spot", "spot": {}},
    ]}});
    let light = |i: u32| json!({"extensions": {"KHR_lights_punctual": {"light": i}}});
    gltf.root["nodes"] = json!([{"mesh": 0}, light(2), light(0), light(1), light(3)]);
    let scene = gltf.scene();
    let found: Vec<_> = scene
        .lights
        .iter()
        .map(|light| (light.node, light.kind, light.intensity))
        .collect();
    let spot = |inner, outer| LightKind::Spot { inner, outer };
    assert_eq!(
        found,
        [
            (1, spot(0.25, 0.5), Vec3::splat(2.0)),
            (2, LightKind::Directional, Vec3::new(4.0, 2.0, 0.0)),
            (3, LightKind::Point, Vec3::ONE),
            (4, spot(0.0, std::f32::consts::FRAC_PI_4), Vec3::ONE),
        ]
    );
}
