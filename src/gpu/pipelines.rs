//! Pipelines: built on threads of their own, then each run once on nothing, since drivers may compile at the first
//! dispatch.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::context::Context;
use super::layout::PassUniform;
use super::run::{Dispatch, Run, Sizes};
use super::scene::SceneData;
use super::shader::{Variant, compose};
use crate::{Error, Result};

/// A first dispatch that takes longer has compiled; a shorter one found its code in the driver's cache.
const COMPILED: Duration = Duration::from_millis(250);

/// Builds pipelines for a run, and needs nothing of it while it does.
pub struct Builder {
    pub(super) device: wgpu::Device,
    /// Bind groups 0 and 1.
    pub(super) layouts: [wgpu::BindGroupLayout; 2],
}

impl Builder {
    /// All at once, each on its own thread.
    pub fn build_all(&self, variants: &[Variant]) -> Result<Vec<(Variant, wgpu::ComputePipeline)>> {
        std::thread::scope(|scope| {
            let threads: Vec<_> =
                variants.iter().map(|v| scope.spawn(move || Ok((v.clone(), self.build(v)?)))).collect();
            threads.into_iter().map(|thread| thread.join().expect("building a pipeline does not panic")).collect()
        })
    }

    pub(super) fn build(&self, variant: &Variant) -> Result<wgpu::ComputePipeline> {
        let text = compose(variant)
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

/// Runs pipelines of `run` once on nothing.
///
/// A software driver compiles them one after another on one core. As soon as it is seen to compile, a second device
/// begins from the other end of the list; what it has compiled, the first one finds in the cache they share.
pub fn warm_up(run: &mut Run, variants: &[Variant]) -> Result<()> {
    let left = Mutex::new(0..variants.len());
    let left = &left;
    let context = run.context();
    std::thread::scope(|scope| {
        let mut second = None;
        while let Some(i) = take(left, Range::next) {
            let start = Instant::now();
            once(run, &variants[i])?;
            if second.is_none() && context.software && start.elapsed() > COMPILED {
                second = Some(scope.spawn(move || from_the_end(context, left, variants)));
            }
        }
        if let Some(second) = second {
            // If it failed, these are compiled here after all.
            for i in second.join().expect("compiling does not panic") {
                once(run, &variants[i])?;
            }
        }
        Ok(())
    })
}

type Range = std::ops::Range<usize>;

fn take(left: &Mutex<Range>, end: impl Fn(&mut Range) -> Option<usize>) -> Option<usize> {
    end(&mut left.lock().expect("nothing panics with it"))
}

fn once(run: &mut Run, variant: &Variant) -> Result<()> {
    run.submit(&[Dispatch { variant: variant.clone(), uniform: PassUniform::default() }])?;
    run.wait()
}

/// Compiles from the end of the list on a device of its own; returns what it took.
fn from_the_end(context: &Context, left: &Mutex<Range>, variants: &[Variant]) -> Vec<usize> {
    let mut taken = Vec::new();
    let Ok(context) = context.another() else { return taken };
    let Ok(mut run) = Run::new(&context, &SceneData::nothing(), Sizes::default()) else { return taken };
    while let Some(i) = take(left, Range::next_back) {
        taken.push(i);
        if once(&mut run, &variants[i]).is_err() {
            break;
        }
    }
    taken
}
