//! Items 14 and 22: a render can be stopped at any time, and when it stops does not depend on what it has seen.

use std::time::Duration;

use emlt::gpu::context::Context;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::{Budget, Direct, Prepared, Session, Settings};
use emlt::scene::LUMINANCE;
use glam::DVec3;

use super::furnaces::{EDGES, box_furnace};

const FILM: [u32; 2] = [16, 12];

fn settings(method: Method, direct: Direct) -> Settings {
    Settings {
        budget: Budget::ENDLESS,
        direct,
        max_depth: EDGES,
        candidates: 1 << 15,
        ..super::renders::settings(method, FILM, 1)
    }
}

/// Stopped after one to many short steps, wherever they end, every render hands over a whole image: no weight is lost, and
/// the mean of the film is b.
#[test]
fn a_render_can_be_stopped_at_any_time() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let scene = box_furnace();
    for (method, direct) in [(Pt, Direct::Mcmc), (Mlt, Direct::Mcmc), (Emlt, Direct::Mcmc)] {
        let settings = settings(method, direct);
        let prepared = Prepared::new(&scene, &settings).unwrap();
        let mut cut = 0;
        for steps in 1..=24 {
            let mut session = Session::start(&context, &prepared, &settings).unwrap();
            while !session.has_image() {
                session.advance(Some(Duration::from_micros(100))).unwrap();
            }
            for _ in 1..steps {
                session.advance(Some(Duration::from_micros(100))).unwrap();
            }
            cut += u32::from(!session.is_whole());
            let name = format!("{} after {steps} steps", method.name());
            let outcome = session.finish().unwrap();
            let pixels = &outcome.image.pixels;
            assert!(pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{name}");
            if let Some(lost) = outcome.statistics.integrity {
                assert!(lost.abs() < 1e-4, "{name}: {lost}");
                let luminance = |p: &[f32; 3]| DVec3::from(p.map(f64::from)).dot(LUMINANCE);
                let mean = pixels.iter().map(luminance).sum::<f64>() / pixels.len() as f64;
                let b = outcome.statistics.b.unwrap().0;
                assert!((mean / b - 1.0).abs() < 1e-4, "{name}: mean {mean}, b {b}");
            }
        }
        // Of path tracing too few pixels are made to be cut.
        assert!(method == Pt || cut > 12, "{}: only {cut} of 24 were under way", method.name());
    }
}

/// A render of so many seconds is, bit for bit, the one of as many mutations as it made: the clock decides on whole
/// half-sweeps, and nothing the chains have seen decides anything.
#[test]
fn a_time_limit_is_a_number_of_mutations() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let scene = box_furnace();
    for method in [Pt, Mlt, Emlt] {
        let endless = settings(method, Direct::Mcmc);
        let timed = Settings { budget: Budget::Seconds(0.2), ..endless.clone() };
        let prepared = Prepared::new(&scene, &endless).unwrap();
        let mut session = Session::start(&context, &prepared, &timed).unwrap();
        while !session.is_done() {
            session.advance(None).unwrap();
        }
        let timed = session.finish().unwrap();
        let mut session = Session::start(&context, &prepared, &endless).unwrap();
        while session.samples() < timed.statistics.samples {
            // Cut otherwise, so that it stops wherever the other did.
            session.advance(Some(Duration::from_millis(1))).unwrap();
        }
        let counted = session.finish().unwrap();
        assert_eq!(counted.statistics.samples, timed.statistics.samples, "{}", method.name());
        assert!(counted.image == timed.image, "{}: the images differ", method.name());
    }
}
