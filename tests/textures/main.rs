//! Textures on the device: look-ups against their twin in f64, and the three methods against each other.

#[allow(dead_code)]
mod room;

#[path = "../images/comparison.rs"]
mod comparison;
#[path = "../images/renders.rs"]
#[allow(dead_code)]
mod renders;
#[path = "../images/tiles.rs"]
mod tiles;

use comparison::{Power, Truth, check};
use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::gpu::layout::PassUniform;
use emlt::gpu::run::{Buffer, Dispatch, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::gpu::shader::Variant;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::reference::rng;
use emlt::scene::material::Material;
use emlt::scene::{Camera, Features, LUMINANCE, Lens, Scene, Texture};
use glam::{DVec2, DVec3, Vec4, vec3};
use renders::{render, replicates, settings};
use room::{glazed_room, layered_room, lit_room, orthographic_room, polished_room, room, unlit_wall, veiled_room};

/// What shaders/passes/surface_probe.wesl tells of points of a scene.
fn probe(scene: &Scene, points: &[[u32; 4]]) -> Vec<[[f32; 4]; 4]> {
    probe_split(scene, points, false)
}

fn probe_split(scene: &Scene, points: &[[u32; 4]], split: bool) -> Vec<[[f32; 4]; 4]> {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut data = SceneData::new(scene, &scene.cameras[0], 4, 4).unwrap();
    data.split = split;
    let n = points.len() as u64;
    let mut run =
        Run::new(&context, &data, Sizes { chains: 16 * n, lists: 16, output: 64 * n, counters: 256 }).unwrap();
    run.set_chains(0, bytemuck::cast_slice(points));
    let uniform = PassUniform { entries: n as u32, stride: n as u32, ..Default::default() };
    let features = Features { split, ..Features::of(scene) };
    let variant = Variant { pass: "surface_probe", features, max_edges: 4, flags: vec![] };
    run.submit(&[Dispatch { variant, uniform }]).unwrap();
    run.read(Buffer::Output, 0..64 * n).unwrap()
}

/// So many triangles as need buffers of their own for their edges are looked up there as in one.
#[test]
fn split_triangles_are_the_same() {
    let scene = room();
    let points: Vec<[u32; 4]> = (0..1000).map(|n| [n % 10, 0.3f32.to_bits(), (n as f32 * 6e-4).to_bits(), 0]).collect();
    assert_eq!(probe_split(&scene, &points, true), probe(&scene, &points));
}

/// Interpolation of what the corners of a triangle have.
fn between<T>(scene: &Scene, triangle: usize, [u, v]: [f64; 2], at: impl Fn(usize) -> T) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = scene.triangles[triangle].map(|i| at(i as usize));
    a * (1.0 - u - v) + b * u + c * v
}

#[test]
fn look_ups_are_their_twins() {
    let scene = room();
    let data = SceneData::new(&scene, &scene.cameras[0], 4, 4).unwrap();
    // Which source triangle each leaf is, by its first corner and first edge.
    let (centre, radius) = scene.bounding_sphere();
    let source: Vec<usize> = (data.triangles.chunks_exact(3))
        .map(|rows| {
            let same = |t: &[u32; 3]| {
                let [a, b, _] = t.map(|i| (scene.positions[i as usize] - centre) / radius);
                let near = |row: [f32; 4], v: glam::Vec3| (Vec4::from(row).truncate() - v).length() < 1e-5;
                near(rows[0], a) && near(rows[1], b - a)
            };
            scene.triangles.iter().position(same).unwrap()
        })
        .collect();
    let points: Vec<[u32; 4]> = (0..20_000u32)
        .map(|n| {
            let words = rng::random_words(3, n, 0, 0);
            let (a, b) = (rng::uniform(words[1]).sqrt(), rng::uniform(words[2]));
            let (u, v) = ((a * (1.0 - b)) as f32, (a * b) as f32);
            [words[0] % source.len() as u32, u.to_bits(), v.to_bits(), 0]
        })
        .collect();
    let means = scene.mean_emission();
    let total = data.uniform.light_weight;
    let mut off = 0;
    for (point, [color, normal, emission, f0]) in points.iter().zip(probe(&scene, &points)) {
        let triangle = source[point[0] as usize];
        let at = [point[1], point[2]].map(|bits| f64::from(f32::from_bits(bits)));
        let m = &scene.materials[scene.triangle_materials[triangle] as usize];
        let sample = |texture: &Option<Texture>| {
            let Some(texture) = texture else { return [1.0; 4] };
            let coordinates = between(&scene, triangle, at, |i| scene.coordinates[i][texture.slot].as_dvec2());
            texture.sample(&scene.images, DVec2::to_array(&coordinates))
        };
        let rgb = |[r, g, b, _]: [f64; 4]| DVec3::new(r, g, b);
        let t = &m.textures;
        let painted = between(&scene, triangle, at, |i| scene.colors[i].as_dvec4()).truncate();
        let paint = if m.vertex_colored { painted } else { DVec3::ONE };
        let base = m.base_color.as_dvec3() * rgb(sample(&t.base_color)) * paint;
        let [_, green, blue, _] = sample(&t.metallic_roughness);
        let rough = f64::from(m.roughness * m.roughness) * green * green;
        let alpha = if m.is_narrow(0.1) { -rough } else { rough };
        let light = m.emission.as_dvec3() * rgb(sample(&t.emissive));
        let specular = sample(&t.specular)[3] * f64::from(m.specular);
        let dielectric =
            (0.04 * m.specular_color.as_dvec3() * rgb(sample(&t.specular_color))).min(DVec3::ONE) * specular;
        let upright = between(&scene, triangle, at, |i| scene.normals[i].as_dvec3());
        let expected_normal = t.normal.as_ref().map_or(upright, |(texture, scale)| {
            let tangent = between(&scene, triangle, at, |i| scene.tangents[i].as_dvec4()).truncate();
            let code = 2.0 * rgb(sample(&Some(texture.clone()))) - 1.0;
            let (x, y) = (f64::from(*scale) * code.x, f64::from(*scale) * code.y);
            (x * tangent + y * upright.cross(tangent) + code.z * upright).normalize()
        });
        let sides = if m.emits_on_both_sides() { 2.0 } else { 1.0 };
        let density = means[triangle] * sides / f64::from(total);
        let expected = [
            [base.x, base.y, base.z, f64::from(m.metallic) * blue],
            [expected_normal.x, expected_normal.y, expected_normal.z, alpha],
            [light.x, light.y, light.z, 0.0],
            [dielectric.x, dielectric.y, dielectric.z, if m.emits() { density } else { 0.0 }],
        ];
        let same = |a: &[f32; 4], b: &[f64; 4]| a.iter().zip(b).all(|(a, b)| (f64::from(*a) - b).abs() < 2e-4);
        let made = [color, normal, emission, f0];
        off += usize::from(!made.iter().zip(&expected).all(|(a, b)| same(a, b)));
    }
    // Rounding may choose the next texel where there is no filter: at a few points in a million texel borders.
    println!("{off} of {} points differ", points.len());
    assert!(off < 20, "{off} points differ");
}

/// Densities of points on the lamp, integrated over it, are those of a light that is chosen for certain.
#[test]
fn the_mean_emission_is_the_integral() {
    let scene = room();
    let mean = scene.mean_emission();
    let lamp = &scene.materials[2];
    let texture = lamp.textures.emissive.as_ref().unwrap();
    for triangle in [8, 9] {
        let (mut sum, n) = (0.0, 200_000);
        for i in 0..n {
            let words = rng::random_words(5, i, triangle, 0);
            let (a, b) = (rng::uniform(words[0]).sqrt(), rng::uniform(words[1]));
            let at = between(&scene, triangle as usize, [a * (1.0 - b), a * b], |i| scene.coordinates[i][0].as_dvec2());
            let [r, g, b, _] = texture.sample(&scene.images, at.to_array());
            sum += (lamp.emission.as_dvec3() * DVec3::new(r, g, b)).dot(LUMINANCE);
        }
        let (sum, mean) = (sum / f64::from(n), mean[triangle as usize]);
        assert!((sum / mean - 1.0).abs() < 0.02, "{sum} {mean}");
    }
}

/// The Metropolis methods against path tracing.
fn against_path_tracing(scene: &Scene, method: Method, replicas: u32, power: Power) {
    const FILM: [u32; 2] = [32, 24];
    let outcome = render(scene, &settings(Pt, FILM, 2048));
    let variance = [0, 1, 2].map(|c| &outcome.channels[c].values);
    let pixels = (0..outcome.image.pixels.len()).map(|i| variance.map(|v| v[i])).collect();
    let variance = Image { pixels, ..outcome.image };
    let truth = Truth { image: outcome.image, variance: Some(variance), tile: 8 };
    let images = replicates(scene, &settings(method, FILM, 150), replicas);
    check(&format!("{} by {}", scene.name, method.name()), &images, &truth, power);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_textured_room_by_mlt() {
    against_path_tracing(&room(), Mlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_textured_room_by_emlt() {
    against_path_tracing(&room(), Emlt, 16, Power { film: 0.05, tile: 0.5 });
}

/// The mean luminance of the image, from the start's million bidirectional paths, against path tracing: every strategy
/// and its density is in it, those of lights that cannot be hit (points, spots, directions) and of what light goes past
/// (holes, a veil, tinted glass) included.
#[test]
fn b_is_that_of_path_tracing() {
    check_b(&[room(), lit_room(), veiled_room()], 2048);
}

/// Path tracing knows no caustics of points, spots and directions: they are not there.
#[test]
fn b_through_mirrors_and_glass_is_that_of_path_tracing() {
    let glazed = Scene { name: "glazed room without points".into(), lights: vec![], ..glazed_room() };
    check_b(&[polished_room()], 2048);
    check_b(&[glazed], 512);
}

/// Highlights of points in lobes that are narrow, but no deltas: as specular ones they could not be connected.
#[test]
fn b_of_highlights_under_a_point_is_that_of_path_tracing() {
    let mut scene = lit_room();
    scene.name = "highlights".into();
    scene.environment = None;
    scene.lights.truncate(1);
    for material in &mut scene.materials {
        let base_color = vec3(0.9, 0.7, 0.4);
        *material = Material { base_color, metallic: 1.0, roughness: 0.3, ..Material::default() };
    }
    check_b(&[scene], 2048);
}

#[test]
fn b_with_layers_is_that_of_path_tracing() {
    check_b(&[layered_room()], 512);
}

#[test]
fn b_of_an_orthographic_camera_is_that_of_path_tracing() {
    check_b(&[orthographic_room()], 512);
}

/// The back wall, the screen and the veil are culled; light still meets both of their sides.
#[test]
fn b_from_behind_is_that_of_path_tracing() {
    let [pinhole, lens, orthographic] = [0, 1, 2].map(|kind| {
        let mut scene = veiled_room();
        let camera = scene.cameras[0].looking(vec3(0.4, 1.3, -3.2), vec3(0.0, 0.8, 0.0)).unwrap();
        scene.name =
            ["room from behind", "room from behind through a lens", "orthographic room from behind"][kind].into();
        scene.cameras[0] = Camera {
            lens: (kind == 1).then_some(Lens { aperture: 0.3, focus: 3.0 }),
            orthographic_height: (kind == 2).then_some(2.4),
            ..camera
        };
        assert!(Features::of(&scene).seen_by(&scene, &scene.cameras[0]).culled);
        scene
    });
    check_b(&[pinhole, lens, orthographic], 1024);
}

/// What is unlit has its colour, whatever shines on it, also behind.
#[test]
fn unlit_is_its_colour() {
    for method in [Pt, Mlt] {
        let scene = unlit_wall();
        let image = render(&scene, &settings(method, [8, 6], 256)).image;
        let mean =
            image.pixels.iter().map(|p| DVec3::from(p.map(f64::from))).sum::<DVec3>() / image.pixels.len() as f64;
        let expected = scene.materials[0].emission.as_dvec3();
        // The chains' colours are exact, and b of what is seen alone has no noise either.
        assert!((mean / expected - 1.0).abs().max_element() < 1e-3, "{}: {mean}", method.name());
    }
}

fn check_b(scenes: &[Scene], samples: u32) {
    for scene in scenes {
        let outcome = render(scene, &settings(Pt, [32, 24], samples));
        let n = outcome.image.pixels.len() as f64;
        let luminance = |pixel: [f32; 3]| DVec3::from(pixel.map(f64::from)).dot(LUMINANCE);
        let traced = outcome.image.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / n;
        // Of the channels' standard deviations together: not less than that of their sum.
        let deviation = |i: usize| luminance([0, 1, 2].map(|c| outcome.channels[c].values[i].sqrt())).powi(2);
        let variance = (0..outcome.image.pixels.len()).map(deviation).sum::<f64>() / (n * n);
        let statistics = render(scene, &settings(Mlt, [32, 24], 16)).statistics;
        let (b, error) = statistics.b.unwrap();
        let z = (b - traced) / (error.powi(2) + variance).sqrt();
        println!("{}: b {b:.5} +- {error:.5}, traced {traced:.5} +- {:.5}, z {z:.2}", scene.name, variance.sqrt());
        assert!(z.abs() < 4.5 && error + variance.sqrt() < 0.02 * b, "{}: z {z}", scene.name);
    }
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_lit_room_by_mlt() {
    against_path_tracing(&lit_room(), Mlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_lit_room_by_emlt() {
    against_path_tracing(&lit_room(), Emlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_veiled_room_by_mlt() {
    against_path_tracing(&veiled_room(), Mlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_veiled_room_by_emlt() {
    against_path_tracing(&veiled_room(), Emlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_layered_room_by_mlt() {
    against_path_tracing(&layered_room(), Mlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_layered_room_by_emlt() {
    against_path_tracing(&layered_room(), Emlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_orthographic_room_by_mlt() {
    against_path_tracing(&orthographic_room(), Mlt, 16, Power { film: 0.05, tile: 0.5 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_orthographic_room_by_emlt() {
    against_path_tracing(&orthographic_room(), Emlt, 16, Power { film: 0.05, tile: 0.5 });
}
