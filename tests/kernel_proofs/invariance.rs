//! Weighted paired stationarity of every kernel on its scene, with the twins that must be caught.

use emlt::kernels::{
    Kernel, bidirectional, guided_bidirectional, guided_caustic, guided_lens, guided_multi_chain, jump, lens, manifold,
};

use crate::bench::{Bench, context};
use crate::stationarity::{Moved, Plan, alike, verdicts};
use crate::{GLOSSY, PERTURBATIONS, SCENE, SPECULAR_SCENE, STRUCTURAL};

/// Corresponds to an error probability of 1e-6 a bin: with the bins of all kernels and steps together below 3e-2, on a GPU
/// below 0.1.
pub const Z_LIMIT: f64 = 4.9;
/// Steps after which a kernel's chains are looked at, and how many of them at least: a million as far as that takes
/// seconds on two cores; everywhere on a GPU.
pub const LOOKS: [(u32, usize); 4] = [(1, 1_000_000), (4, 1_000_000), (16, 250_000), (64, 60_000)];
/// The same of kernels that have these on another scene.
pub const FEWER: [(u32, usize); 3] = [(1, 250_000), (4, 250_000), (16, 250_000)];
/// The same where one candidate in a hundred is of the kernel's types.
pub const RARE: [(u32, usize); 3] = [(1, 50_000), (4, 50_000), (16, 50_000)];

/// A kernel with a twin's flag, and the chains that show it.
type Broken<'a> = (&'a Kernel, &'static str, usize);

/// METHOD.md 4.4 S1: weighted paired stationarity over image tiles and path lengths, for kernels and for twins that must
/// be caught.
pub fn check_stationarity(scene: &str, kernels: &[&Kernel], twins: &[Broken], looks: &[(u32, usize)]) {
    let context = context();
    check_stationarity_on(&mut Bench::new(&context, scene), scene, kernels, twins, looks);
}

pub fn check_stationarity_on(
    bench: &mut Bench,
    scene: &str,
    kernels: &[&Kernel],
    twins: &[Broken],
    looks: &[(u32, usize)],
) {
    let looks = &on(bench, looks)[..];
    bench.publish_guides();
    // All are looked at before any is judged: one that fails hides no other.
    let mut beyond = Vec::new();
    for kernels in alike(bench, kernels) {
        let moved: Vec<Moved> = kernels.iter().map(|kernel| (*kernel, &[][..])).collect();
        let verdicts = verdicts(bench, &moved, Plan { looks, least: 0.0 });
        // After few steps few chains have left their bins.
        assert!(verdicts.iter().all(|looks| looks.iter().any(|z| z.bins > 0)), "{scene}: nothing to look at");
        for (kernel, verdicts) in kernels.iter().zip(verdicts) {
            for ((steps, _), z) in looks.iter().zip(verdicts) {
                println!(
                    "{scene}, {}, {steps} steps of {} chains: worst |z| {:.2} in {} bins, chi2 / dof {:.2}",
                    kernel.name, z.chains, z.worst, z.bins, z.chi2
                );
                if z.worst >= Z_LIMIT {
                    beyond.push(format!("{} after {steps} steps: |z| = {:.2}, {}", kernel.name, z.worst, z.worst_bin));
                }
            }
        }
    }
    for &(kernel, twin, chains) in twins {
        check_twin(bench, scene, (kernel, &[twin]), Plan { looks: &[(16, chains)], least: 0.0 });
    }
    assert!(beyond.is_empty(), "{scene}: {}", beyond.join("; "));
}

/// On a GPU at least a million chains after each of 1, 4, 16 and 64 steps.
fn on(bench: &Bench, looks: &[(u32, usize)]) -> Vec<(u32, usize)> {
    match bench.software {
        true => looks.to_vec(),
        false => [1, 4, 16, 64].map(|steps| (steps, looks[0].1.max(1_000_000))).to_vec(),
    }
}

/// A twin that must be caught.
fn check_twin(bench: &mut Bench, scene: &str, twin: Moved, plan: Plan) {
    let z = &verdicts(bench, &[twin], plan)[0][0];
    let name = format!("{scene}, {} with {:?}", twin.0.name, twin.1);
    println!("{name}: worst |z| {:.2} of {} chains, chi2 / dof {:.2}", z.worst, z.chains, z.chi2);
    assert!(z.worst > Z_LIMIT, "{name} passes: |z| = {}", z.worst);
}

#[test]
fn steps_on_the_film_leave_the_target_alone() {
    let twins = [
        (&guided_lens::KERNEL, "twin_one_sided", 90_000),
        (&guided_lens::KERNEL, "twin_redraw", 90_000),
        (&jump::KERNEL, "twin_one_sided", 90_000),
    ];
    check_stationarity(SCENE, PERTURBATIONS[0].1, &twins, &LOOKS);
}

#[test]
fn kernels_through_specular_vertices_leave_the_target_alone() {
    let twins = [
        (&guided_multi_chain::KERNEL, "twin_one_sided", 45_000),
        (&manifold::KERNEL, "twin_spread", 45_000),
        (&guided_caustic::KERNEL, "twin_one_sided", 45_000),
    ];
    let (kernels, specular) = PERTURBATIONS[1].1.split_at(1);
    check_stationarity(SPECULAR_SCENE, kernels, &[], &FEWER);
    check_stationarity(SPECULAR_SCENE, specular, &twins, &LOOKS);
}

/// The same where perturbations pass narrow lobes by their half-vectors.
#[test]
fn perturbations_through_gloss_leave_the_target_alone() {
    let context = context();
    let mut bench = Bench::new(&context, GLOSSY);
    let (at_the_camera, through_lobes) = PERTURBATIONS[2].1.split_at(2);
    check_stationarity_on(&mut bench, GLOSSY, at_the_camera, &[], &FEWER);
    check_stationarity_on(&mut bench, GLOSSY, through_lobes, &[], &RARE);
    // The Jacobian varies slowly along a step: it takes many.
    let least = 6.0 * bench.bootstrap.b.mean();
    check_twin(&mut bench, GLOSSY, (&lens::KERNEL, &["twin_jacobian"]), Plan { looks: &[(64, 230_000)], least });
}

#[test]
fn structural_kernels_leave_the_target_alone() {
    let twins =
        [(&bidirectional::KERNEL, "twin_places", 90_000), (&guided_bidirectional::KERNEL, "twin_places", 90_000)];
    check_stationarity(SCENE, &STRUCTURAL, &twins, &LOOKS);
    check_stationarity(SPECULAR_SCENE, &STRUCTURAL, &[], &FEWER[1..2]);
}

/// The long form: ten million chains of every kernel on every scene.
pub fn check_long(scene: &str, kernels: &[&Kernel]) {
    check_stationarity(scene, kernels, &[], &[1, 4, 16, 64].map(|steps| (steps, 10_000_000)));
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_on_the_film() {
    check_long(SCENE, PERTURBATIONS[0].1);
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_through_glass() {
    check_long(SPECULAR_SCENE, PERTURBATIONS[1].1);
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_through_gloss() {
    check_long(GLOSSY, PERTURBATIONS[2].1);
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_across_types() {
    check_long(SCENE, &STRUCTURAL);
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_across_types_in_glass() {
    check_long(SPECULAR_SCENE, &STRUCTURAL);
}

#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_kernels_leave_the_target_alone_across_types_in_gloss() {
    check_long(GLOSSY, &STRUCTURAL);
}
