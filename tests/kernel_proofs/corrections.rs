//! The corrections of METHOD.md, C1 to C12, and some of its traps (2.9): what they concern, with them and with a line of the
//! shaders as it would be without.
//! C8 to C10 concern what is not made (delayed rejection, sharing out a bound); the rest of C6, C7 and C12 is the discrete
//! worlds', the twin of the half-vector's Jacobian and the stiff cases'.

use std::collections::BTreeSet;

use emlt::ensemble::bootstrap::Mean;
use emlt::ensemble::path_traced::Direct;
use emlt::gpu::context::Context;
use emlt::methods::{Budget, Method, Settings, Silent, render_on};
use emlt::scene::{LUMINANCE, Scene};
use glam::DVec3;

use crate::bench::{Bench, FILM, MAX_EDGES, context};
use crate::changed_sources::changed_sources;
use crate::precision::under_a_sky;
use crate::{SCENE, SPECULAR_SCENE, Z_LIMIT, factor_defects, scene_of};

/// A line of a shader, and what it would be without a correction.
struct Without {
    name: &'static str,
    module: &'static str,
    line: &'static str,
    wrong: &'static str,
}

impl Without {
    fn set(&self, context: &Context) {
        context.set_sources(changed_sources(self.name, self.module, self.line, self.wrong)).unwrap();
    }
}

/// The film's mean luminance by a method: the mean of renders with other seeds.
fn rendered(context: &Context, scene: &Scene, method: Method, samples_per_pixel: u32, renders: u32) -> Mean {
    let [width, height] = FILM;
    let mut mean = Mean::default();
    for seed in 1..=renders {
        let budget = Budget::SamplesPerPixel(samples_per_pixel);
        let settings = Settings {
            method,
            width,
            height,
            budget,
            seed,
            max_depth: MAX_EDGES,
            direct: Direct::Mcmc,
            candidates: 1 << 17,
            ..Settings::default()
        };
        let image = render_on(context, scene, &settings, &mut Silent).unwrap_or_else(|e| panic!("{e}")).image;
        let luminance = |pixel: &[f32; 3]| DVec3::from(pixel.map(f64::from)).dot(LUMINANCE);
        mean.add(image.pixels.iter().map(luminance).sum::<f64>() / image.pixels.len() as f64);
    }
    mean
}

/// The same by independent proposals: b.
fn proposed(context: &Context, scene: &Scene) -> Mean {
    let mut bench = Bench::of(context, scene);
    let mut mean = Mean::default();
    for seed in 5001..5033 {
        bench.candidates(1 << 17, seed).0.iter().for_each(|candidate| mean.add(candidate.weight()));
    }
    mean
}

fn z(name: &str, a: &Mean, b: &Mean) -> f64 {
    let z = (a.mean() - b.mean()) / a.standard_error().hypot(b.standard_error());
    let [a, b] = [a, b].map(|mean| format!("{:.5} +- {:.5}", mean.mean(), mean.standard_error()));
    println!("{name}: {a} where {b} is right, z {z:.2}");
    z.abs()
}

/// Densities of the independence kernel: b is what path tracing finds, and is not without the correction. By the normal law
/// a false alarm has a probability of 1e-6, by Student's of the 16 renders 2e-4.
fn check_densities(scene: &Scene, samples_per_pixel: u32, without: &Without) {
    let context = context();
    let traced = rendered(&context, scene, Method::Pt, samples_per_pixel, 16);
    let right = z(&format!("{}, {}, with it", scene.name, without.name), &proposed(&context, scene), &traced);
    assert!(right < Z_LIMIT, "{right}");
    without.set(&context);
    let wrong = z(&format!("{}, {}, without", scene.name, without.name), &proposed(&context, scene), &traced);
    assert!(wrong > Z_LIMIT, "{} is not missed: z {wrong}", without.name);
}

/// Kept factors: C as kernels leave it is C as the whole path has it, and is not without the correction.
fn check_factors(scene: &str, without: &Without) {
    let context = context();
    let right = factor_defects(&mut Bench::new(&context, scene));
    assert!(right < 1e-3, "{right}");
    without.set(&context);
    let wrong = factor_defects(&mut Bench::new(&context, scene));
    println!("{scene}, {}: without it {wrong:.3} of the paths differ", without.name);
    assert!(wrong > 1e-2, "{} is not missed: {wrong}", without.name);
}

/// Images by emlt: the film's light is what path tracing finds, and is not without the correction.
fn check_film(scene: &Scene, without: &Without) {
    let context = context();
    let traced = rendered(&context, scene, Method::Pt, 64, 16);
    let right = z(&format!("{}, image, {}, with it", scene.name, without.name), &by_emlt(&context, scene, 16), &traced);
    assert!(right < Z_LIMIT, "{right}");
    without.set(&context);
    let wrong = z(&format!("{}, image, {}, without", scene.name, without.name), &by_emlt(&context, scene, 8), &traced);
    assert!(wrong > Z_LIMIT, "{} is not missed: z {wrong}", without.name);
}

fn by_emlt(context: &Context, scene: &Scene, renders: u32) -> Mean {
    rendered(context, scene, Method::Emlt, 20, renders)
}

/// The light is inside glass and the camera in air: etendue takes the place of eta^2 in sweeps from the light.
#[test]
fn c1_light_leaves_glass_with_etendue() {
    let without = Without {
        name: "c1",
        module: "bsdf/scatter.wesl",
        line: "p_c.z * abs(ns_c) * squeeze, p_l.z",
        wrong: "p_c.z * abs(ns_c), p_l.z",
    };
    check_densities(&scene_of(SPECULAR_SCENE), 16, &without);
}

/// The box with copper as a mirror whose normals lean.
fn leaning_mirror() -> Scene {
    let mut scene = scene_of(SCENE);
    let copper = scene.materials.iter().position(|material| material.metallic == 1.0).unwrap();
    scene.materials[copper].roughness = 0.0;
    let of_copper = |(_, material): &(_, &u32)| **material as usize == copper;
    let corners = scene.triangles.iter().zip(&scene.triangle_materials).filter(of_copper);
    let corners: BTreeSet<u32> = corners.flat_map(|(triangle, _)| *triangle).collect();
    for corner in corners {
        let normal = &mut scene.normals[corner as usize];
        *normal = (*normal + 0.5 * normal.any_orthonormal_vector()).normalize();
    }
    scene.name = "leaning mirror".into();
    scene
}

/// The box with a wall that is smooth over its colour: there a delta and a matt lobe meet.
fn varnished_wall() -> Scene {
    let mut scene = scene_of(SCENE);
    let wall = scene.materials.iter_mut().find(|material| material.name == "orange").unwrap();
    (wall.roughness, wall.specular) = (0.0, 1.0);
    scene.name = "varnished wall".into();
    scene
}

/// A mirror with leaning normals: what a sweep from the light brings is told by both normals.
#[test]
fn c2_leaning_normals_turn_area_too() {
    let without = Without {
        name: "c2",
        module: "bsdf/scatter.wesl",
        line: "return Scatter(r, p_c.y * abs(ns_c), p_l.y * abs(ns_l)",
        wrong: "return Scatter(r, p_c.y * abs(ng_c), p_l.y * abs(ns_l)",
    };
    check_densities(&leaning_mirror(), 128, &without);
}

/// The step after a delta has a density too.
#[test]
fn c3_steps_after_deltas_count() {
    let without = Without {
        name: "c3",
        module: "target/contribution.wesl",
        line: "let light_step = safe_log(pdf_to_camera * ng_cos * inverse_r2);",
        wrong: "let light_step = select(0.0, safe_log(pdf_to_camera * ng_cos * inverse_r2), before_connectable);",
    };
    check_densities(&scene_of(SPECULAR_SCENE), 16, &without);
}

/// C of a path with deltas depends on the measure: all of them take that of one master f.
#[test]
fn c4_one_measure_for_all() {
    let without = Without {
        name: "c4",
        module: "target/contribution.wesl",
        line: "camera_sweep += select(camera_step - safe_log(here_scatter.class_to_light), turn, tag == TAG_DIFFUSE);",
        wrong: "camera_sweep += select(camera_step, turn, tag == TAG_DIFFUSE);",
    };
    check_factors(SPECULAR_SCENE, &without);
}

/// A vertex has the density of its tag's lobes, times the probability of that class.
#[test]
fn c5_densities_are_those_of_the_tag() {
    let without = Without {
        name: "c5",
        module: "bsdf/scatter.wesl",
        line: "return Scatter(value, to_camera * pdf_c, to_light * pdf_l, to_camera, to_light);",
        wrong: "return Scatter(value, pdf_c, pdf_l, to_camera, to_light);",
    };
    check_densities(&varnished_wall(), 64, &without);
}

/// Paths in no kernel's list are credited what they sit out, or the image is another.
#[test]
fn c6_idle_paths_are_seen() {
    let without = Without {
        name: "c6",
        module: "passes/rest.wesl",
        line: "chain_row(path, ROW_COLOUR).xyz, run.weight, random_words",
        wrong: "chain_row(path, ROW_COLOUR).xyz, 0.0, random_words",
    };
    check_film(&scene_of(SPECULAR_SCENE), &without);
}

/// What is infinitely far has a direction alone: no distance is in its edge.
#[test]
fn c11_the_sky_has_no_distance() {
    let without = Without {
        name: "c11",
        module: "target/contribution.wesl",
        line: "inverse_r2 = 1.0;",
        wrong: "inverse_r2 = 0.5;",
    };
    check_densities(&under_a_sky(false), 32, &without);
}

/// Where the moved part connects to the lamp, its radiance stands where scattering (here of a white surface) would.
#[test]
fn c12_lamps_shine_where_others_scatter() {
    let without = Without {
        name: "c12",
        module: "transport/camera_sweep.wesl",
        line: "source = emitted(kept_material, dot(kept_surface.ng, w));",
        wrong: "source = vec3<f32>(0.3183);",
    };
    check_factors(SCENE, &without);
}

/// The luminance of a product is not the product of luminances.
#[test]
fn t1_what_is_kept_has_a_colour() {
    let without = Without {
        name: "t1",
        module: "transport/camera_sweep.wesl",
        line: "let c = log_colour(prefix.xyz * chain * source * here * g);",
        wrong: "let c = log_colour(chain * source * here * g);",
    };
    check_factors(SCENE, &without);
}

/// Steps on the film are in pixels: the camera's cosine is not in C.
#[test]
fn t5_the_cameras_cosine_is_not_in_c() {
    let without = Without {
        name: "t5",
        module: "transport/camera_sweep.wesl",
        line: "var chain = vec3<f32>(1.0);",
        wrong: "var chain = vec3<f32>(abs(dot(direction, scene.camera_back)));",
    };
    check_factors(SCENE, &without);
}

/// A proposal that fails is a rejection, not no step.
#[test]
fn t9_what_fails_is_a_sample() {
    let without = Without {
        name: "t9",
        module: "transport/accept.wesl",
        line: "splat(layer, old_pixel, old_colour, 1.0 - acceptance, dither);",
        wrong: "splat(layer, old_pixel, old_colour, select(0.0, 1.0 - acceptance, acceptance > 0.0), dither);",
    };
    check_film(&scene_of(SCENE), &without);
}
