//! The size of workgroups is the device's affair: no image shows it, bit for bit.

use emlt::gpu::context::Context;
use emlt::kernels::{self, Family, Kernel};
use emlt::methods::{Method, Settings, Silent, render_on};

use super::renders::{render, scene, settings};
use super::repetition::bits;

/// Beside the usual 64. All are multiples of 8, the lanes of a processor's vectors: in a vector that its workgroup does not
/// fill, Mesa's software driver (22.3) computes whole evaluations of a path otherwise, in the lanes that are in use.
const THREADS: [u32; 3] = [32, 48, 128];

/// Every kernel there is: 3 of 20 mutations structural ones of each kind, and 2 crossovers.
fn every_kernel() -> Vec<(&'static Kernel, f64)> {
    kernels::ALL.map(|kernel| (kernel, if kernel.family == Family::Pair { 0.1 } else { 0.05 })).to_vec()
}

#[test]
fn no_image_shows_the_size_of_workgroups() {
    let scene = scene("tests/scenes/coloured_box.glb");
    let of = |method| settings(method, [33, 25], 40);
    let options = [Settings { kernels: Some(every_kernel()), ..of(Method::Emlt) }, of(Method::Mlt), of(Method::Pt)];
    let usual = options.each_ref().map(|options| render(&scene, options));
    for kernel in &usual[0].statistics.kernels {
        assert!(kernel.mutations > 0, "{} has not run", kernel.name);
    }
    assert_eq!(usual[0].statistics.kernels.len(), kernels::ALL.len());
    for threads in THREADS {
        let device = Context::open(None).unwrap_or_else(|e| panic!("{e}")).with_workgroups_of(threads);
        for (options, usual) in options.iter().zip(&usual) {
            let outcome = render_on(&device, &scene, options, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
            let differ = bits(&outcome).iter().zip(bits(usual)).filter(|(a, b)| **a != *b).count();
            assert_eq!(differ, 0, "{} in workgroups of {threads}: {differ} values differ", options.method.name());
        }
    }
}
