//! The supplement's section 1: the size of guided steps, fixed or by similarity.

use super::detail::busiest;
use super::panels::{Panel, Picture, zoom};
use super::plan::{Asked, Defaults, Kind, Run};
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, mean};
use super::{Findings, Study, work};
use crate::Result;
use crate::methods::{Budget, Method};

pub const STUDY: Study = Study {
    name: "alpha",
    about: "size of guided steps: static 0.05, static 0.5, and between them by similarity (sigmoid)",
    defaults: Defaults {
        scenes: &["ajar"],
        size: [96, 72],
        budget: Budget::SamplesPerPixel(256),
        seeds: 16,
        reference_spp: 4096,
    },
    compares: true,
    runs,
    conclude,
};

const SIGMOID: &str = "sigmoid";
const VARIANTS: [(&str, [f32; 2]); 3] =
    [("static 0.05", [0.05, 0.05]), (SIGMOID, [0.05, 0.5]), ("static 0.5", [0.5, 0.5])];

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    let scene = asked.only_scene(STUDY.name)?;
    let run = |seed: u32, (variant, alpha): (&str, [f32; 2])| {
        let mut run = Run { kind: Kind::Image { kept: true }, ..asked.run(scene, variant, Method::Emlt, seed) };
        run.settings.guidance.alpha = alpha;
        run
    };
    Ok(asked.seeds.iter().flat_map(|seed| VARIANTS.map(|variant| run(*seed, variant))).collect())
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scene = findings.asked.only_scene(STUDY.name)?;
    report.heading(&format!("Error of {scene} (means over the seeds)"));
    let sigmoid = findings.values(Some(scene), SIGMOID, |f| f.rel_mse);
    let mut table = Vec::new();
    for (variant, _) in VARIANTS {
        let value = |figure| mean(&findings.values(Some(scene), variant, figure));
        let ratio = Interval::of_ratio(&findings.values(Some(scene), variant, |f| f.rel_mse), &sigmoid);
        table.push(vec![
            variant.to_string(),
            short(value(|f| f.mse)),
            short(value(|f| f.rel_mse)),
            short(value(|f| f.rel_mse_4x4)),
            short(value(|f| f.flip)),
            format!("{:.1} %", 100.0 * value(|f| f.guided_acceptance)),
            if variant == SIGMOID { "1".into() } else { ratio.text(3) },
        ]);
    }
    report.table(&HEADER, table.clone());
    report.csv("alpha", &HEADER, &table)?;
    pictures(findings, scene, report)?;
    let ratio = |variant: &str, figure| {
        Interval::of_ratio(
            &findings.values(Some(scene), variant, figure),
            &findings.values(Some(scene), SIGMOID, figure),
        )
    };
    let [low, high] = [VARIANTS[0].0, VARIANTS[2].0].map(|variant| ratio(variant, |f| f.rel_mse));
    let [low_4x4, high_4x4] = [VARIANTS[0].0, VARIANTS[2].0].map(|variant| ratio(variant, |f| f.rel_mse_4x4));
    report.claim(
        "The sigmoid between the two extremes is better than either static alpha.",
        Verdict::all_above_one(&[low, high]),
        &format!(
            "relMSE over that of the sigmoid, seed by seed: static 0.05 {}, static 0.5 {}; of 4x4 means, which show \
             low-frequency noise: {} and {}. It agrees where both of the first pair's 95 % intervals are above 1, and does \
             not where one is below.",
            low.text(3),
            high.text(3),
            low_4x4.text(3),
            high_4x4.text(3)
        ),
    );
    Ok(())
}

const HEADER: [&str; 7] = [
    "alpha",
    "MSE",
    "relMSE",
    "relMSE of 4x4",
    "FLIP",
    "guided lens steps accepted",
    "relMSE over that of the sigmoid",
];

/// The film, and below it the part with the most detail, of the first seed.
fn pictures(findings: &Findings, scene: &str, report: &mut Report) -> Result<()> {
    let Some(reference) = findings.reference(scene) else { return Ok(()) };
    let window = busiest(&reference.image);
    let mut pictures = Vec::new();
    for (variant, _) in VARIANTS {
        if let Some(first) = findings.of(Some(scene), variant).next() {
            pictures.extend(work::image(first)?.image("").map(|image| (variant.to_string(), Picture::of(&image))));
        }
    }
    pictures.push(("reference".into(), Picture::of(&reference.image)));
    let rows = insets(pictures, window);
    report.pictures(
        "alpha",
        &rows,
        &format!("First seed; below, the part of {scene} with the most detail in the reference."),
    )
}

/// A row of films with the window outlined, and one of the windows.
pub fn insets(pictures: Vec<(String, Picture)>, window: [u32; 4]) -> Vec<Vec<Panel>> {
    let films = pictures.iter().map(|(caption, picture)| {
        let zoom = zoom(picture.width);
        let outlined = window.map(|side| side * zoom);
        Panel { caption: caption.clone(), picture: picture.enlarge(zoom).outline(outlined) }
    });
    let parts = pictures
        .iter()
        .map(|(_, picture)| Panel { caption: String::new(), picture: picture.crop(window).enlarge(zoom(window[2])) });
    vec![films.collect(), parts.collect()]
}
