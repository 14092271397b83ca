//! The proofs where the camera is no pinhole.

use emlt::kernels::{Kernel, bidirectional, caustic, guided_lens, lens};
use emlt::scene::{Camera, Lens, Scene};

use crate::bench::{Bench, Guides, context};
use crate::{
    FEWER, GLOSSY, PERTURBATIONS, STRUCTURAL, asymmetric_share, check_factors, check_stationarity_on, independence,
    scene_of, structural,
};

/// Everything that is proven of perturbations, by an orthographic camera.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_of_an_orthographic_camera_leave_the_target_alone() {
    check_all("orthographic", &seen_by(|camera| camera.orthographic_height = Some(1.6)));
}

/// And through a thin lens.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_through_a_lens_leave_the_target_alone() {
    check_all("lens", &seen_by(|camera| camera.lens = Some(LENS)));
}

/// Perturbations keep the point on the lens, bidirectional mutations may draw it anew; the twin draws it unevenly and
/// leaves its density out.
#[test]
fn kernels_through_a_lens_are_exact() {
    let context = context();
    let scene = seen_by(|camera| camera.lens = Some(LENS));
    let mut bench = Bench::of(&context, &scene);
    check_symmetry(&mut bench, "lens", &[&lens::KERNEL, &guided_lens::KERNEL, &caustic::KERNEL], PROPOSALS);
    bench.publish_guides();
    let (share, n) = structural::asymmetric_share(&mut bench, &bidirectional::KERNEL, false, 300_000);
    println!("lens, bidirectional: {share:.2e} of {n} proposals asymmetric");
    assert!(share < 1e-3, "bidirectional: {share}");
    let twins = [(&bidirectional::KERNEL, "twin_lens", 80_000)];
    check_stationarity_on(&mut bench, "lens", &[&bidirectional::KERNEL], &twins, &FEWER[1..2]);
}

/// Proposals of a kernel in the short form, a fourth of those of the long one: they tell a share of 1e-3 as well.
pub const PROPOSALS: usize = 250_000;

/// As wide as a fifth of the room, and sharp behind the solids.
pub const LENS: Lens = Lens { aperture: 0.4, focus: 2.6 };

pub fn seen_by(change: impl Fn(&mut Camera)) -> Scene {
    let mut scene = scene_of(GLOSSY);
    change(&mut scene.cameras[0]);
    scene
}

pub fn check_symmetry(bench: &mut Bench, name: &str, kernels: &[&Kernel], proposals: usize) {
    for kernel in kernels {
        let (share, n) = asymmetric_share(bench, kernel, &[], Guides::Other, proposals);
        println!("{name}, {}: {share:.2e} of {n} proposals asymmetric", kernel.name);
        assert!(share < 1e-3, "{}: {share}", kernel.name);
    }
}

/// Everything that is proven of a camera.
pub fn check_all(name: &str, scene: &Scene) {
    let context = context();
    let mut bench = Bench::of(&context, scene);
    check_symmetry(&mut bench, name, PERTURBATIONS[2].1, 1_000_000);
    check_factors(&mut Bench::of(&context, scene));
    independence::check_ratios(&mut bench);
    check_stationarity_on(&mut bench, name, PERTURBATIONS[2].1, &[], &FEWER[2..]);
    check_stationarity_on(&mut bench, name, &STRUCTURAL, &[], &FEWER[1..2]);
}
