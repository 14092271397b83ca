//! Kernels where the camera's own edge passes backs that are culled: the glossy room from outside, through its near wall.

use emlt::kernels::bidirectional;
use emlt::scene::{Camera, Scene};
use glam::vec3;

use crate::bench::{Bench, context};
use crate::cameras::{LENS, PROPOSALS, seen_by};
use crate::everything::{ALL, prove};
use crate::{FEWER, PERTURBATIONS, RARE, check_factors, check_stationarity_on, check_symmetry, structural};

fn from_outside(change: impl Fn(&mut Camera)) -> Scene {
    let scene = seen_by(|camera| {
        let outside = camera.looking(vec3(0.3, 1.2, 3.9), vec3(-0.05, 0.85, 0.0)).unwrap();
        *camera = Camera { vertical_fov: 32f32.to_radians(), ..outside };
        change(camera);
    });
    assert!(scene.has_culled_back(&scene.cameras[0]));
    scene
}

/// The twin's connections from the light to the camera stop at the wall.
#[test]
fn kernels_through_a_culled_wall_are_exact() {
    let context = context();
    let mut bench = Bench::of(&context, &from_outside(|_| ()));
    assert!(bench.features.culled);
    let (_, perturbations) = PERTURBATIONS[2];
    check_symmetry(&mut bench, "culled wall", perturbations, PROPOSALS);
    check_factors(&mut Bench::of(&context, &from_outside(|_| ())));
    structural::check_symmetry(&mut bench, "culled wall", &[&bidirectional::KERNEL], PROPOSALS);
    let (at_the_camera, through_lobes) = perturbations.split_at(2);
    check_stationarity_on(&mut bench, "culled wall", at_the_camera, &[], &FEWER[2..]);
    check_stationarity_on(&mut bench, "culled wall", through_lobes, &[], &RARE[2..]);
    let twins = [(&bidirectional::KERNEL, "twin_blocked", 250_000)];
    check_stationarity_on(&mut bench, "culled wall", &[&bidirectional::KERNEL], &twins, &FEWER[1..2]);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_through_a_culled_wall_leave_the_target_alone() {
    prove("culled wall", &from_outside(|_| ()), &ALL);
    prove("culled wall, lens", &from_outside(|camera| camera.lens = Some(LENS)), &ALL);
    let orthographic = from_outside(|camera| camera.orthographic_height = Some(1.6));
    prove("culled wall, orthographic", &orthographic, &ALL);
}
