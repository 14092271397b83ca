//! Item 9: guides that leave the covariance of a step singular: none, one, all at one place or on a line. The device's step
//! and the log ratio of its densities there and back are those of the twin in f64.

use emlt::ensemble::bootstrap::Given;
use emlt::gpu::context::Context;
use emlt::gpu::layout::{PassUniform, ROW_COLOUR, ROW_PIXEL};
use emlt::kernels::guided_lens;
use emlt::reference::guide::{StepShape, Symmetric};
use emlt::reference::rng::random_words;

use super::bench::Bench;
use super::furnaces::{EDGES, box_furnace};

const FILM: [u32; 2] = [64, 48];
const MOVING: u32 = 4096;
const MOST: u32 = 16;
/// As in shaders/kernels/guided_lens.wesl: the floor of a step, and the cap on the guides' spread.
const FLOOR_PX: f64 = 0.3;
const WIDEST_PX: f64 = 0.25 * FILM[1] as f64;
const ALPHA: f64 = 0.5;
/// Dimension block of a kernel's first random words (DIMENSION_KERNEL), and the pass.
const DIMENSION: u32 = 2;
const PASS: u32 = 1;

/// As guides tell their pixels: in 16 bits over the film.
fn told(pixel: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|c| {
        let film = f64::from(FILM[c]);
        (pixel[c] / film * 65535.0).round() / 65535.0 * film
    })
}

fn shape(pixel: [f64; 2], guides: &[[f64; 2]]) -> StepShape {
    let weights = vec![1.0 / guides.len().max(1) as f64; guides.len()];
    StepShape::new(Symmetric::about(pixel, &weights, guides).capped(WIDEST_PX), ALPHA, FLOOR_PX)
}

/// The step that the random words of `path` make of a shape.
fn step(bench: &Bench, path: u32, shape: &StepShape) -> [f64; 2] {
    let words = random_words(bench.uniform(0).seed, path, PASS, DIMENSION);
    let u = words.map(|word| (f64::from(word >> 8) + 0.5) * 2f64.powi(-24));
    let (radius, phi) = ((-2.0 * u[0].ln()).sqrt(), std::f64::consts::TAU * u[1]);
    shape.step([radius * phi.cos(), radius * phi.sin()], [u[2], u[3]])
}

#[test]
fn singular_covariances() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut bench = Bench::new(&context, &box_furnace(), FILM, EDGES, MOVING + MOST);
    let (candidates, strategies) = bench.candidates(1 << 14);
    // One path, near the middle, of three edges; all others are its copies, but that guides get pixels of their own.
    let middle = |c: &emlt::ensemble::bootstrap::Candidate| {
        let off = [0, 1].map(|i| (c.pixel[i] - 0.5 * FILM[i] as f32).abs());
        off[0] < 4.0 && off[1] < 4.0 && c.weight() > 0.0 && c.key().is_some_and(|key| key.edges() == 3)
    };
    let chosen = candidates.iter().position(middle).expect("a path in the middle");
    let x = candidates[chosen].pixel.map(f64::from);
    let at = |i: u32, [a, b]: [f64; 2]| [x[0] + a * f64::from(i), x[1] + b * f64::from(i)];
    let cases: [(&str, Vec<[f64; 2]>); 6] = [
        ("no guide", vec![]),
        ("one guide", vec![[x[0] + 21.0, x[1] - 9.0]]),
        ("one guide, at the path's pixel", vec![x]),
        ("all guides at the path's pixel", vec![x; MOST as usize]),
        ("guides on a line through it", (0..MOST).map(|i| at(i, [1.5, 1.0])).collect()),
        ("guides on a line beside it", (0..MOST).map(|i| [x[0] - 20.0 + 3.0 * f64::from(i), x[1] + 5.0]).collect()),
    ];
    for (name, guides) in cases {
        bench
            .start
            .fill(&mut bench.run, Given::default(), &strategies, &vec![chosen as u32; (MOVING + MOST) as usize])
            .unwrap();
        let mut pixels = bench.row(ROW_PIXEL);
        for (row, guide) in pixels[MOVING as usize..].iter_mut().zip(&guides) {
            [row[0], row[1]] = guide.map(|v| (v as f32).to_bits());
        }
        bench.set_row(ROW_PIXEL, &pixels);
        let old_log_c = f64::from(f32::from_bits(bench.row(ROW_COLOUR)[0][3]));
        let order: Vec<u32> = (MOVING..MOVING + MOST).collect();
        bench.list(&order, 0, &[]);
        let uniform = PassUniform { guides_first: MOVING, ..bench.uniform(order.len()) };
        bench.pass("gather", &[], uniform);
        // The node: its offset, its guides, any median.
        let paths: Vec<u32> = (0..MOVING).collect();
        bench.list(&paths, 0, &[0, guides.len() as u32, 0f32.to_bits()]);
        let uniform = PassUniform {
            pass_index: PASS,
            guides_first: MOVING,
            nodes_offset: 2 * MOVING,
            guides: MOST,
            similarity_scale: 25.0,
            alpha_low: ALPHA as f32,
            alpha_high: ALPHA as f32,
            ..bench.uniform(paths.len())
        };
        let flags: Vec<&'static str> = guided_lens::KERNEL.flags.iter().copied().chain(["probe"]).collect();
        bench.pass(guided_lens::KERNEL.pass, &flags, uniform);
        let records = bench.records(paths.len());
        let after = bench.row(ROW_PIXEL);
        let guides: Vec<[f64; 2]> = guides.into_iter().map(told).collect();
        let forward = shape(x, &guides);
        let determinant = (2.0 * forward.log_area()).exp();
        assert!(determinant >= FLOOR_PX.powi(4) * (1.0 - 1e-12), "{name}: {determinant}");
        let (mut moved, mut of_steps, mut of_ratios) = (0, 0.0f64, 0.0f64);
        for (path, (record, row)) in (0..).zip(records.iter().zip(&after)).filter(|(_, (r, _))| r[3] > -1e29) {
            let y = [0, 1].map(|c| f64::from(f32::from_bits(row[c])));
            let d = [0, 1].map(|c| y[c] - x[c]);
            let made = step(&bench, path, &forward);
            let size = made[0].hypot(made[1]);
            of_steps = of_steps.max((d[0] - made[0]).hypot(d[1] - made[1]) / (size + 0.1));
            let expected = shape(y, &guides).log_density(d.map(|v| -v)) - forward.log_density(d);
            let correction = f64::from(record[0]) - (f64::from(record[3]) - old_log_c);
            // Counted this way round, what is no number is worst.
            let off = (correction - expected).abs();
            of_ratios = if off < of_ratios { of_ratios } else { off };
            moved += 1;
        }
        println!(
            "{name}: of {moved} steps the worst is off by {of_steps:.1e} of itself, of log ratios by {of_ratios:.1e}"
        );
        assert!(moved > MOVING * 3 / 4, "{name}: {moved}");
        assert!(of_steps < 1e-3 && of_ratios < 1e-3, "{name}: {of_steps} {of_ratios}");
    }
}
