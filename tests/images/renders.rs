//! Scenes and renders; every render is checked for lost energy.

use std::path::Path;
use std::sync::LazyLock;

use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::methods::{Budget, Direct, Method, Outcome, Settings, Silent};
use emlt::scene::{Scene, import::import};

/// The scene at `path` from the repository's root.
pub fn scene(path: &str) -> Scene {
    import(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap_or_else(|e| panic!("{e}"))
}

/// One device for all renders, which compiles nothing twice.
static DEVICE: LazyLock<Context> = LazyLock::new(|| Context::open(None).unwrap_or_else(|e| panic!("{e}")));

/// Settings of a small film. A small ensemble makes every chain move hundreds of times, so that what is seen is the
/// work of the kernels and not of the start; a quarter of the candidates leaves the time to them, and whatever their
/// number, nothing is biased by it.
pub fn settings(method: Method, [width, height]: [u32; 2], samples_per_pixel: u32) -> Settings {
    let budget = Budget::SamplesPerPixel(samples_per_pixel);
    Settings { method, width, height, budget, ensemble: 2048, candidates: 1 << 18, ..Settings::default() }
}

pub fn render_unchecked(scene: &Scene, settings: &Settings) -> Outcome {
    emlt::methods::render_on(&DEVICE, scene, settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// Renders and checks that no energy got lost: weight 1 a mutation on the film (METHOD.md 1.4), nothing not finite.
pub fn render(scene: &Scene, settings: &Settings) -> Outcome {
    let outcome = render_unchecked(scene, settings);
    let statistics = &outcome.statistics;
    let name = format!("{} by {}, seed {}", scene.name, settings.method.name(), settings.seed);
    // Direct light alone takes no mutations.
    let mutates = settings.method != Method::Pt && (settings.direct == Direct::Mcmc || statistics.samples > 0);
    assert_eq!(statistics.integrity.is_some(), mutates, "{name}");
    let lost = statistics.integrity.unwrap_or(0.0).abs();
    assert!(lost < 1e-4, "{name}: splatted luminance over mutations is off by {lost}");
    let non_finite: u64 = statistics.kernels.iter().map(|k| k.non_finite).sum();
    // pt keeps no count, but leaves a note.
    let noted = statistics.notes.iter().any(|note| note.contains("not finite"));
    assert!(non_finite == 0 && !noted, "{name}: {non_finite} proposals not finite, {:?}", statistics.notes);
    outcome
}

/// Independent renders, with `count` seeds from that of `settings` on.
pub fn replicates(scene: &Scene, settings: &Settings, count: u32) -> Vec<Image> {
    let seeds = settings.seed..settings.seed + count;
    seeds.map(|seed| render(scene, &Settings { seed, ..settings.clone() }).image).collect()
}

/// `image` with every pixel (x, y) passed through `change`.
pub fn changed(image: &Image, change: impl Fn(u32, u32, [f32; 3]) -> [f32; 3]) -> Image {
    let at = |i: usize| (i as u32 % image.width, i as u32 / image.width);
    let pixels = image.pixels.iter().enumerate().map(|(i, p)| change(at(i).0, at(i).1, *p)).collect();
    Image { pixels, ..*image }
}
