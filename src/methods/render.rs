//! A render from its scene to its end, with somebody who watches it.

use std::time::Instant;

use super::{Method, Observer, Outcome, Prepared, Session, Settings, Stage};
use crate::gpu::context::Context;
use crate::report::summary::percent;
use crate::scene::Scene;

/// Renders `scene` as `settings` say, on a device that it opens.
pub fn render(scene: &Scene, settings: &Settings, observer: &mut dyn Observer) -> crate::Result<Outcome> {
    observer.stage("setting up");
    let start = Instant::now();
    let context = Context::open(settings.device.as_deref())?;
    render_since(start, &context, scene, settings, observer)
}

/// The same on an open device, which remembers its pipelines from render to render.
pub fn render_on(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> crate::Result<Outcome> {
    render_since(Instant::now(), context, scene, settings, observer)
}

/// The same where set-up counts from `start` on.
pub(crate) fn render_since(
    start: Instant,
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> crate::Result<Outcome> {
    let prepared = Prepared::new(scene, settings)?;
    let mut session = Session::start(context, &prepared, settings)?;
    drop(prepared);
    let setup_s = start.elapsed().as_secs_f64();
    let watched = settings.target_error.is_some() || observer.looks();
    let mut looks = Looks::new(u64::from(settings.width) * u64::from(settings.height));
    let mut goal = Goal { target: settings.target_error, ..Goal::default() };
    let mut stage = None;
    let mut interrupted = false;
    while !session.is_done() && !goal.reached && !interrupted {
        if stage.replace(session.stage()) != Some(session.stage()) {
            observer.stage(session.stage().name());
        }
        session.advance(None)?;
        if watched && session.has_image() && session.is_whole() && looks.is_due(session.samples()) {
            let mut outcome = session.snapshot()?;
            outcome.statistics.setup_s = setup_s;
            observer.look(&outcome)?;
            goal.look(session.samples(), &outcome);
        }
        let rendering = session.stage() == Stage::Rendering;
        observer.progress(session.share().max(if rendering { goal.share(session.samples()) } else { 0.0 }));
        interrupted = session.has_image() && observer.stop_requested();
    }
    let mut outcome = session.finish()?;
    outcome.statistics.setup_s = setup_s;
    outcome.statistics.interrupted = interrupted;
    if observer.looks() {
        observer.look(&outcome)?;
    }
    let note = goal.missed(outcome.statistics.error.map(|error| error.pixels), settings.method);
    outcome.statistics.notes.extend(note);
    Ok(outcome)
}

/// When to look at the image: at counts fixed in advance, so that nothing the render has seen decides it (METHOD.md
/// section 6, item 22).
struct Looks {
    pixels: f64,
    next: u32,
}

impl Looks {
    fn new(pixels: u64) -> Self {
        Self { pixels: pixels as f64, next: 0 }
    }

    /// Samples at look number `number`: one a pixel, then 2^(1/2) times as many as before.
    fn count(&self, number: u32) -> f64 {
        self.pixels * 2f64.powf(0.5 * f64::from(number))
    }

    /// Whether the next look has come with so many samples; the ones that these have passed as well are left out.
    fn is_due(&mut self, samples: u64) -> bool {
        let due = samples as f64 >= self.count(self.next);
        while samples as f64 >= self.count(self.next) {
            self.next += 1;
        }
        due
    }
}

/// The error that the render is to come below.
#[derive(Default)]
struct Goal {
    target: Option<f64>,
    reached: bool,
    /// Samples and error at the last look.
    last: Option<(u64, f64)>,
}

impl Goal {
    fn look(&mut self, samples: u64, outcome: &Outcome) {
        if let (Some(target), Some(error)) = (self.target, outcome.statistics.error) {
            self.last = Some((samples, error.pixels));
            self.reached = error.pixels <= target;
        }
    }

    /// Done share of the way, as errors fall with the root of the number of samples.
    fn share(&self, samples: u64) -> f64 {
        match (self.target, self.last) {
            (Some(target), Some((at, error))) if error > 0.0 => {
                (samples as f64 / at.max(1) as f64 * (target / error).powi(2)).min(1.0)
            }
            _ => 0.0,
        }
    }

    /// What to say where the render ended before, with so much error.
    fn missed(&self, error: Option<f64>, method: Method) -> Option<String> {
        let target = self.target.filter(|target| error.is_none_or(|error| error > *target))?;
        let error = error.map_or("not known".into(), percent);
        let more = if method == Method::Pt { "samples" } else { "mutations" };
        Some(format!("the target error of {} was not reached: it is {error}, and takes more {more}", percent(target)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_come_at_counts_that_grow_by_half_a_power() {
        let mut looks = Looks::new(100);
        let due: Vec<u64> = (1..=1000).filter(|samples| looks.is_due(*samples)).collect();
        assert_eq!(due, [100, 142, 200, 283, 400, 566, 800]);
        // Steps that pass several make one look of them.
        let mut looks = Looks::new(100);
        assert!(looks.is_due(250) && !looks.is_due(282) && looks.is_due(5000) && !looks.is_due(5001));
    }

    #[test]
    fn the_share_of_the_way_follows_the_root() {
        let goal = Goal { target: Some(0.1), reached: false, last: Some((1000, 0.2)) };
        assert_eq!((goal.share(1000), goal.share(4000), goal.share(9000)), (0.25, 1.0, 1.0));
        assert!(goal.missed(Some(0.2), Method::Emlt).unwrap().contains("it is 20.0 %"));
        assert!(goal.missed(None, Method::Pt).unwrap().contains("not known"));
        assert_eq!(goal.missed(Some(0.1), Method::Emlt), None);
        assert_eq!(Goal::default().missed(Some(0.2), Method::Emlt), None);
    }
}
