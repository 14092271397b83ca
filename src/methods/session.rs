//! A render in steps: what can be asked between them, and what every method answers.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::chains::Chains;
use super::direct::Both;
use super::pt::PathTracer;
use super::{Direct, Method, Outcome, Settings};
use crate::film::uncertainty::Y;
use crate::gpu::context::Context;
use crate::gpu::scene::{GpuScene, SceneData};
use crate::report::statistics::{ErrorStatistics, Statistics};
use crate::scene::{Camera, Features, Scene};

/// What a render is busy with, in this order; but chains compile twice, for their start and for their kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The driver compiles shaders.
    Compiling,
    /// The start paths and b are made.
    Seeding,
    Rendering,
}

impl Stage {
    /// In words, for progress.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compiling => "compiling shaders",
            Self::Seeding => "seeding",
            Self::Rendering => "rendering",
        }
    }
}

/// What renders an image, or a part of its light, step by step.
pub(super) trait Part {
    fn stage(&self) -> Stage;
    /// Done share of the stage; of rendering, what is spent of the budget over all of it, from 1 on when it is spent.
    fn share(&self) -> f64;
    fn has_image(&self) -> bool;
    fn is_whole(&self) -> bool;
    fn samples(&self) -> u64;
    fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()>;
    /// Without what is known outside: device and set-up.
    fn statistics(&self) -> Statistics;
    /// Without the uncertainty, and the acceptance by pixel, unless `with_error` is set.
    fn snapshot(&mut self, with_error: bool) -> crate::Result<Outcome>;
}

/// A scene made ready for the device: sorted into its search tree, and its materials classed as a method wants them.
/// Cameras and films can change without making it again.
#[derive(Debug, Clone)]
pub struct Prepared {
    features: Features,
    data: SceneData,
}

impl Prepared {
    /// Prepares `scene` for the method, camera and film of `settings`.
    pub fn new(scene: &Scene, settings: &Settings) -> crate::Result<Self> {
        let camera = &scene.camera(settings.camera.as_deref())?.through(settings.lens)?;
        let threshold = settings.specular_threshold();
        let data = SceneData::with_threshold(scene, camera, settings.width, settings.height, threshold)?;
        Ok(Self { features: Features::with_threshold(scene, threshold).seen_by(scene, camera), data })
    }

    /// Lets `camera` see `scene`, which it was made from, on a film of the size in pixels.
    pub fn aim(&mut self, scene: &Scene, camera: &Camera, width: u32, height: u32) {
        self.data.aim(camera, width, height);
        self.features = self.features.seen_by(scene, camera);
    }

    /// What is compiled into the shaders.
    pub fn features(&self) -> Features {
        self.features
    }
}

/// A render under way: it goes on by [`Self::advance`] alone, and may be looked at between steps.
///
/// However its steps are cut, the same settings give the same image, bit for bit, once so many samples are made.
pub struct Session<'a> {
    part: Box<dyn Part + 'a>,
    /// Of the device, and what the set-up took.
    base: Statistics,
}

impl<'a> Session<'a> {
    /// Uploads the scene and allocates; nothing is compiled or rendered yet. The camera is the one that `prepared` was
    /// aimed with, and the film must have the size of `settings`.
    ///
    /// An [`crate::Error::Input`] says what is too large for the device.
    pub fn start(context: &'a Context, prepared: &Prepared, settings: &Settings) -> crate::Result<Self> {
        let start = Instant::now();
        let Prepared { features, data } = prepared;
        assert_eq!(
            [data.uniform.film_width, data.uniform.film_height],
            [settings.width as f32, settings.height as f32],
            "the film's size"
        );
        let scene = Arc::new(GpuScene::new(context, data)?);
        let part: Box<dyn Part + 'a> = match (settings.method, settings.direct) {
            (Method::Pt, _) => Box::new(PathTracer::new(context, scene, *features, settings, None)?),
            (Method::Mlt | Method::Emlt, Direct::Mcmc) => Box::new(Chains::new(context, scene, *features, settings)?),
            (Method::Mlt | Method::Emlt, Direct::Pt | Direct::Auto) => {
                Box::new(Both::new(context, scene, *features, settings)?)
            }
        };
        let base = Statistics {
            device: context.description.clone(),
            software_device: context.software,
            setup_s: start.elapsed().as_secs_f64(),
            ..Statistics::default()
        };
        Ok(Self { part, base })
    }

    /// What the next step works at.
    pub fn stage(&self) -> Stage {
        self.part.stage()
    }

    /// Done share of the stage in [0, 1].
    pub fn share(&self) -> f64 {
        self.part.share().min(1.0)
    }

    /// Whether the budget is spent; going on is allowed.
    pub fn is_done(&self) -> bool {
        self.has_image() && self.part.share() >= 1.0
    }

    /// Whether there is an image: every pixel has had its chance.
    pub fn has_image(&self) -> bool {
        self.part.stage() == Stage::Rendering && self.part.has_image()
    }

    /// Whether [`Self::snapshot`] is an estimate of the whole image just now. Steps end at such a point often, but not
    /// always: a half-sweep or a pass over the film may be under way.
    pub fn is_whole(&self) -> bool {
        self.part.is_whole()
    }

    /// Mutations (mlt, emlt) or samples (pt) so far.
    pub fn samples(&self) -> u64 {
        self.part.samples()
    }

    /// The next step: some shaders, a batch of start candidates, a part of a half-sweep, a pass over the film. With a
    /// `limit`, steps of rendering are cut so as to take about as long, and are waited for.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where no light reaches the camera, [`crate::Error::Runtime`] where the device fails. The
    /// session is of no use then.
    pub fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        self.part.advance(limit)
    }

    /// The figures so far.
    pub fn statistics(&self) -> Statistics {
        self.with_base(self.part.statistics())
    }

    /// The image so far, with the layers that were asked for and the figures; best where [`Self::is_whole`].
    pub fn snapshot(&mut self) -> crate::Result<Outcome> {
        self.outcome(true)
    }

    /// The same without the image's own error and the acceptance by pixel, in a fraction of the time: for those who look
    /// many times a second.
    pub fn glance(&mut self) -> crate::Result<Outcome> {
        self.outcome(false)
    }

    fn outcome(&mut self, with_error: bool) -> crate::Result<Outcome> {
        let outcome = self.part.snapshot(with_error)?;
        let mut statistics = self.with_base(outcome.statistics);
        // A black image has not found its light yet, and knows nothing of its error.
        let seen = outcome.uncertainty.as_ref().filter(|uncertainty| uncertainty.film[Y].mean > 0.0);
        statistics.error = seen.map(ErrorStatistics::new);
        Ok(Outcome { statistics, ..outcome })
    }

    /// Ends the render: goes on until the image is whole, and hands it over.
    pub fn finish(mut self) -> crate::Result<Outcome> {
        while !self.is_whole() {
            self.advance(None)?;
        }
        self.snapshot()
    }

    fn with_base(&self, part: Statistics) -> Statistics {
        let Statistics { device, software_device, setup_s, .. } = self.base.clone();
        Statistics { device, software_device, setup_s, ..part }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Budget;
    use crate::scene::import::import;

    /// However the steps are cut, and although both sessions share a device, the image is the same.
    #[test]
    fn cut_steps_give_the_same_image() {
        let scene = import(std::path::Path::new("scenes/cornell.glb")).unwrap();
        let context = Context::open(None).unwrap();
        for (method, direct, spp) in
            [(Method::Pt, Direct::Mcmc, 3), (Method::Emlt, Direct::Pt, 20), (Method::Emlt, Direct::Auto, 20)]
        {
            let budget = Budget::SamplesPerPixel(spp);
            // Some batches of candidates are as good as many.
            let candidates = 1 << 17;
            let settings =
                Settings { method, direct, width: 96, height: 72, budget, candidates, ..Settings::default() };
            let prepared = Prepared::new(&scene, &settings).unwrap();
            let limits = [None, Some(Duration::from_micros(300))];
            let [whole, cut] = limits.map(|limit| {
                let mut session = Session::start(&context, &prepared, &settings).unwrap();
                let mut steps = 0;
                while !session.is_done() {
                    session.advance(limit).unwrap();
                    steps += 1;
                }
                (steps, session.finish().unwrap())
            });
            assert!(cut.0 > whole.0, "{} and {} steps", cut.0, whole.0);
            assert_eq!(cut.1.statistics.samples, whole.1.statistics.samples);
            assert!(cut.1.image == whole.1.image, "{method:?}: the images differ");
        }
    }
}
