//! The proofs where there are textures, layers, skies, lights of other kinds and what light goes past: every kernel that can
//! be used there.

use emlt::kernels::{Kernel, guided_bidirectional, guided_caustic, guided_lens, guided_multi_chain};
use emlt::scene::Scene;

use crate::bench::{Bench, context};
use crate::everything::{ALL, SHORT, WITHOUT_MIRRORS, check_ratios, prove};
use crate::precision::under_a_sky;
use crate::{LAYERED, ROUNDS, STRUCTURAL, TEXTURED, check_stationarity_on, crossover, rooms, scene_of};

/// The short form: ratios of every kernel, stationarity of the guided ones, and a twin.
fn check(name: &str, scene: &Scene) {
    let context = context();
    let mut bench = Bench::of(&context, scene);
    check_ratios(&mut bench, name, &ALL, &SHORT);
    let kernels = [&guided_lens::KERNEL, &guided_multi_chain::KERNEL, &guided_caustic::KERNEL];
    check_stationarity_on(&mut bench, name, &kernels, &[], &[16], 2);
    let twins = [(&guided_bidirectional::KERNEL, "twin_places", 2)];
    check_stationarity_on(&mut bench, name, &STRUCTURAL[1..], &twins, &[4], 2);
    crossover::check_all(&mut Bench::of(&context, scene), name, SHORT.exchanges, 0);
}

/// Metal and glass whose alpha goes from 0.035 to 0.25 by a texture, on both sides of what is treated as specular.
#[test]
fn kernels_on_textured_gloss_are_exact() {
    check("polished room", &rooms::polished_room());
}

#[test]
fn kernels_under_lights_of_every_kind_are_exact() {
    check("glazed room", &rooms::glazed_room());
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
    let twins = kernels.map(|kernel| (kernel, "twin_one_sided", ROUNDS));
    check_stationarity_on(&mut Bench::of(&context, &scene), "polished room", &[], &twins, &[], 0);
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
    prove("layered room", &rooms::layered_room(), &ALL);
}
