//! A room seen from outside through a wall whose back is culled, while its inside still reflects: the furnace against its
//! closed form, a coloured room against path tracing.

use std::sync::LazyLock;

use emlt::film::Image;
use emlt::kernels::{Kernel, bidirectional, independence, lens};
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::{Direct, Settings};
use emlt::scene::{Features, Material, Scene};
use glam::{Vec3, vec3};

use super::comparison::{Comparison, Power, Truth, check};
use super::furnace;
use super::mitsuba::COLOURED_BOX;
use super::renders::{changed, render, replicates, scene, settings};

/// The scene at `path` by its camera at `eye`, which is outside and sees nothing but the room, through the near wall.
fn from_outside(path: &str, eye: Vec3, target: Vec3, degrees: f32) -> Scene {
    let mut scene = scene(path);
    let camera = scene.cameras[0].looking(eye, target).unwrap();
    scene.cameras[0] = emlt::scene::Camera { vertical_fov: degrees.to_radians(), ..camera };
    assert!(Features::of(&scene).seen_by(&scene, &scene.cameras[0]).culled);
    scene
}

/// The walls emit inside alone, so that the culled one has no light of its own for the camera either.
fn check_furnace(method: Method, samples_per_pixel: u32, power: Power) {
    const EDGES: u32 = 5;
    let scene = from_outside(furnace::SCENE, vec3(0.2, 1.3, 3.5), vec3(-0.1, 0.9, -1.5), 30.0);
    let truth = furnace::radiance(EDGES);
    let settings = Settings { max_depth: EDGES, ..settings(method, [16, 12], samples_per_pixel) };
    let over_truth = |image: &Image| changed(image, |_, _, p| [0, 1, 2].map(|c| (f64::from(p[c]) / truth[c]) as f32));
    let images: Vec<Image> = replicates(&scene, &settings, 12).iter().map(over_truth).collect();
    let truth = Truth { image: changed(&images[0], |_, _, _| [1.0; 3]), variance: None, tile: 4 };
    check(&format!("furnace from outside {}", method.name()), &images, &truth, power);
}

#[test]
fn furnace_from_outside_by_pt() {
    check_furnace(Pt, 256, Power { film: 0.003, tile: 0.006 });
}

#[test]
fn furnace_from_outside_by_mlt() {
    check_furnace(Mlt, 2000, Power { film: 0.02, tile: 0.08 });
}

#[test]
fn furnace_from_outside_by_emlt() {
    check_furnace(Emlt, 3000, Power { film: 0.02, tile: 0.08 });
}

/// The coloured box from outside, and on the back of its near wall the light of a second lamp, beside the view: nobody
/// sees that.
fn cutaway() -> Scene {
    let mut scene = from_outside(COLOURED_BOX, vec3(0.3, 1.2, 3.9), vec3(-0.05, 0.85, 0.0), 32.0);
    let lamp = scene.materials.iter().find(|m| m.emits()).unwrap().clone();
    scene.materials.push(Material { name: "outer lamp".into(), ..lamp });
    let first = scene.positions.len() as u32;
    // Above the camera's view, its front towards the wall.
    scene.positions.extend([vec3(-1.0, 2.5, 2.6), vec3(1.0, 2.5, 2.6), vec3(0.0, 1.9, 3.1)]);
    scene.normals.extend([vec3(0.0, -1.0, -1.2).normalize(); 3]);
    scene.triangles.push([first, first + 1, first + 2]);
    scene.triangle_materials.push(scene.materials.len() as u32 - 1);
    scene
}

const FILM: [u32; 2] = [64, 48];

/// The same by path tracing.
static TRACED: LazyLock<Truth> = LazyLock::new(|| {
    let outcome = render(&cutaway(), &settings(Pt, FILM, 1024));
    let variance = [0, 1, 2].map(|c| &outcome.channels[c].values);
    let pixels = (0..outcome.image.pixels.len()).map(|i| variance.map(|v| v[i])).collect();
    let variance = Image { pixels, ..outcome.image };
    Truth { image: outcome.image, variance: Some(variance), tile: 8 }
});

fn against_path_tracing(method: Method, direct: Direct) {
    let scene = cutaway();
    let settings = Settings { direct, ..settings(method, FILM, 240) };
    let images = replicates(&scene, &settings, 16);
    let name = format!("cutaway {} {direct:?}", method.name());
    check(&name, &images, &TRACED, Power { film: 0.03, tile: 0.3 });
}

#[test]
fn cutaway_by_mlt() {
    against_path_tracing(Mlt, Direct::Mcmc);
}

#[test]
fn cutaway_by_emlt() {
    against_path_tracing(Emlt, Direct::Mcmc);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_cutaway_with_direct_light_apart() {
    against_path_tracing(Emlt, Direct::Pt);
}

/// What shines on the near wall from outside alone is light for nobody, by no strategy; were the wall double-sided, it would be
/// seen by all alike.
#[test]
fn light_on_culled_backs_is_not_seen() {
    let mut scene = cutaway();
    scene.materials.iter_mut().find(|m| m.name == "lamp").unwrap().emission = Vec3::ZERO;
    let image = render(&scene, &settings(Pt, FILM, 64)).image;
    assert!(image.pixels.iter().all(|p| *p == [0.0; 3]));
    let refused = emlt::methods::render(&scene, &settings(Mlt, FILM, 16), &mut emlt::methods::Silent);
    assert!(refused.is_err_and(|e| e.to_string().contains("no light")));

    scene.materials.iter_mut().find(|m| m.name == "green").unwrap().double_sided = true;
    let green = |method, spp| {
        let image = render(&scene, &settings(method, FILM, spp)).image;
        image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / image.pixels.len() as f64
    };
    let [traced, chains] = [green(Pt, 64), green(Mlt, 64)];
    println!("wall from outside: {traced:.5} by pt, {chains:.5} by mlt");
    assert!(traced > 0.01 && (chains / traced - 1.0).abs() < 0.03);
}

/// Bidirectional mutations whose connections from the light to the camera stop at backs that are culled.
#[test]
fn a_twin_that_culls_one_way_is_caught() {
    static BLOCKED: Kernel = Kernel { flags: &["segment", "twin_blocked"], ..bidirectional::KERNEL };
    let scene = cutaway();
    for (twin, kernel) in [("none", &bidirectional::KERNEL), ("blocked", &BLOCKED)] {
        let kernels = Some(vec![(&independence::KERNEL, 0.05), (kernel, 0.5), (&lens::KERNEL, 1.0)]);
        let settings = Settings { kernels, ..settings(Mlt, FILM, 120) };
        let comparison = Comparison::new(&replicates(&scene, &settings, 12), &TRACED);
        println!("{}", comparison.report(&format!("twin: {twin}")));
        assert_eq!(comparison.passes(), twin == "none", "{twin}");
    }
}
