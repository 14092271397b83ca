//! What an image file says about how it was made.

use crate::film::exr::Attribute;
use crate::methods::{Method, Settings};
use crate::report::statistics::Statistics;
use crate::scene::Scene;

/// Header attributes of a finished render: counts and seeds as numbers, times in seconds (of autocorrelation in mutations),
/// b in radiance.
pub fn attributes(scene: &Scene, settings: &Settings, statistics: &Statistics) -> Vec<(String, Attribute)> {
    let samples = if settings.method == Method::Pt { "samples" } else { "mutations" };
    let mut list: Vec<(&str, Attribute)> = vec![
        ("scene", scene.name.as_str().into()),
        ("method", settings.method.name().into()),
        ("seed", f64::from(settings.seed).into()),
        ("maxDepth", f64::from(settings.max_depth).into()),
        (samples, (statistics.samples as f64).into()),
        ("seconds", statistics.render_s.into()),
        ("device", statistics.device.as_str().into()),
        // EXR reserves plain `version`.
        ("emltVersion", env!("CARGO_PKG_VERSION").into()),
    ];
    // EXR reserves plain `aperture` and `focus`.
    if let Some(lens) = settings.lens {
        list.push(("lensDiameter", f64::from(lens.aperture).into()));
        list.push(("focusDistance", f64::from(lens.focus).into()));
    }
    if statistics.path_traced_samples > 0 {
        list.push(("pathTracedSamples", (statistics.path_traced_samples as f64).into()));
    }
    if let Some(gamma) = settings.two_stage {
        list.push(("twoStage", gamma.into()));
    }
    if let Some((b, standard_error)) = statistics.b {
        list.push(("b", b.into()));
        list.push(("bStandardError", standard_error.into()));
    }
    if let Some(error) = statistics.error {
        list.push(("errorPixels", error.pixels.into()));
        list.push(("errorTiles", error.tiles.into()));
        list.push(("filmMean", error.film.into()));
        list.push(("filmMeanStandardError", error.film_error.into()));
    }
    if let Some(mixing) = &statistics.mixing {
        list.push(("longestWait", (mixing.longest_wait as f64).into()));
        list.extend(mixing.memory.map(|mutations| ("autocorrelationTime", mutations.into())));
        list.extend(mixing.effective.map(|samples| ("effectiveSamples", samples.into())));
        if let Some([log_i, edges]) = mixing.r_hat {
            list.push(("rHatLogI", log_i.into()));
            list.push(("rHatEdges", edges.into()));
        }
    }
    if !statistics.kernels.is_empty() {
        list.push(("ensemble", f64::from(settings.ensemble).into()));
        list.push(("candidates", f64::from(settings.candidates).into()));
        list.push(("groups", f64::from(statistics.error.map_or(1, |error| error.groups)).into()));
        let guidance = settings.guidance;
        list.push(("guides", f64::from(guidance.guides).into()));
        list.push(("alphaLow", f64::from(guidance.alpha[0]).into()));
        list.push(("alphaHigh", f64::from(guidance.alpha[1]).into()));
        list.push(("similarity", if guidance.normals { "normals" } else { "positions" }.into()));
        list.push(("kernelMix", kernel_mix(statistics).as_str().into()));
    }
    list.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// Each kernel with its share of the mutations, as `lens 0.250, caustic 0.250`.
fn kernel_mix(statistics: &Statistics) -> String {
    let total: u64 = statistics.kernels.iter().map(|k| k.mutations).sum();
    let share = |mutations: u64| mutations as f64 / total.max(1) as f64;
    let parts: Vec<String> =
        statistics.kernels.iter().map(|k| format!("{} {:.3}", k.name, share(k.mutations))).collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::mixing::MixingStatistics;
    use crate::film::{Image, exr};
    use crate::report::statistics::KernelStatistics;
    use crate::scene::Lens;

    fn value<'a>(list: &'a [(String, Attribute)], name: &str) -> Option<&'a Attribute> {
        list.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }

    #[test]
    fn mlt_says_what_made_the_image() {
        let kernel = |name: &str, mutations| KernelStatistics { name: name.into(), mutations, ..Default::default() };
        let statistics = Statistics {
            samples: 400,
            b: Some((0.5, 0.01)),
            path_traced_samples: 50,
            kernels: vec![kernel("lens", 100), kernel("bidirectional", 300)],
            mixing: Some(MixingStatistics {
                longest_wait: 70,
                effective: Some(5.5),
                r_hat: Some([1.5, 1.25]),
                ..Default::default()
            }),
            ..Default::default()
        };
        let scene = Scene { name: "box".into(), ..Default::default() };
        let settings = Settings { two_stage: Some(0.5), ..Default::default() };
        let list = attributes(&scene, &settings, &statistics);
        assert_eq!(value(&list, "scene"), Some(&"box".into()));
        assert_eq!(value(&list, "method"), Some(&"emlt".into()));
        assert_eq!(value(&list, "mutations"), Some(&400.0.into()));
        assert_eq!(value(&list, "pathTracedSamples"), Some(&50.0.into()));
        assert_eq!(value(&list, "twoStage"), Some(&0.5.into()));
        assert_eq!(value(&list, "bStandardError"), Some(&0.01.into()));
        assert_eq!(value(&list, "kernelMix"), Some(&"lens 0.250, bidirectional 0.750".into()));
        let mixing = [("longestWait", 70.0), ("effectiveSamples", 5.5), ("rHatLogI", 1.5), ("rHatEdges", 1.25)];
        assert!(mixing.iter().all(|(name, number)| value(&list, name) == Some(&(*number).into())));
        assert_eq!(value(&list, "autocorrelationTime"), None);
    }

    #[test]
    fn pt_has_samples_and_no_b() {
        let settings = Settings { method: Method::Pt, ..Default::default() };
        let list = attributes(&Scene::default(), &settings, &Statistics { samples: 7, ..Default::default() });
        assert_eq!(value(&list, "samples"), Some(&7.0.into()));
        for absent in ["mutations", "pathTracedSamples", "twoStage", "b", "bStandardError", "kernelMix", "ensemble"] {
            assert_eq!(value(&list, absent), None, "{absent}");
        }
    }

    /// EXR reserves some names; a render must not be lost to one of them.
    #[test]
    fn the_attributes_survive_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let image = Image { width: 1, height: 1, pixels: vec![[1.0; 3]] };
        let statistics = Statistics {
            device: "d".repeat(300),
            b: Some((0.5, 0.01)),
            kernels: vec![KernelStatistics::default()],
            ..Default::default()
        };
        for method in [Method::Pt, Method::Emlt] {
            let lens = Some(Lens { aperture: 0.25, focus: 3.0 });
            let settings = Settings { method, lens, ..Default::default() };
            let mut list = attributes(&Scene::default(), &settings, &statistics);
            exr::write(&path, &image, &[], &list).unwrap();
            list.sort_by(|a, b| a.0.cmp(&b.0));
            assert_eq!(exr::read(&path).unwrap().attributes, list);
        }
    }
}
