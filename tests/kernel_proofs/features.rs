//! The proofs where there are textures, layers, skies, lights of other kinds and what light goes past: every kernel that can
//! be used there.

use emlt::kernels::{Kernel, guided_caustic, guided_lens, guided_multi_chain};

use crate::bench::{Bench, context};
use crate::everything::{ALL, SHORT, WITHOUT_MIRRORS, check_others, check_perturbations, prove};
use crate::precision::under_a_sky;
use crate::{FEWER, LAYERED, RARE, TEXTURED, check_stationarity_on, crossover, rooms, scene_of};

/// Metal and glass whose alpha goes from 0.035 to 0.25 by a texture, on both sides of what is treated as specular.
#[test]
fn perturbations_on_textured_gloss_are_exact() {
    let (context, name) = (context(), "polished room");
    let mut bench = Bench::of(&context, &rooms::polished_room());
    check_perturbations(&mut bench, name, &ALL, &SHORT);
    let kernels = [&guided_multi_chain::KERNEL, &guided_caustic::KERNEL];
    check_stationarity_on(&mut bench, name, &kernels, &[], &RARE[2..]);
}

/// Where there are textures too.
#[test]
fn kernels_under_lights_of_every_kind_are_exact() {
    let (context, scene, name) = (context(), rooms::glazed_room(), "glazed room");
    let mut bench = Bench::of(&context, &scene);
    check_perturbations(&mut bench, name, &ALL, &SHORT);
    check_others(&mut bench, name, &SHORT);
    let twins = [(&guided_lens::KERNEL, "twin_one_sided", 45_000)];
    check_stationarity_on(&mut bench, name, &[&guided_lens::KERNEL], &twins, &RARE[2..]);
    crossover::check_all(&mut Bench::of(&context, &scene), name, SHORT.exchanges, 0);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_on_textures_leave_the_target_alone() {
    prove(TEXTURED, &scene_of(TEXTURED), &WITHOUT_MIRRORS);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_on_textured_gloss_leave_the_target_alone() {
    let scene = rooms::polished_room();
    prove("polished room", &scene, &ALL);
    let context = context();
    let kernels: [&Kernel; 2] = [&guided_caustic::KERNEL, &guided_multi_chain::KERNEL];
    let twins = kernels.map(|kernel| (kernel, "twin_one_sided", 400_000));
    check_stationarity_on(&mut Bench::of(&context, &scene), "polished room", &[], &twins, &FEWER);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_under_an_even_sky_leave_the_target_alone() {
    prove("even sky", &under_a_sky(false), &ALL);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_under_a_map_of_a_sky_leave_the_target_alone() {
    prove("map of a sky", &under_a_sky(true), &ALL);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_under_lights_of_every_kind_leave_the_target_alone() {
    prove("glazed room", &rooms::glazed_room(), &ALL);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_under_points_leave_the_target_alone() {
    prove("room of points", &rooms::room_of_points(), &ALL);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_past_holes_and_veils_leave_the_target_alone() {
    prove("veiled room", &rooms::veiled_room(), &ALL);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_through_layers_leave_the_target_alone() {
    prove(LAYERED, &scene_of(LAYERED), &ALL);
}

/// Coats as narrow as alpha 0.01, under a block that stands on one.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_kernels_on_narrow_coats_leave_the_target_alone() {
    prove("layered room", &rooms::layered_room(), &ALL);
}
