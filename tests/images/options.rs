//! Direct light apart (`--direct pt`) and the two-stage target (`--two-stage`): neither changes what an image tends to.

use emlt::film::Image;
use emlt::kernels::{Kernel, crossover, independence, lens};
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::{Direct, Method, Settings, default_mix};
use glam::Vec3;

use super::comparison::{Comparison, Power, Truth, check};
use super::mitsuba::{COLOURED_BOX, FULL_DEPTH, RING, SHARDS, reference, settings_for};
use super::renders::{changed, render, render_unchecked, replicates, scene, settings};

/// Who renders direct light, and the exponent of the two-stage target.
type Options = (Direct, Option<f64>);
const DIRECT_APART: Options = (Direct::Pt, None);
const EASY_APART: Options = (Direct::Auto, Some(0.5));
const TWO_STAGE: Options = (Direct::Mcmc, Some(0.5));
const BOTH: Options = (Direct::Pt, Some(1.0));

/// Renders 16 replicates of `path` and compares them with the reference called `name`.
#[track_caller]
fn compare(name: &str, path: &str, method: Method, options: Options, [max_depth, spp]: [u32; 2], power: Power) {
    let truth = reference(name);
    let (direct, two_stage) = options;
    let settings = Settings { direct, two_stage, ..settings_for(&truth, method, max_depth, spp) };
    let images = replicates(&scene(path), &settings, 16);
    check(&format!("{name} {} {options:?}", method.name()), &images, &truth, power);
}

#[test]
fn coloured_box_with_direct_light_apart() {
    let power = Power { film: 0.03, tile: 0.2 };
    compare("coloured_box", COLOURED_BOX, Emlt, DIRECT_APART, [FULL_DEPTH, 120], power);
}

#[test]
fn coloured_box_in_two_stages() {
    let power = Power { film: 0.03, tile: 0.2 };
    compare("coloured_box", COLOURED_BOX, Emlt, TWO_STAGE, [FULL_DEPTH, 120], power);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_coloured_box_with_both_by_mlt() {
    let power = Power { film: 0.03, tile: 0.2 };
    compare("coloured_box", COLOURED_BOX, Mlt, BOTH, [FULL_DEPTH, 240], power);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_shards_with_both() {
    compare("shards_4_edges", SHARDS, Emlt, BOTH, [4, 120], Power { film: 0.01, tile: 0.25 });
}

/// Chains for what lights glass, the path tracer for what is lit past it.
#[test]
fn shards_with_easy_light_apart() {
    compare("shards_4_edges", SHARDS, Emlt, EASY_APART, [4, 120], Power { film: 0.01, tile: 0.25 });
}

/// Most of ring's light stays with the chains.
#[test]
fn ring_with_easy_light_apart() {
    compare("ring", RING, Emlt, EASY_APART, [FULL_DEPTH, 60], Power { film: 0.08, tile: 0.5 });
}

/// What these comparisons are for: light that both sides render is seen.
#[test]
fn light_that_is_rendered_twice_is_caught() {
    let truth = reference("shards_4_edges");
    let scene = scene(SHARDS);
    let direct = render(&scene, &settings_for(&truth, Pt, 2, 64)).image;
    let twice = replicates(&scene, &settings_for(&truth, Emlt, 4, 60), 8).into_iter().map(|image| {
        changed(&image, |x, y, p| {
            let more = direct.pixels[(y * direct.width + x) as usize];
            [0, 1, 2].map(|c| p[c] + 0.1 * more[c])
        })
    });
    let comparison = Comparison::new(&twice.collect::<Vec<_>>(), &truth);
    println!("{}", comparison.report("twin: a tenth of direct light twice"));
    assert!(!comparison.passes());
}

/// Exponent 0 is the plain target: the same image, bit for bit.
#[test]
fn an_exponent_of_zero_changes_nothing() {
    let scene = scene(COLOURED_BOX);
    let plain = settings(Emlt, [33, 25], 50);
    let zero = Settings { two_stage: Some(0.0), ..plain.clone() };
    assert_eq!(render(&scene, &plain).image, render(&scene, &zero).image);
}

/// What the two-stage comparison is for: kernels that leave w out of the acceptance, or out of the splat, fail it.
#[test]
fn twins_of_the_two_stage_target_are_caught() {
    static ACCEPTANCE: Kernel = Kernel { flags: &["twin_acceptance"], ..lens::KERNEL };
    static SPLAT: Kernel = Kernel { flags: &["twin_splat"], ..lens::KERNEL };
    let truth = reference("coloured_box");
    let scene = scene(COLOURED_BOX);
    for (twin, lens) in [("none", &lens::KERNEL), ("acceptance", &ACCEPTANCE), ("splat", &SPLAT)] {
        let settings = Settings {
            two_stage: Some(1.0),
            kernels: Some(vec![(&independence::KERNEL, 0.1), (lens, 1.0)]),
            ..settings_for(&truth, Mlt, FULL_DEPTH, 120)
        };
        // Lost weight shows in the statistics at once; here the image alone has to tell.
        let image = |seed| render_unchecked(&scene, &Settings { seed, ..settings.clone() }).image;
        let comparison = Comparison::new(&(1..=12).map(image).collect::<Vec<_>>(), &truth);
        println!("{}", comparison.report(&format!("twin: {twin}")));
        assert_eq!(comparison.passes(), twin == "none", "{twin}");
    }
}

/// A ball over a plane lights it, and nothing else is lit: no path has 3 edges.
#[test]
fn without_indirect_light_the_direct_is_all() {
    let scene = scene("tests/scenes/sphere_over_plane.glb");
    let settings = Settings { direct: Direct::Pt, max_depth: 3, maps: true, ..settings(Emlt, [32, 24], 64) };
    let outcome = render(&scene, &settings);
    let s = &outcome.statistics;
    assert_eq!((s.samples, s.path_traced_samples, s.b), (0, 32 * 32 * 24, None));
    assert!(s.notes.iter().any(|note| note.contains("path traced")), "{:?}", s.notes);
    assert_eq!(outcome.channels.len(), 2);
    let lit = outcome.image.pixels.iter().filter(|p| p[0] > 0.0).count();
    assert!(lit > outcome.image.pixels.len() / 2, "{lit} pixels");
}

#[test]
fn short_paths_are_all_direct() {
    let scene = scene(COLOURED_BOX);
    let settings = Settings { direct: Direct::Pt, max_depth: 2, ..settings(Mlt, [16, 12], 8) };
    let s = render(&scene, &settings).statistics;
    assert_eq!((s.samples, s.path_traced_samples), (0, 8 * 16 * 12));
    assert!(s.notes.iter().any(|note| note.contains("--max-depth")), "{:?}", s.notes);
}

/// Under a sky: a grey ball over a plane that reflect each other, against a long path tracing. With crossovers, which give
/// each other points of the sky.
#[test]
fn sky_with_both() {
    let mut lit = scene("tests/scenes/sphere_over_plane.glb");
    lit.materials.iter_mut().for_each(|m| {
        m.emission = Vec3::ZERO;
        m.metallic = 0.0;
        m.specular = 0.0;
        m.base_color = Vec3::new(0.8, 0.7, 0.6);
    });
    lit.sky = Some(Vec3::new(1.0, 1.5, 2.0));
    let limits = Settings { max_depth: 6, ..settings(Pt, [32, 24], 1024) };
    let long = render(&lit, &limits);
    let variance = layers(&long.channels, &long.image);
    let truth = Truth { image: long.image, variance: Some(variance), tile: 8 };
    let kernels = Some([default_mix(Emlt), vec![(&crossover::KERNEL, 0.2)]].concat());
    let both =
        Settings { max_depth: 6, direct: Direct::Pt, two_stage: Some(0.5), kernels, ..settings(Emlt, [32, 24], 240) };
    check("sky with both", &replicates(&lit, &both, 16), &truth, Power { film: 0.03, tile: 0.2 });
}

/// The variance that path tracing states.
fn layers(channels: &[emlt::film::Channel], like: &Image) -> Image {
    let pixels = (0..like.pixels.len()).map(|i| [0, 1, 2].map(|c| channels[c].values[i])).collect();
    Image { pixels, ..*like }
}
