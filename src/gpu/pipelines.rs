//! Pipelines: built on threads of their own, then each run once on nothing, since drivers may compile at the first
//! dispatch.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::context::Context;
use super::run::{Run, Sizes};
use super::scene::SceneData;
use super::shader::{Sources, Variant};
use crate::{Error, Result};

/// A first dispatch that takes longer has compiled; a shorter one found its code in the driver's cache.
const COMPILED: Duration = Duration::from_millis(250);

/// Pipelines that are built and not yet compiled.
pub type Built = Vec<(Variant, wgpu::ComputePipeline)>;

/// Builds pipelines for a run, and needs nothing of it while it does.
pub struct Builder {
    pub(super) device: wgpu::Device,
    pub(super) sources: Sources,
    pub(super) workgroup: u32,
    /// Bind groups 0 and 1.
    pub(super) layouts: [wgpu::BindGroupLayout; 2],
}

impl Builder {
    /// On threads for half of the processors: the others are at work already.
    pub fn build_all(&self, variants: &[Variant]) -> Result<Built> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get().div_ceil(2));
        let share = variants.len().div_ceil(threads).max(1);
        let build =
            |part: &[Variant]| -> Result<Built> { part.iter().map(|v| Ok((v.clone(), self.build(v)?))).collect() };
        std::thread::scope(|scope| {
            let threads: Vec<_> = variants.chunks(share).map(|part| scope.spawn(move || build(part))).collect();
            let parts = threads.into_iter().map(|thread| thread.join().expect("building a pipeline does not panic"));
            Ok(parts.collect::<Result<Vec<Built>>>()?.concat())
        })
    }

    pub(super) fn build(&self, variant: &Variant) -> Result<wgpu::ComputePipeline> {
        let text = (self.sources.compose_for(variant, self.workgroup))
            .map_err(|e| Error::runtime(format!("a shader does not compose, please report it: {e}")))?;
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(variant.pass),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(variant.pass),
            bind_group_layouts: &[Some(&self.layouts[0]), Some(&self.layouts[1])],
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(variant.pass),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(Error::runtime(format!("the driver refuses a shader, please report it: {error}"))),
            None => Ok(pipeline),
        }
    }
}

/// Pipelines that are to be compiled.
///
/// A software driver compiles them one after another on one core. As soon as it is seen to compile, a second device
/// begins from the other end of the list; what it has compiled, the first one finds in the cache they share.
pub struct Compilation {
    variants: Arc<[Variant]>,
    /// Which of them nobody has taken yet.
    left: Arc<Mutex<Range<usize>>>,
    second: Option<JoinHandle<Vec<usize>>>,
}

impl Compilation {
    pub(super) fn new(variants: Vec<Variant>) -> Self {
        let left = Arc::new(Mutex::new(0..variants.len()));
        Self { variants: variants.into(), left, second: None }
    }

    /// Share of the pipelines that someone has taken, in [0, 1].
    pub fn share(&self) -> f64 {
        let left = self.left.lock().map_or(0, |left| left.len());
        1.0 - left as f64 / self.variants.len().max(1) as f64
    }

    /// Compiles the next pipeline of `run`; whether there may be more.
    pub fn step(&mut self, run: &mut Run) -> Result<bool> {
        if let Some(i) = take(&self.left, Range::next) {
            let start = Instant::now();
            run.once(&self.variants[i])?;
            let compiled = run.context().software && start.elapsed() > COMPILED;
            if compiled && self.second.is_none() && self.share() < 1.0 {
                let open = run.context().another();
                let (variants, left) = (self.variants.clone(), self.left.clone());
                self.second = Some(std::thread::spawn(move || from_the_end(open, &variants, &left)));
            }
            return Ok(true);
        }
        if let Some(second) = self.second.take() {
            // If it failed, these are compiled here after all.
            for i in second.join().expect("compiling does not panic") {
                run.once(&self.variants[i])?;
            }
        }
        Ok(false)
    }
}

fn take(left: &Mutex<Range<usize>>, end: impl Fn(&mut Range<usize>) -> Option<usize>) -> Option<usize> {
    left.lock().ok().and_then(|mut left| end(&mut left))
}

/// Compiles from the end of the list on a device of its own; returns what it took.
fn from_the_end(
    open: impl FnOnce() -> Result<Context>,
    variants: &[Variant],
    left: &Mutex<Range<usize>>,
) -> Vec<usize> {
    let mut taken = Vec::new();
    let Ok(context) = open() else { return taken };
    // All are for one scene.
    let Some(features) = variants.first().map(|variant| variant.features) else { return taken };
    let Ok(mut run) = Run::new(&context, &SceneData::nothing(features), Sizes::default()) else { return taken };
    while let Some(i) = take(left, Range::next_back) {
        taken.push(i);
        if run.once(&variants[i]).is_err() {
            break;
        }
    }
    taken
}
