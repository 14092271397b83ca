//! The supplement's section 6: similarity with and without normals.

use super::plan::{Asked, Defaults, Run};
use super::report::{Report, Verdict};
use super::{ERRORS, Findings, Study, insets};
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
    asked.only_scene(STUDY.name)?;
    Ok(asked.runs([WITH, WITHOUT], |scene, variant, seed| {
        let mut run = asked.kept(scene, variant, Method::Emlt, seed);
        run.settings.guidance.normals = variant == WITH;
        run
    }))
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scene = findings.asked.only_scene(STUDY.name)?;
    report.heading(&format!("Error of {scene} (means over the seeds)"));
    let row = |variant: &str| [&[variant.to_string()][..], &findings.errors(scene, variant)].concat();
    report.table("normals", &[&["similarity"][..], &ERRORS].concat(), &[WITH, WITHOUT].map(row))?;
    insets::write(report, "normals", findings, scene, &[WITH, WITHOUT])?;
    let ratio = |figure| findings.ratio(scene, [WITH, WITHOUT], figure);
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
