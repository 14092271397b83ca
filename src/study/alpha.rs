//! The supplement's section 1: the size of guided steps, fixed or by similarity.

use super::plan::{Asked, Defaults, Run};
use super::report::{Report, Verdict};
use super::{ERRORS, Findings, Study, insets};
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
    asked.only_scene(STUDY.name)?;
    Ok(asked.runs(VARIANTS, |scene, (variant, alpha), seed| {
        let mut run = asked.kept(scene, variant, Method::Emlt, seed);
        run.settings.guidance.alpha = alpha;
        run
    }))
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scene = findings.asked.only_scene(STUDY.name)?;
    report.heading(&format!("Error of {scene} (means over the seeds)"));
    let ratio = |variant: &str, figure| findings.ratio(scene, [variant, SIGMOID], figure);
    let mut table = Vec::new();
    for (variant, _) in VARIANTS {
        let over = if variant == SIGMOID { "1".into() } else { ratio(variant, |f| f.rel_mse).text(3) };
        table.push([&[variant.into()][..], &findings.errors(scene, variant), &[over]].concat());
    }
    let header = [&["alpha"][..], &ERRORS, &["relMSE over that of the sigmoid"]].concat();
    report.table("alpha", &header, &table)?;
    insets::write(report, "alpha", findings, scene, &VARIANTS.map(|(variant, _)| variant))?;
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
