//! The supplement's section 7: thin caustics after few mutations.

use super::alpha::insets;
use super::detail::{busiest, detail};
use super::panels::Picture;
use super::plan::{Asked, Defaults, Kind, Run};
use super::references::Reference;
use super::report::{Report, Verdict, short};
use super::statistics::{Interval, correlation, mean};
use super::{Findings, Study, work};
use crate::Result;
use crate::film::Image;
use crate::methods::{Budget, Method};
use crate::scene::LUMINANCE;

pub const STUDY: Study = Study {
    name: "caustics",
    about: "caustics after few mutations per pixel by emlt, mlt and pt",
    // 8 mutations per pixel of this film are four whole sweeps of 16384 paths: nothing is rounded.
    defaults: Defaults {
        scenes: &["shards"],
        size: [320, 256],
        budget: Budget::SamplesPerPixel(8),
        seeds: 16,
        reference_spp: 512,
    },
    compares: true,
    runs,
    conclude,
};

const METHODS: [Method; 3] = [Method::Mlt, Method::Emlt, Method::Pt];
/// Share of the film's pixels that are thin features: those which stand out most from the 5x5 around.
const THIN: f64 = 0.05;

fn runs(asked: &Asked) -> Result<Vec<Run>> {
    let scene = asked.only_scene(STUDY.name)?;
    let run = |seed: u32, method: Method| Run {
        kind: Kind::Image { kept: true },
        ..asked.run(scene, method.name(), method, seed)
    };
    Ok(asked.seeds.iter().flat_map(|seed| METHODS.map(|method| run(*seed, method))).collect())
}

fn conclude(findings: &Findings, report: &mut Report) -> Result<()> {
    let scene = findings.asked.only_scene(STUDY.name)?;
    let Some(reference) = findings.reference(scene) else { return Ok(()) };
    let thin = thin(reference);
    let wanted = detail(&reference.image);
    let mut pictures = Vec::new();
    let mut errors = Vec::new();
    let mut table = Vec::new();
    for method in METHODS {
        let (mut of_thin, mut likeness) = (Vec::new(), Vec::new());
        for (number, finished) in findings.of(Some(scene), method.name()).enumerate() {
            let Some(image) = work::image(finished)?.image("") else { continue };
            if number == 0 {
                pictures.push((method.name().to_string(), Picture::of(&image)));
            }
            of_thin.push(error_of(&image, reference, &thin));
            likeness.push(correlation(&detail(&image), &wanted));
        }
        let value = |figure| mean(&findings.values(Some(scene), method.name(), figure));
        table.push(vec![
            method.name().into(),
            format!("{:.1}", value(|f| f.samples_per_pixel)),
            short(value(|f| f.mse)),
            short(value(|f| f.rel_mse)),
            short(value(|f| f.rel_mse_4x4)),
            short(mean(&of_thin)),
            Interval::of(&likeness).text(3),
        ]);
        errors.push(of_thin);
    }
    report.heading(&format!("Error of {scene} (means over the seeds)"));
    let header =
        ["method", "made per pixel", "MSE", "relMSE", "relMSE of 4x4", "MSE of thin features", "likeness of detail"];
    report.table(&header, table.clone());
    report.csv("caustics", &header, &table)?;
    report.paragraph(&format!(
        "Thin features: the {:.0} % of pixels that are, in the reference, brightest over the mean of the 5x5 pixels around, less twice the reference's noise. \
         Likeness of detail: correlation over the film of what stands out so in an image and in the reference; 1 is alike. \
         Ensembles move whole halves, so a little more than was asked for may be made per pixel.",
        100.0 * THIN
    ));
    pictures.push(("reference".into(), Picture::of(&reference.image)));
    let rows = insets(pictures, busiest(&reference.image));
    report.pictures("caustics", &rows, "First seed; below, the part with the most detail in the reference.")?;
    let [of_thin, whole] = [
        Interval::of_ratio(&errors[0], &errors[1]),
        Interval::of_ratio(
            &findings.values(Some(scene), "mlt", |f| f.mse),
            &findings.values(Some(scene), "emlt", |f| f.mse),
        ),
    ];
    report.claim(
        "At 8 mutations per pixel emlt captures thin features of the caustics better than mlt.",
        Verdict::all_above_one(&[of_thin]),
        &format!(
            "MSE of mlt over that of emlt, seed by seed: {} on thin features, {} on the whole film. It agrees where the 95 % \
             interval of the first is above 1, and does not where it is below.",
            of_thin.text(3),
            whole.text(3)
        ),
    );
    Ok(())
}

/// Whether each pixel is of a thin feature: those of which that is surest, as the reference has noise of its own.
fn thin(reference: &Reference) -> Vec<bool> {
    let noise = reference.variance.pixels.iter().map(|v| {
        // Of luminance, the channels taken as alike, which they are in noise.
        let deviations = v.map(|v| f64::from(v.max(0.0)).sqrt());
        LUMINANCE.dot(deviations.into())
    });
    let surely: Vec<f64> =
        detail(&reference.image).iter().zip(noise).map(|(detail, noise)| detail - 2.0 * noise).collect();
    let mut sorted = surely.clone();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let least = sorted[((THIN * sorted.len() as f64) as usize).min(sorted.len() - 1)];
    surely.iter().map(|d| *d > least).collect()
}

/// Mean squared error of those pixels, the reference's own noise subtracted.
fn error_of(image: &Image, reference: &Reference, chosen: &[bool]) -> f64 {
    let square = |i: usize, c: usize| {
        let difference = f64::from(image.pixels[i][c]) - f64::from(reference.image.pixels[i][c]);
        difference.powi(2) - f64::from(reference.variance.pixels[i][c])
    };
    let pixels: Vec<usize> = (0..chosen.len()).filter(|i| chosen[*i]).collect();
    pixels.iter().flat_map(|i| (0..3).map(move |c| (*i, c))).map(|(i, c)| square(i, c)).sum::<f64>()
        / (3 * pixels.len()) as f64
}
