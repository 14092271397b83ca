//! What the manifold kernel needs besides the proofs of all: its derivatives are those of the chains that are followed, and
//! it takes no step that it does not come back from.

use std::collections::BTreeSet;

use emlt::kernels::{Family, Kernel, manifold};
use emlt::scene::Scene;
use glam::Vec3;

use crate::bench::{Bench, Guides, HALF, context};
use crate::{
    FEWER, GLOSSY, RARE, SPECULAR_SCENE, asymmetric_share, check_stationarity_on, check_symmetry, rooms, scene_of,
};

/// A pass that follows chains as if it were a kernel.
const CHAIN_PROBE: Kernel = Kernel {
    name: "chain probe",
    about: "",
    pass: "chain_probe",
    flags: &["manifold"],
    family: Family::CameraSide,
    applies: manifold::applies,
    useless: |_| None,
    guided: false,
};

/// Differences above this part of the derivative: those of the followed chains have rounding and curvature in them.
const APART: f64 = 0.02;

/// Share of the chains whose derivatives differ from the differences, out of those that can be followed.
fn differing(bench: &mut Bench, flags: &[&'static str]) -> f64 {
    bench.fill_with(&manifold::KERNEL);
    let (uniform, paths) = bench.list(&manifold::KERNEL, HALF / 2, Guides::Other);
    bench.passes(&CHAIN_PROBE, flags, uniform, 1..2);
    let records = bench.records(2 * paths.len() as u32);
    let numbers = |row: &[f32; 4]| row.map(f64::from);
    let (mut all, mut differ) = (0, 0);
    for pair in records.chunks_exact(2).filter(|pair| pair[1][0] > -1e29) {
        let [carried, followed] = [&pair[0], &pair[1]].map(numbers);
        let apart = carried.iter().zip(&followed).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = carried.iter().map(|a| a * a).sum::<f64>().sqrt();
        all += 1;
        differ += usize::from(apart > APART * size);
    }
    println!("{flags:?}: {differ} of {all} chains differ, {} cannot be followed", paths.len() - all);
    assert!(all > 2_000, "only {all} chains");
    differ as f64 / all as f64
}

/// A scene whose specular surfaces are bent by their normals, as smooth-shaded meshes are: its flat glass and metal become
/// lenses and curved mirrors.
fn bent(mut scene: Scene) -> Scene {
    for (number, material) in scene.materials.iter().enumerate() {
        if material.transmission == 0.0 && !material.is_specular() {
            continue;
        }
        let of_it = scene.triangles.iter().zip(&scene.triangle_materials).filter(|(_, m)| **m as usize == number);
        let corners: BTreeSet<usize> = of_it.flat_map(|(triangle, _)| triangle.map(|i| i as usize)).collect();
        let centre = corners.iter().map(|&i| scene.positions[i]).sum::<Vec3>() / corners.len().max(1) as f32;
        for &i in &corners {
            let outwards = (scene.positions[i] - centre).normalize_or_zero();
            // The same side of glass as before.
            scene.normals[i] = (scene.normals[i] + 0.2 * outwards).normalize();
        }
    }
    scene
}

/// On bent glass and metal, smooth and with lobes that are passed with kept half-vectors, and through thin panes. The twin takes
/// bent surfaces for flat ones.
#[test]
fn derivatives_are_those_of_chains_that_are_followed() {
    let context = context();
    // With the least share by which the twin has to be told: what goes straight through a pane is bent by nothing.
    let scenes = [
        ("bent lamp in glass", bent(scene_of(SPECULAR_SCENE)), 0.9),
        ("bent glossy box", bent(scene_of(GLOSSY)), 0.9),
        ("bent glazed room", bent(rooms::glazed_room()), 0.9),
        ("bent polished room", bent(rooms::polished_room()), 0.2),
    ];
    for (name, scene, told) in scenes {
        let mut bench = Bench::of(&context, &scene);
        let shares = [&[][..], &["twin_flat"]].map(|flags| differing(&mut bench, flags));
        println!("{name}: {shares:.4?}");
        // Neighbours of a few go by another face.
        assert!(shares[0] < 0.02, "{name}: {shares:?}");
        assert!(shares[1] > told, "{name}: the twin that takes bent surfaces for flat ones passes: {shares:?}");
    }
}

/// The twin leaves out how solid angles change to areas on the way.
#[test]
fn chains_over_bent_surfaces_leave_the_target_alone() {
    let twins = [(&manifold::KERNEL, "twin_spread", 45_000)];
    let context = context();
    let mut bench = Bench::of(&context, &bent(scene_of(SPECULAR_SCENE)));
    check_stationarity_on(&mut bench, "bent lamp in glass", &[&manifold::KERNEL], &twins, &FEWER[2..]);
    let mut bench = Bench::of(&context, &bent(scene_of(GLOSSY)));
    check_stationarity_on(&mut bench, "bent glossy box", &[&manifold::KERNEL], &[], &RARE);
}

/// Log ratios cancel on bent surfaces. Without a look at the way back the kernel takes steps to solutions from which another
/// one is found.
#[test]
fn no_step_is_taken_that_is_not_come_back_from() {
    let context = context();
    for (name, scene) in [("bent lamp in glass", SPECULAR_SCENE), ("bent glossy box", GLOSSY)] {
        let mut bench = Bench::of(&context, &bent(scene_of(scene)));
        check_symmetry(&mut bench, name, &[&manifold::KERNEL], 100_000);
    }
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    let (share, n) = asymmetric_share(&mut bench, &manifold::KERNEL, &["twin_way_back"], Guides::Other, 50_000);
    println!("twin, without a look at the way back: {share:.2e} of {n} proposals asymmetric");
    assert!(share > 0.02, "the twin without a look at the way back passes: {share}");
}
