//! Item 11: what is not finite is rejected, counted and told, and never reaches the film.

use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::{Outcome, Settings};
use emlt::scene::Scene;
use glam::{Vec3, vec3};

use super::furnaces::{EDGES, box_furnace};
use super::renders::{render_unchecked, settings};
use super::shapes::{cuboid, matt};

const FILM: [u32; 2] = [16, 12];

/// The furnace with a block in it whose red albedo is not a number, which no file can have. Or, for comparison, black.
fn poisoned(nan: bool) -> Scene {
    let mut scene = box_furnace();
    scene.materials.push(matt(if nan { vec3(f32::NAN, 0.5, 0.5) } else { Vec3::ZERO }, Vec3::ZERO));
    cuboid(&mut scene, vec3(-0.5, 0.4, -0.9), vec3(0.1, 1.0, -0.3), false, 1);
    scene
}

fn outcome(scene: &Scene, method: emlt::methods::Method) -> Outcome {
    let settings = Settings { max_depth: EDGES, candidates: 1 << 16, ..settings(method, FILM, 2000) };
    render_unchecked(scene, &settings)
}

#[test]
fn what_is_no_number_is_counted() {
    for method in [Pt, Mlt, Emlt] {
        let Outcome { image, channels, uncertainty, statistics } = outcome(&poisoned(true), method);
        let name = method.name();
        let black = outcome(&poisoned(false), method).image;
        // The film, its layers and its error are finite.
        assert!(image.pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{name}");
        assert!(channels.iter().flat_map(|c| &c.values).all(|v| v.is_finite()), "{name}");
        let uncertainty = uncertainty.unwrap();
        assert!(uncertainty.relative.is_finite(), "{name}");
        assert!(uncertainty.pixels.pixels.iter().flatten().all(|v| v.is_finite()), "{name}");
        // Nothing is lost: rejections are samples.
        assert!(statistics.integrity.unwrap_or(0.0).abs() < 1e-4, "{name}: {:?}", statistics.integrity);
        assert!(statistics.b.is_none_or(|(b, error)| b.is_finite() && error.is_finite()), "{name}: {:?}", statistics.b);
        // It is told.
        assert!(statistics.notes.iter().any(|note| note.contains("not finite")), "{name}: {:?}", statistics.notes);
        for kernel in &statistics.kernels {
            println!("{name}: {} of {} proposals by {} not finite", kernel.non_finite, kernel.mutations, kernel.name);
        }
        let counted = statistics.kernels.iter().filter(|k| k.non_finite > 0).count();
        assert!(statistics.kernels.len() - counted <= 1, "{name}: {:?}", statistics.kernels);
        // Paths by way of the block count as black, for chains path by path; path tracing loses all of a sample.
        let mean = |image: &emlt::film::Image| {
            image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / image.pixels.len() as f64
        };
        let ratio = mean(&image) / mean(&black);
        println!("{name}: {ratio:.4} of the light of a black block");
        assert!(
            if method == Pt { (0.5..1.01).contains(&ratio) } else { (0.97..1.03).contains(&ratio) },
            "{name}: {ratio}"
        );
    }
}
