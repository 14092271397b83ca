//! The supplement's section 6: similarity with and without normals.

use super::alpha::insets;
use super::detail::busiest;
use super::panels::Picture;
use super::plan::{Asked, Defaults, Kind, Run};
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, mean};
use super::{Findings, Study, work};
use crate::Result;
use crate::methods::{Budget, Method};

pub const STUDY: Study = Study {
    name: "normals",
    about: "similarity of paths by positions alone, and with normals",
    defaults: Defaults {
        scenes: &["displaced_wall"],
        size: [96, 72],
        budget: Budget::SamplesPerPixel(256),
        seeds: 16,
        reference_spp: 2048,
    },
    compares: true,
    runs,
    conclude,
};

const WITH: &str = "with normals";
const WITHOUT: &str = "without normals";
/// What counts as about 5 % more.
const ABOUT: [f64; 2] = [1.025, 1.10];

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    let scene = asked.only_scene(STUDY.name)?;
    let run = |seed: u32, variant: &str| {
        let mut run = Run { kind: Kind::Image { kept: true }, ..asked.run(scene, variant, Method::Emlt, seed) };
        run.settings.guidance.normals = variant == WITH;
        run
    };
    Ok(asked.seeds.iter().flat_map(|seed| [WITH, WITHOUT].map(|variant| run(*seed, variant))).collect())
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scene = findings.asked.only_scene(STUDY.name)?;
    report.heading(&format!("Error of {scene} (means over the seeds)"));
    let mut table = Vec::new();
    for variant in [WITH, WITHOUT] {
        let value = |figure| mean(&findings.values(Some(scene), variant, figure));
        table.push(vec![
            variant.to_string(),
            short(value(|f| f.mse)),
            short(value(|f| f.rel_mse)),
            short(value(|f| f.rel_mse_4x4)),
            short(value(|f| f.flip)),
            format!("{:.1} %", 100.0 * value(|f| f.guided_acceptance)),
        ]);
    }
    let header = ["similarity", "MSE", "relMSE", "relMSE of 4x4", "FLIP", "guided lens steps accepted"];
    report.table(&header, table.clone());
    report.csv("normals", &header, &table)?;
    if let Some(reference) = findings.reference(scene) {
        let mut pictures = Vec::new();
        for variant in [WITH, WITHOUT] {
            if let Some(first) = findings.of(Some(scene), variant).next() {
                pictures.extend(work::image(first)?.image("").map(|image| (variant.to_string(), Picture::of(&image))));
            }
        }
        pictures.push(("reference".into(), Picture::of(&reference.image)));
        let rows = insets(pictures, busiest(&reference.image));
        report.pictures("normals", &rows, "First seed; below, the part with the most detail in the reference.")?;
    }
    let ratio = |figure| {
        Interval::of_ratio(&findings.values(Some(scene), WITH, figure), &findings.values(Some(scene), WITHOUT, figure))
    };
    let [mse, rel_mse] = [ratio(|f| f.mse), ratio(|f| f.rel_mse)];
    let verdict = if mse.below(ABOUT[0]) || mse.above(ABOUT[1]) {
        Verdict::Disagrees
    } else if mse.above(1.0) {
        Verdict::Agrees
    } else {
        Verdict::Undecided
    };
    report.claim(
        "Without normals MSE is reduced by around 5 % compared to including normals.",
        verdict,
        &format!(
            "MSE with normals over that without, seed by seed: {}; relMSE: {}. It agrees where the 95 % interval of the first \
             is above 1 and reaches into {} to {}, and does not where it lies wholly outside of what counts as about 5 %.",
            mse.text(3),
            rel_mse.text(3),
            ABOUT[0],
            ABOUT[1]
        ),
    );
    Ok(())
}
