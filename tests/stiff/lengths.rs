//! Item 7: paths of 31 edges, the longest there are, in furnaces so dark that their light is 1e-70 of the shortest's: b of
//! every length has a closed form, and all of it comes from products of 31 factors.

use emlt::ensemble::bootstrap::Mean;
use emlt::ensemble::strategies::Strategies;
use emlt::gpu::context::Context;
use emlt::report::student::two_sided;
use glam::vec3;

use super::bench::Bench;
use super::comparison::LEVEL;
use super::furnaces::{EMISSION, box_furnace};

const LONGEST: u32 = 31;
const COUNT: u32 = 1 << 18;

#[test]
fn the_longest_paths_neither_overflow_nor_underflow() {
    let albedo = vec3(0.006, 0.005, 0.003);
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    // Bright enough that f itself, near the camera, is far from 1 the other way.
    for brightness in [1.0f32, 1e25] {
        let mut scene = box_furnace();
        scene.materials[0].base_color = albedo;
        scene.materials[0].emission = brightness * EMISSION;
        let mut bench = Bench::new(&context, &scene, [16, 12], LONGEST, 64);
        bench.bootstrap.strategies = Strategies::uniform(1..=LONGEST, false);
        let (candidates, strategies) = bench.candidates(COUNT);
        let (mut least, mut widest) = (1.0f64, 0.0f64);
        for edges in 1..=LONGEST {
            let mut weights = Mean::default();
            // Every wall is a light, so a walk ends after one edge.
            let made = |l: &[u32; 2]| l[0] == edges || (edges == 1 && l[0] == 0);
            let of = candidates.iter().zip(&strategies).filter(|(_, l)| made(l));
            // In units of the closed form, whose squares f64 would not hold.
            let term =
                |c: usize| f64::from(scene.materials[0].emission[c]) * f64::from(albedo[c]).powi(edges as i32 - 1);
            let truth = 0.2126 * term(0) + 0.7152 * term(1) + 0.0722 * term(2);
            of.for_each(|(c, _)| weights.add((f64::from(c.log_weight) - truth.ln()).exp()));
            // The number of candidates of each length is fixed (systematic sampling), so it adds no noise.
            let share = weights.count / f64::from(COUNT);
            let (ratio, error) = (share * weights.mean(), share * weights.standard_error());
            let p = two_sided((ratio - 1.0) / error, 1000);
            (least, widest) = (least.min(p), widest.max(error));
            assert!(p * f64::from(LONGEST) > LEVEL, "{edges} edges: {ratio} +- {error} of {truth:.1e}");
        }
        println!(
            "31 lengths at brightness {brightness:.0e}: least p {least:.1e}, errors up to {:.2} %",
            100.0 * widest
        );
        // What the test can see: 10 % at any length.
        assert!(widest < 0.02, "{widest}");
    }
}
