//! Textures, their samplers and coordinates, tangents and vertex colours.

use emlt::scene::texture::{IDENTITY, Texture, Wrap};
use glam::{Vec2, Vec4, vec2, vec4};

use super::*;

/// A PNG of `width` columns of 8-bit RGBA.
pub fn png_bytes(width: u32, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, pixels.len() as u32 / width);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(pixels.as_flattened()).unwrap();
    bytes
}

/// The smallest JPEG: 8 x 8 pixels of grey 153 (a DC coefficient of 200 and nothing else).
fn jpeg_bytes() -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
    bytes.extend([1; 64]);
    bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
    // One code each, of one bit: a DC difference of 8 bits, and the end of the block.
    for (table, symbol) in [(0x00, 8), (0x10, 0)] {
        bytes.extend([0xff, 0xc4, 0, 20, table, 1]);
        bytes.extend([0; 15]);
        bytes.push(symbol);
    }
    bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x64, 0x3f, 0xff, 0xd9]);
    bytes
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 128];

/// One triangle with coordinates and a material, and one texture that shows `image`.
pub fn textured(image: &[u8], material: Value) -> Doc {
    let mut doc = with_material(material);
    let view = doc.view(image);
    doc.json["images"] = json!([{ "bufferView": view }]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    let attributes = [("TEXCOORD_0", [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]), ("TEXCOORD_3", [[0.5f32, 0.25]; 3])];
    for (name, pairs) in attributes {
        let bytes: Vec<u8> = pairs.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let accessor = doc.accessor(&bytes, F32, "VEC2", 3);
        doc.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }
    doc
}

fn base_color() -> Value {
    json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } })
}

#[test]
fn png_jpeg_and_webp_are_decoded() {
    let scene = textured(&png_bytes(2, &[RED, GREEN]), base_color()).scene();
    assert_eq!((scene.images[0].width, scene.images[0].height), (2, 1));
    assert_eq!(scene.images[0].texels, [u32::from_le_bytes(RED), u32::from_le_bytes(GREEN)]);
    let texture = scene.materials[0].textures.base_color.as_ref().unwrap();
    let whole = Texture { image: 0, srgb: true, linear: true, wrap: [Wrap::Repeat; 2], slot: 0, transform: IDENTITY };
    assert_eq!(*texture, whole);
    assert_eq!(scene.coordinates[0][0], Vec2::Y);
    assert!(!warned(&scene, "exture"), "{:?}", scene.warnings);

    let scene = textured(&jpeg_bytes(), base_color()).scene();
    assert_eq!(scene.images[0].texels, [u32::from_le_bytes([153, 153, 153, 255]); 64]);

    let mut webp = Vec::new();
    let encoder = image_webp::WebPEncoder::new(&mut webp);
    encoder.encode([RED, GREEN].as_flattened(), 2, 1, image_webp::ColorType::Rgba8).unwrap();
    let mut doc = textured(&webp, base_color());
    doc.json["textures"] = json!([{ "source": 7, "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    assert_eq!(doc.scene().images[0].texels, [u32::from_le_bytes(RED), u32::from_le_bytes(GREEN)]);
}

#[test]
fn palettes_greys_and_16_bits_become_rgba() {
    let encoded = |color: png::ColorType, depth: png::BitDepth, data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == png::ColorType::Indexed {
            encoder.set_palette(vec![9, 8, 7, 1, 2, 3]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        textured(&bytes, base_color()).scene().images[0].texels.iter().map(|t| t.to_le_bytes()).collect::<Vec<_>>()
    };
    use png::{BitDepth, ColorType};
    assert_eq!(encoded(ColorType::Grayscale, BitDepth::One, &[0x40]), [[0, 0, 0, 255], [255; 4]]);
    assert_eq!(encoded(ColorType::Indexed, BitDepth::Two, &[0x40]), [[1, 2, 3, 255], [9, 8, 7, 255]]);
    assert_eq!(encoded(ColorType::Rgb, BitDepth::Sixteen, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0])[0], [1, 2, 3, 255]);
}

#[test]
fn samplers_sets_and_transforms() {
    let info = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform":
        { "offset": [0.25, 0.5], "rotation": FRAC_PI_2, "scale": [2, 3], "texCoord": 3 } } });
    let mut doc = textured(&png_bytes(1, &[RED]), json!({ "pbrMetallicRoughness": { "baseColorTexture": info } }));
    doc.json["textures"][0]["sampler"] = json!(0);
    doc.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33648, "wrapT": 33071 }]);
    let scene = doc.scene();
    let texture = scene.materials[0].textures.base_color.as_ref().unwrap();
    assert_eq!((texture.linear, texture.wrap), (false, [Wrap::Mirror, Wrap::Clamp]));
    assert_eq!(scene.coordinates[2][texture.slot], vec2(0.5, 0.25));
    // KHR_texture_transform: counter-clockwise as seen with v up, so (1, 0) goes to (0, -1) with v down.
    let at = |u: f32, v: f32| texture.transform.map(|row| row[0] * u + row[1] * v + row[2]);
    let near = |a: [f32; 2], b: [f32; 2]| assert!((vec2(a[0], a[1]) - vec2(b[0], b[1])).length() < 1e-6, "{a:?}");
    near(at(0.0, 0.0), [0.25, 0.5]);
    near(at(1.0, 0.0), [0.25, 0.5 - 2.0]);
    near(at(0.0, 1.0), [0.25 + 3.0, 0.5]);
}

#[test]
fn three_sets_of_coordinates_are_too_many() {
    let info = |set: u32| json!({ "index": 0, "texCoord": set });
    let doc = textured(
        &png_bytes(1, &[RED]),
        json!({ "pbrMetallicRoughness": { "baseColorTexture": info(0), "metallicRoughnessTexture": info(3) },
            "normalTexture": info(1) }),
    );
    let scene = doc.scene();
    assert!(scene.materials[0].textures.normal.is_none() && warned(&scene, "More than two sets"));
}

#[test]
fn roughness_textures_tell_their_mean_and_largest_alpha() {
    let green = |g: u8| [0, g, 0, 255];
    let material = json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.5,
        "metallicRoughnessTexture": { "index": 0 } } });
    let scene = textured(&png_bytes(2, &[green(0), green(204)]), material).scene();
    let [mean, most] = scene.materials[0].mapped_alpha.unwrap();
    assert!((mean - 0.5 * 0.16).abs() < 1e-6 && (most - 0.16).abs() < 1e-6, "{mean} {most}");
    assert!((scene.materials[0].alpha() - 0.08).abs() < 1e-6);
    assert!(scene.materials[0].is_narrow(0.1) && !scene.materials[0].is_narrow(0.05));
}

#[test]
fn emission_is_measured_by_triangle() {
    let lamp = json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } });
    // Nearest, so that the triangle (half of the square, cut from the lower left) sees three quarters of one column.
    let mut doc = textured(&png_bytes(2, &[[255, 255, 255, 255], [0, 0, 0, 255]]), lamp.clone());
    doc.json["textures"][0]["sampler"] = json!(0);
    doc.json["samplers"] = json!([{ "magFilter": 9728 }]);
    let scene = doc.scene();
    let mean = scene.mean_emission()[0];
    assert!((mean - 0.75).abs() < 0.02 && scene.sky.is_none(), "{mean}");

    let scene = textured(&png_bytes(1, &[[0, 0, 0, 255]]), lamp).scene();
    assert!(!scene.materials[0].emits() && scene.sky.is_some());
}

#[test]
fn tangents_are_made_where_a_normal_texture_needs_them() {
    let scene = textured(&png_bytes(1, &[RED]), json!({ "normalTexture": { "index": 0, "scale": 0.5 } })).scene();
    assert_eq!(scene.materials[0].textures.normal.as_ref().unwrap().1, 0.5);
    assert_eq!(scene.tangents, [vec4(1.0, 0.0, 0.0, 1.0); 3]);
    let mut doc = textured(&png_bytes(1, &[RED]), json!({ "normalTexture": { "index": 0 } }));
    let bytes: Vec<u8> = [[0.0f32, 1.0, 0.0, -1.0]; 3].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let accessor = doc.accessor(&bytes, F32, "VEC4", 3);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(accessor);
    doc.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    // Mirrored: the bitangent's sign turns with the handedness of space.
    assert_eq!(doc.scene().tangents, [vec4(0.0, 1.0, 0.0, 1.0); 3]);
}

#[test]
fn vertex_colors_multiply_where_there_are_any() {
    let mut doc = with_material(json!({}));
    let accessor = doc.accessor(&[255, 0, 51, 0, 255, 0, 51, 0, 255, 0, 51, 0], U8, "VEC3", 3);
    doc.json["bufferViews"][1]["byteStride"] = json!(4);
    doc.json["accessors"][accessor]["normalized"] = json!(true);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
    let scene = doc.scene();
    assert!(scene.materials[0].vertex_colored);
    assert!((scene.colors[1] - Vec4::new(1.0, 0.0, 0.2, 1.0)).length() < 1e-6, "{:?}", scene.colors);
    assert!(triangle().scene().colors.is_empty());
}

#[test]
fn images_that_are_wrong_are_named() {
    let error = |image: &[u8]| textured(image, base_color()).error();
    let good = png_bytes(2, &[RED, GREEN]);
    assert!(error(&good[..good.len() / 2]).contains("images[0] cannot be decoded"));
    assert!(error(b"GIF89a").contains("images[0] is no PNG"));
    let mut doc = textured(&good, base_color());
    doc.json["images"] = json!([{ "uri": "missing.png" }]);
    let sentence = doc.error();
    assert!(sentence.contains("materials[0]: .pbrMetallicRoughness.baseColorTexture: images[0]"), "{sentence}");
    let scene = textured(b"\xabKTX 20\xbb\r\n\x1a\n", base_color()).scene();
    assert!(warned(&scene, "Images other than PNG") && scene.materials[0].textures.base_color.is_none());
    for part in [json!({ "source": 3 }), json!({})] {
        let mut doc = textured(&good, base_color());
        doc.json["textures"] = json!([part]);
        let _ = doc.import();
    }
}
