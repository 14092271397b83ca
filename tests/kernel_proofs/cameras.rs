//! The proofs where the camera is no pinhole.

use emlt::kernels::{bidirectional, caustic, guided_lens, lens};
use emlt::scene::{Camera, Lens, Scene};

use crate::bench::{Bench, context};
use crate::everything::{ALL, prove};
use crate::{FEWER, GLOSSY, check_stationarity_on, check_symmetry, scene_of, structural};

/// Everything that is proven of kernels, by an orthographic camera.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_of_an_orthographic_camera_leave_the_target_alone() {
    prove("orthographic", &seen_by(|camera| camera.orthographic_height = Some(1.6)), &ALL);
}

/// And through a thin lens.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_through_a_lens_leave_the_target_alone() {
    prove("lens", &seen_by(|camera| camera.lens = Some(LENS)), &ALL);
}

/// Perturbations keep the point on the lens, bidirectional mutations may draw it anew; the twin draws it unevenly and
/// leaves its density out.
#[test]
fn kernels_through_a_lens_are_exact() {
    let context = context();
    let scene = seen_by(|camera| camera.lens = Some(LENS));
    let mut bench = Bench::of(&context, &scene);
    check_symmetry(&mut bench, "lens", &[&lens::KERNEL, &guided_lens::KERNEL, &caustic::KERNEL], PROPOSALS);
    structural::check_symmetry(&mut bench, "lens", &[&bidirectional::KERNEL], PROPOSALS);
    let twins = [(&bidirectional::KERNEL, "twin_lens", 80_000)];
    check_stationarity_on(&mut bench, "lens", &[&bidirectional::KERNEL], &twins, &FEWER[1..2]);
}

/// Proposals of a kernel in the short form, a tenth of those of the long one: they tell a share of 1e-3 as well.
pub const PROPOSALS: usize = 100_000;

/// As wide as a fifth of the room, and sharp behind the solids.
pub const LENS: Lens = Lens { aperture: 0.4, focus: 2.6 };

pub fn seen_by(change: impl Fn(&mut Camera)) -> Scene {
    let mut scene = scene_of(GLOSSY);
    change(&mut scene.cameras[0]);
    scene
}
