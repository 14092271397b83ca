//! The roughness below which lobes are treated as specular (METHOD.md 2.7) is a matter of noise: results are the same.

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, CANDIDATE_PASS, CANDIDATES, Given, Mean, Start};
use emlt::ensemble::groups::Groups;
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::strategies::Strategies;
use emlt::ensemble::sweep::list_words;
use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::gpu::layout::chain_rows;
use emlt::gpu::run::{Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::report::student::two_sided;
use emlt::scene::Features;
use emlt::scene::material::GLOSSY_AS_SPECULAR_ALPHA;

use super::comparison::{LEVEL, Power, Truth, check};
use super::renders::{render, replicates, scene, settings};

/// Metal and glass of alpha 0.05 and 0.2.
const SCENE: &str = "tests/scenes/glossy_box.glb";
const FILM: [u32; 2] = [64, 48];

/// Against path tracing, which knows no classes; 0 makes the same of the chains.
fn against_path_tracing(method: Method, threshold: f32) {
    let scene = scene(SCENE);
    let outcome = render(&scene, &settings(Pt, FILM, 1024));
    let variance = [0, 1, 2].map(|c| &outcome.channels[c].values);
    let pixels = (0..outcome.image.pixels.len()).map(|i| variance.map(|v| v[i])).collect();
    let variance = Image { pixels, ..outcome.image };
    let truth = Truth { image: outcome.image, variance: Some(variance), tile: 8 };
    let settings = Settings { glossy_as_specular_alpha: threshold, ..settings(method, FILM, 240) };
    let name = format!("glossy box {}, threshold {threshold}", method.name());
    check(&name, &replicates(&scene, &settings, 16), &truth, Power { film: 0.03, tile: 0.3 });
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_glossy_box_with_lobes_as_specular_by_mlt() {
    against_path_tracing(Mlt, GLOSSY_AS_SPECULAR_ALPHA);
}

#[test]
fn glossy_box_with_lobes_as_specular_by_emlt() {
    against_path_tracing(Emlt, GLOSSY_AS_SPECULAR_ALPHA);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_glossy_box_with_lobes_as_lobes_by_mlt() {
    against_path_tracing(Mlt, 0.0);
}

/// b of paths up to some lengths, from bidirectional candidates, with the threshold at its default and at 0.
#[test]
fn b_does_not_depend_on_the_threshold() {
    const COUNT: u32 = 1 << 19;
    const LONGEST: [u32; 4] = [2, 3, 4, 8];
    let scene = scene(SCENE);
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    for longest in LONGEST {
        let [with, without] = [GLOSSY_AS_SPECULAR_ALPHA, 0.0].map(|threshold| {
            let camera = scene.camera(None).unwrap();
            let data = SceneData::with_threshold(&scene, camera, FILM[0], FILM[1], threshold).unwrap();
            let features = Features::with_threshold(&scene, threshold);
            assert_eq!(features.narrow, threshold > 0.0);
            let paths = 2;
            let sizes = Sizes {
                chains: 16 * chain_rows(longest) as u64 * u64::from(paths),
                lists: 4 * list_words(paths, BATCH),
                output: BATCH_BYTES,
                counters: 256,
            };
            let mut run = Run::new(&context, &data, sizes).unwrap();
            let seed = 1 + u32::from(features.narrow);
            let start = Start {
                features,
                direct: Direct::Mcmc,
                maps_row: None,
                max_edges: longest,
                seed,
                groups: Groups::new(paths, 1),
                stride: paths,
                film: FILM,
                two_stage: None,
                candidates: CANDIDATES,
            };
            let strategies = Strategies::uniform(1..=longest, false, false);
            let (candidates, _) =
                start.candidates(&mut run, &strategies, Given::default(), COUNT, CANDIDATE_PASS).unwrap();
            let mut b = Mean::default();
            candidates.iter().for_each(|c| b.add(c.weight()));
            b
        });
        let error = with.standard_error().hypot(without.standard_error());
        let z = (with.mean() - without.mean()) / error;
        let relative = error / without.mean();
        println!(
            "up to {longest} edges: b {:.5} and {:.5}, +- {:.2} %, z {z:.2}",
            with.mean(),
            without.mean(),
            100.0 * relative
        );
        assert!(two_sided(z, 1000) * LONGEST.len() as f64 > LEVEL, "{longest} edges: z {z}");
        // What the test can see: 5 %.
        assert!(two_sided(0.05 / relative, 1000) * (LONGEST.len() as f64) < LEVEL, "{longest} edges: {relative}");
    }
}
