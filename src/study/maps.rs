//! The supplement's section 5: which way accepted mutations move, for every scene.

use super::detail::luminance;
use super::panels::{Panel, Picture, zoom};
use super::plan::{Asked, Defaults, Run, SCENES};
use super::report::{Report, Verdict};
use super::statistics::{Interval, correlation, covariance};
use super::{Findings, Study, work};
use crate::Result;
use crate::film::Image;
use crate::methods::{Budget, Method};

pub const STUDY: Study = Study {
    name: "maps",
    about: "mutation-direction maps of mlt and emlt",
    defaults: Defaults {
        scenes: &SCENES,
        size: [160, 120],
        budget: Budget::SamplesPerPixel(128),
        seeds: 2,
        reference_spp: 0,
    },
    compares: false,
    runs,
    conclude,
};

const METHODS: [Method; 2] = [Method::Mlt, Method::Emlt];
/// Pixels on a side of the tiles over which directions are counted together.
const TILE: u32 = 8;

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    Ok(asked.runs(METHODS, |scene, method, seed| {
        let mut run = asked.kept(scene, method.name(), method, seed);
        run.settings.maps = true;
        run
    }))
}

/// What is told of one scene and method.
struct Told {
    /// Of every seed: correlation of the direction of moves with that of edges in the image.
    along_edges: Vec<f64>,
    /// Root of the covariance of the moves' anisotropy between seeds: what is not chance of it.
    spread: f64,
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    report.heading("Maps");
    let mut rows = Vec::new();
    let mut table = Vec::new();
    let mut told: Vec<[Told; 2]> = Vec::new();
    for scene in &findings.asked.scenes {
        let mut row = Vec::new();
        let mut images = Vec::new();
        let mut directions = Vec::new();
        for method in METHODS {
            let mut of_seeds = Vec::new();
            for (number, finished) in findings.of(Some(scene), method.name()).enumerate() {
                let file = work::image(finished)?;
                let size = [file.width, file.height];
                if number == 0 {
                    row.extend(Picture::of_directions(size, &file.channels).map(|p| (method.name(), p)));
                }
                let layer = |name| file.channel(name).unwrap_or_default();
                of_seeds.push(anisotropy(size, layer("Maps.Horizontal"), layer("Maps.Vertical")));
                images.extend(file.image(""));
            }
            directions.push(of_seeds);
        }
        let mean = mean_image(&images);
        row.push(("image", Picture::of(&mean)));
        let panel = |(name, picture): (&str, Picture)| Panel {
            caption: format!("{scene}, {name}"),
            picture: picture.enlarge(zoom(picture.width)),
        };
        rows.push(row.into_iter().map(panel).collect::<Vec<_>>());
        let edges = edges(&mean);
        let [mlt, emlt] = [&directions[0], &directions[1]].map(|of_seeds| tell(of_seeds, &edges));
        let text = |told: &Told| [Interval::of(&told.along_edges).text(2), format!("{:.3}", told.spread)];
        table.push([vec![scene.clone()], text(&mlt).to_vec(), text(&emlt).to_vec()].concat());
        told.push([mlt, emlt]);
    }
    report.pictures(
        "maps",
        &rows,
        "Red: accepted mutations move mostly horizontally; green: vertically; yellow: both alike; black: none was accepted. \
         First seed; the image is the mean of all runs.",
    )?;
    let header = ["scene", "mlt along edges", "mlt spread", "emlt along edges", "emlt spread"];
    report.table("maps", &header, &table)?;
    report.paragraph(&format!(
        "Along edges: correlation, over tiles of {TILE}x{TILE} pixels, between the share of horizontal over vertical moves and \
         that of horizontal over vertical edges of the image's log-luminance, which geometry and light make; 1 would be \
         moves that follow the edges everywhere. Spread: standard deviation over the tiles of (horizontal - vertical) / \
         (horizontal + vertical), as far as two seeds agree on it; 0 would be the same mixture everywhere."
    ));
    let follows = Interval::of(&told.iter().flat_map(|[_, emlt]| emlt.along_edges.clone()).collect::<Vec<_>>());
    let more = told.iter().flat_map(|[mlt, emlt]| emlt.along_edges.iter().zip(&mlt.along_edges).map(|(e, m)| e - m));
    let more = Interval::of(&more.collect::<Vec<_>>());
    let spreads = [0, 1].map(|method| told.iter().map(|told| told[method].spread).collect::<Vec<_>>());
    let wider = Interval::of_ratio(&spreads[1], &spreads[0]);
    let verdict = if follows.above(0.0) && wider.above(1.0) {
        Verdict::Agrees
    } else if follows.below(0.0) || wider.below(1.0) {
        Verdict::Disagrees
    } else {
        Verdict::Undecided
    };
    report.claim(
        "The perturbations of emlt adapt to geometry and lighting.",
        verdict,
        &format!(
            "Over all scenes and seeds the direction of emlt's moves correlates with that of edges by {}, and over the scenes \
             its spread is {} times that of mlt. It agrees where the 95 % interval of the first is above 0 and that of the \
             second above 1, and does not where one is below. The correlation itself differs from mlt's by {}.",
            follows.text(3),
            wider.text(2),
            more.text(3)
        ),
    );
    Ok(())
}

fn tell(of_seeds: &[Vec<f64>], edges: &[f64]) -> Told {
    let along_edges = of_seeds.iter().map(|moves| correlation(moves, edges)).collect();
    let pairs: Vec<f64> = (0..of_seeds.len())
        .flat_map(|a| (0..a).map(move |b| (a, b)))
        .map(|(a, b)| covariance(&of_seeds[a], &of_seeds[b]))
        .collect();
    let spread = (pairs.iter().sum::<f64>() / pairs.len() as f64).max(0.0).sqrt();
    Told { along_edges, spread: if pairs.is_empty() { f64::NAN } else { spread } }
}

fn mean_image(images: &[Image]) -> Image {
    let mut mean = images[0].clone();
    let share = 1.0 / images.len() as f32;
    for (i, pixel) in mean.pixels.iter_mut().enumerate() {
        *pixel = std::array::from_fn(|c| images.iter().map(|image| image.pixels[i][c]).sum::<f32>() * share);
    }
    mean
}

/// Per tile, sums of two values of its pixels.
fn tiles([width, height]: [u32; 2], values: impl Fn(u32, u32) -> [f64; 2]) -> Vec<[f64; 2]> {
    let columns = width.div_ceil(TILE);
    let mut sums = vec![[0.0; 2]; (columns * height.div_ceil(TILE)) as usize];
    for y in 0..height {
        for x in 0..width {
            let sum = &mut sums[(y / TILE * columns + x / TILE) as usize];
            let [a, b] = values(x, y);
            *sum = [sum[0] + a, sum[1] + b];
        }
    }
    sums
}

/// (a - b) / (a + b), 0 where there is nothing.
fn contrast([a, b]: [f64; 2]) -> f64 {
    if a + b > 0.0 { (a - b) / (a + b) } else { 0.0 }
}

/// Per tile: -1 where all moves are vertical, 1 where all are horizontal.
fn anisotropy(size: [u32; 2], horizontal: &[f32], vertical: &[f32]) -> Vec<f64> {
    let at = |values: &[f32], x: u32, y: u32| f64::from(values.get((y * size[0] + x) as usize).copied().unwrap_or(0.0));
    tiles(size, |x, y| [at(horizontal, x, y), at(vertical, x, y)]).into_iter().map(contrast).collect()
}

/// Per tile: -1 where log-luminance changes only from left to right (vertical edges), 1 where only from top to bottom.
fn edges(image: &Image) -> Vec<f64> {
    let values = luminance(image);
    let floor = 0.01 * values.iter().sum::<f64>() / values.len() as f64;
    let [width, height] = image.size();
    let log = |x: u32, y: u32| (values[(y * width + x) as usize].max(0.0) + floor.max(1e-30)).ln();
    let squared = |x: u32, y: u32| {
        let across = log((x + 1).min(width - 1), y) - log(x.saturating_sub(1), y);
        let down = log(x, (y + 1).min(height - 1)) - log(x, y.saturating_sub(1));
        [down * down, across * across]
    };
    tiles([width, height], squared).into_iter().map(contrast).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_along_edges_correlate_with_them() {
        // Left half: horizontal stripes; right half: vertical ones.
        let value = |x: u32, y: u32| if x < 16 { y % 4 / 2 } else { x % 4 / 2 };
        let pixels = (0..16).flat_map(|y| (0..32).map(move |x| [value(x, y) as f32 + 0.5; 3])).collect();
        let edges = edges(&Image { width: 32, height: 16, pixels });
        assert_eq!(edges.len(), 8);
        assert!(edges[0] > 0.9 && edges[3] < -0.7, "{edges:?}");
        let along: Vec<f32> = (0..16).flat_map(|_| (0..32).map(|x| if x < 16 { 3.0 } else { 1.0 })).collect();
        let even = vec![2.0; 32 * 16];
        let moves = anisotropy([32, 16], &along, &even);
        assert!((moves[0] - 0.2).abs() < 1e-9 && (moves[2] + 1.0 / 3.0).abs() < 1e-9);
        assert!(correlation(&moves, &edges) > 0.99);
        let told = tell(&[moves.clone(), moves], &edges);
        assert!((told.spread - 0.8 / 3.0).abs() < 1e-6, "{}", told.spread);
    }
}
