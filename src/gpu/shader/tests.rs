//! Every shader that can be asked for composes and validates.

use rayon::prelude::*;

use super::*;
use crate::ensemble::pool::MAX_EDGES;

/// Every combination of features with every flag set that the renderer uses, and some with those that its tests use.
#[test]
fn every_shader_of_every_feature_set_validates() {
    let flag_sets: [(&str, &[&[&str]]); 16] = [
        (
            "bidirectional",
            &[
                &["segment"],
                &["segment", "maps"],
                &["segment", "guided"],
                &["segment", "guided", "maps"],
                &["segment", "two_stage"],
                &["segment", "maps", "two_stage"],
                &["segment", "guided", "two_stage"],
                &["segment", "guided", "maps", "two_stage"],
                &["segment", "path_traced"],
                &["segment", "guided", "two_stage", "path_traced"],
                &["segment", "twin_places"],
                &["segment", "twin_lens"],
                &["segment", "twin_blocked"],
                &["segment", "guided", "twin_places"],
                &["segment", "probe"],
                &["segment", "guided", "probe"],
                &["segment", "probe", "probe_back"],
                &["segment", "guided", "probe", "probe_back"],
                &["segment", "probe", "probe_density"],
                &["segment", "guided", "probe", "probe_density"],
            ],
        ),
        (
            "subpath",
            &[
                &["segment", "subpath"],
                &["segment", "subpath", "light_side"],
                &["segment", "subpath", "light_side", "guided"],
                &["segment", "subpath", "maps"],
                &["segment", "subpath", "two_stage", "path_traced"],
                &["segment", "subpath", "light_side", "maps", "two_stage"],
                &["segment", "subpath", "light_side", "guided", "path_traced"],
                &["segment", "subpath", "light_side", "guided", "maps", "two_stage", "path_traced"],
                &["segment", "subpath", "probe"],
                &["segment", "subpath", "probe", "probe_back"],
                &["segment", "subpath", "probe", "probe_density"],
                &["segment", "subpath", "twin_one_sided"],
                &["segment", "subpath", "twin_stop"],
                &["segment", "subpath", "light_side", "probe"],
                &["segment", "subpath", "light_side", "probe", "probe_back"],
                &["segment", "subpath", "light_side", "guided", "probe", "probe_back"],
                &["segment", "subpath", "light_side", "guided", "probe", "probe_density"],
            ],
        ),
        ("bootstrap", &[&[], &["path_traced"], &["sought"], &["path_traced", "sought"]]),
        ("photons", &[&[]]),
        ("gather", &[&[]]),
        ("crossover", &[&[], &["path_traced"]]),
        ("exchange", &[&[], &["maps"], &["two_stage"], &["maps", "two_stage"], &["probe"], &["twin_one_sided"]]),
        ("weigh", &[&[], &["probe"], &["sought"]]),
        (
            "independence",
            &[
                &[],
                &["maps"],
                &["two_stage"],
                &["maps", "two_stage"],
                &["path_traced"],
                &["maps", "path_traced"],
                &["two_stage", "path_traced"],
                &["maps", "two_stage", "path_traced"],
                &["sought"],
                &["two_stage", "sought"],
                &["two_stage", "path_traced", "sought"],
                &["maps", "two_stage", "path_traced", "sought"],
            ],
        ),
        ("rest", &[&[], &["maps"], &["two_stage"], &["maps", "two_stage"]]),
        ("path_trace", &[&[], &["path_traced"]]),
        ("bsdf_probe", &[&[], &["probe"]]),
        ("surface_probe", &[&[]]),
        ("chain_probe", &[&["manifold"], &["manifold", "twin_flat"]]),
        (
            "light_side",
            &[
                &[],
                &["maps"],
                &["guided"],
                &["guided", "maps"],
                &["two_stage"],
                &["maps", "two_stage"],
                &["guided", "two_stage"],
                &["guided", "maps", "two_stage"],
                &["probe"],
                &["probe", "guided"],
                &["probe", "probe_back"],
                &["probe", "guided", "probe_back"],
                &["probe", "probe_still"],
                &["probe", "probe_density"],
                &["probe", "guided", "probe_density"],
                &["guided", "twin_one_sided"],
            ],
        ),
        (
            "camera_side",
            &[
                &["walk"],
                &["walk", "kept_weights"],
                &["difference"],
                &["jump"],
                &["walk", "two_stage"],
                &["walk", "kept_weights", "two_stage"],
                &["difference", "two_stage"],
                &["jump", "two_stage"],
                &["walk", "probe"],
                &["walk", "kept_weights", "probe"],
                &["difference", "probe"],
                &["jump", "probe"],
                &["walk", "probe", "probe_back"],
                &["walk", "kept_weights", "probe", "probe_back"],
                &["difference", "probe", "probe_back"],
                &["jump", "probe", "probe_back"],
                &["walk", "probe", "probe_density"],
                &["walk", "kept_weights", "probe", "probe_density"],
                &["difference", "probe", "probe_density"],
                &["jump", "probe", "probe_density"],
                &["probe", "probe_density"],
                &["probe", "guided", "probe_density"],
                &["multi_chain", "probe", "probe_density"],
                &["multi_chain", "probe", "guided", "probe_density"],
                &["jump", "twin_one_sided"],
                &["multi_chain", "manifold"],
                &["multi_chain", "manifold", "maps"],
                &["multi_chain", "manifold", "two_stage"],
                &["multi_chain", "manifold", "maps", "two_stage"],
                &["multi_chain", "manifold", "probe"],
                &["multi_chain", "manifold", "probe", "probe_back"],
                &["multi_chain", "manifold", "probe", "probe_still"],
                &["multi_chain", "manifold", "twin_spread"],
                &["multi_chain", "manifold", "twin_way_back"],
                &["multi_chain"],
                &["multi_chain", "maps"],
                &["multi_chain", "guided"],
                &["multi_chain", "guided", "maps"],
                &["multi_chain", "two_stage"],
                &["multi_chain", "maps", "two_stage"],
                &["multi_chain", "guided", "two_stage"],
                &["multi_chain", "guided", "maps", "two_stage"],
                &["two_stage"],
                &["maps", "two_stage"],
                &["guided", "two_stage"],
                &["guided", "maps", "two_stage"],
                &["twin_acceptance", "two_stage"],
                &["twin_splat", "two_stage"],
                &["multi_chain", "probe"],
                &["multi_chain", "probe", "guided"],
                &["multi_chain", "probe", "probe_back"],
                &["multi_chain", "probe", "guided", "probe_back"],
                &["multi_chain", "probe", "probe_still"],
                &["multi_chain", "guided", "twin_one_sided"],
                &["multi_chain", "twin_jacobian"],
                &["twin_jacobian"],
                &[],
                &["maps"],
                &["guided"],
                &["guided", "maps"],
                &["probe"],
                &["probe", "guided"],
                &["probe", "probe_back"],
                &["probe", "guided", "probe_back"],
                &["probe", "probe_still"],
                &["probe", "guided", "probe_still"],
                &["guided", "twin_one_sided"],
                &["guided", "twin_id"],
                &["guided", "twin_redraw"],
            ],
        ),
    ];
    // Textures do not touch the rest, so each of their flags has been on and off, with few and with many others.
    let textured = [
        Features::default(),
        Features { textured: true, ..Features::default() },
        Features { textured: true, second_coordinates: true, emission_mapped: true, ..Features::default() },
        Features {
            textured: true,
            second_coordinates: true,
            normal_mapped: true,
            vertex_colored: true,
            emission_mapped: true,
            masked: true,
            ..Features::default()
        },
        Features { blended: true, ..Features::default() },
        Features { mixed: true, absorbing: true, ..Features::default() },
        Features { absorbing: true, ..Features::default() },
        Features { mixed: true, environment: true, ..Features::default() },
        Features { textured: true, blended: true, masked: true, ..Features::default() },
        Features { coated: true, ..Features::default() },
        Features { sheen: true, ..Features::default() },
        Features { orthographic: true, ..Features::default() },
        Features { orthographic: true, mixed: true, ..Features::default() },
        Features { aperture: true, ..Features::default() },
        Features { split: true, ..Features::default() },
        Features { split: true, textured: true, emission_mapped: true, ..Features::default() },
        Features { aperture: true, mixed: true, ..Features::default() },
        Features { culled: true, ..Features::default() },
        Features { culled: true, split: true, aperture: true, mixed: true, ..Features::default() },
        Features {
            culled: true,
            orthographic: true,
            textured: true,
            masked: true,
            blended: true,
            ..Features::default()
        },
        Features {
            textured: true,
            vertex_colored: true,
            emission_mapped: true,
            emission_colored: true,
            ..Features::default()
        },
        Features { anisotropic: true, textured: true, normal_mapped: true, ..Features::default() },
        Features {
            coated: true,
            sheen: true,
            anisotropic: true,
            textured: true,
            normal_mapped: true,
            blended: true,
            ..Features::default()
        },
    ];
    let mut sets = Vec::new();
    for (bits, textured) in (0..64u32).flat_map(|bits| textured.map(|textured| (bits, textured))) {
        if textured != Features::default() && ![0, 63].contains(&bits) {
            continue;
        }
        let features = Features {
            glossy: bits & 1 != 0,
            mirror: bits & 2 != 0,
            glass: bits & 4 != 0,
            rough_glass: bits & 8 != 0,
            narrow: bits & 16 != 0,
            sky: bits & 32 != 0,
            ..textured
        };
        // What light goes past is a class of specular vertices.
        let features = Features {
            mirror: features.mirror || features.blended,
            glass: features.glass || features.blended,
            sky: features.sky || features.environment,
            ..features
        };
        let specular = features.glass || features.narrow;
        if (specular && !features.mirror) || (features.rough_glass && !features.glossy) {
            continue; // glass reflects, so it always brings the reflection of its kind
        }
        sets.push(features);
    }
    let mut wanted: Vec<(Features, u32)> = sets.into_iter().map(|features| (features, 12)).collect();
    // Long type keys touch neither materials nor lights.
    wanted.extend((0..8).map(|bits| {
        let (mirror, sky, aperture) = (bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
        (Features { mirror, sky, aperture, ..Features::default() }, MAX_EDGES)
    }));
    // What tests alone compile is nearly half of all: every seventh set has to do, in which every feature is on and off.
    let of_tests = |flags: &[&str]| flags.iter().any(|flag| flag.starts_with("probe") || flag.starts_with("twin"));
    wanted.par_iter().enumerate().for_each(|(i, &(features, max_edges))| {
        for (pass, sets) in flag_sets {
            for flags in sets.iter().filter(|flags| i.is_multiple_of(7) || !of_tests(flags)) {
                let variant = Variant { pass, features, max_edges, flags: flags.to_vec() };
                let text = compose(&variant).unwrap_or_else(|e| panic!("{variant:?}: {e}"));
                validate(&text).unwrap_or_else(|e| panic!("{variant:?}: {e}"));
            }
        }
    });
}

/// Without a lens its module is not there; the same rule holds for every feature.
#[test]
fn a_pinhole_has_nothing_of_a_lens() {
    for pass in ["camera_side", "bidirectional", "path_trace"] {
        let text = |aperture| {
            let features = Features { aperture, ..Features::default() };
            let flags = if pass == "bidirectional" { vec!["segment"] } else { vec![] };
            compose(&Variant { pass, features, max_edges: 12, flags }).unwrap()
        };
        assert!(text(true).contains("lens_word") && !text(false).contains("lens_word"), "{pass}");
        assert!(text(true).contains("lens_point") && !text(false).contains("lens_point"), "{pass}");
    }
}

/// Up to 32 edges, type keys have two words.
#[test]
fn short_paths_have_nothing_of_long_keys() {
    for pass in ["bootstrap", "camera_side", "crossover", "exchange", "weigh"] {
        let text =
            |max_edges| compose(&Variant { pass, features: Features::default(), max_edges, flags: vec![] }).unwrap();
        assert!(text(33).contains("ROW_LENS") && !text(32).contains("ROW_LENS"), "{pass}");
    }
}

/// Where no back is culled, rays are not told whose they are.
#[test]
fn shaders_without_culling_know_of_none() {
    for pass in ["camera_side", "light_side", "independence", "path_trace"] {
        let text = |culled| {
            let features = Features { culled, mirror: true, ..Features::default() };
            compose(&Variant { pass, features, max_edges: 12, flags: vec![] }).unwrap()
        };
        for name in ["is_culled", "from_camera"] {
            assert!(text(true).contains(name), "{pass}: {name}");
        }
        assert!(!text(false).contains("is_culled"), "{pass}");
    }
}

#[test]
fn an_unknown_flag_is_an_error() {
    let variant = Variant { pass: "rest", features: Features::default(), max_edges: 12, flags: vec!["gided"] };
    assert!(compose(&variant).unwrap_err().contains("gided"));
}

/// The composer misreads hexadecimal floats.
#[test]
fn no_shader_has_a_hexadecimal_float() {
    fn check(dir: &Dir) {
        for file in dir.files() {
            let text = file.contents_utf8().unwrap();
            for (n, line) in text.lines().enumerate() {
                let hex_float = line.split("0x").skip(1).any(|rest| {
                    rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '.')
                        .next()
                        .is_some_and(|word| word.contains('p') || word.contains('.'))
                });
                assert!(!hex_float, "{}:{}", file.path().display(), n + 1);
            }
        }
        dir.dirs().for_each(check);
    }
    check(&SOURCES);
}
