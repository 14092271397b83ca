//! A run on the device: its buffers behind bind group 1, its pipelines, and recorded dispatches.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::context::Context;
use super::layout::{PassUniform, STRATEGY_ENTRIES, WEIGHT_ENTRIES};
use super::scene::{GpuScene, SceneData};
use super::shader::{Variant, compose};
use crate::{Error, Result};

/// Threads a workgroup, as in every pass.
const WORKGROUP: u32 = 64;
/// Passes that one submission can hold.
pub const PASS_SLOTS: usize = 256;
/// Uniform offsets are multiples of this on every device.
const PASS_STRIDE: usize = 256;

/// Bytes of each buffer that a run needs.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    pub chains: u64,
    pub lists: u64,
    pub output: u64,
    pub counters: u64,
}

/// Which buffer to read back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Buffer {
    Chains,
    Output,
    Counters,
}

/// One dispatch: a pipeline, its uniform, one invocation per entry.
#[derive(Debug, Clone)]
pub struct Dispatch {
    pub variant: Variant,
    pub uniform: PassUniform,
}

/// Buffers, pipelines and clock of one run. GPU work is recorded as [`Dispatch`]es and submitted in order.
pub struct Run<'a> {
    context: &'a Context,
    scene: Arc<GpuScene>,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    strategies: wgpu::Buffer,
    chains: wgpu::Buffer,
    lists: wgpu::Buffer,
    output: wgpu::Buffer,
    counters: wgpu::Buffer,
    staging: Option<wgpu::Buffer>,
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
    /// Time spent in handing work to the device and waiting for it; software drivers work in either.
    pub device_time: Duration,
}

impl<'a> Run<'a> {
    /// Uploads the scene and allocates zeroed buffers.
    pub fn new(context: &'a Context, scene: &SceneData, sizes: Sizes) -> Result<Self> {
        Self::over(context, Arc::new(GpuScene::new(context, scene)?), sizes)
    }

    /// Allocates zeroed buffers for a run over a scene that is on the device already.
    pub fn over(context: &'a Context, scene: Arc<GpuScene>, sizes: Sizes) -> Result<Self> {
        let device = &context.device;
        let limit = device.limits().max_storage_buffer_binding_size;
        let storage = |label: &str, bytes: u64, advice: &str| {
            if bytes > limit {
                return Err(Error::input(format!(
                    "the {label} would take {} MiB and this device binds at most {} MiB: choose {advice}",
                    bytes >> 20,
                    limit >> 20
                )));
            }
            Ok(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.max(16).next_multiple_of(16),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }))
        };
        let uniform = |label: &str, bytes: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let chains = storage("paths", sizes.chains, "a smaller --ensemble or --max-depth")?;
        let lists = storage("lists", sizes.lists, "a smaller --ensemble")?;
        let output = storage("film", sizes.output, "a smaller --size")?;
        let counters = storage("counters", sizes.counters, "fewer kernels")?;
        let uniforms = uniform("passes", PASS_SLOTS * PASS_STRIDE);
        let strategies = uniform("strategies", 4 * (STRATEGY_ENTRIES + WEIGHT_ENTRIES));
        let read_write = wgpu::BufferBindingType::Storage { read_only: false };
        let layout = super::buffer_layout(
            device,
            "run",
            &[
                wgpu::BufferBindingType::Uniform,
                read_write,
                wgpu::BufferBindingType::Storage { read_only: true },
                read_write,
                read_write,
                wgpu::BufferBindingType::Uniform,
            ],
            Some(0),
        );
        let group = super::buffer_group(
            device,
            &layout,
            &[&uniforms, &chains, &lists, &output, &counters, &strategies],
            Some((0, size_of::<PassUniform>() as u64)),
        );
        Ok(Self {
            context,
            scene,
            layout,
            group,
            uniforms,
            strategies,
            chains,
            lists,
            output,
            counters,
            staging: None,
            pipelines: HashMap::new(),
            device_time: Duration::ZERO,
        })
    }

    /// Sets log P(edges, light-side vertices), row-major.
    pub fn set_strategies(&self, log_probability: &[f32; STRATEGY_ENTRIES]) {
        self.context.queue.write_buffer(&self.strategies, 0, bytemuck::cast_slice(log_probability));
    }

    /// Sets w of the two-stage target, by tiles of the film.
    pub fn set_pixel_weights(&self, weights: &[f32; WEIGHT_ENTRIES]) {
        let offset = 4 * STRATEGY_ENTRIES as u64;
        self.context.queue.write_buffer(&self.strategies, offset, bytemuck::cast_slice(weights));
    }

    /// Replaces the beginning of the lists.
    pub fn set_lists(&self, words: &[u32]) {
        self.context.queue.write_buffer(&self.lists, 0, bytemuck::cast_slice(words));
    }

    /// Replaces bytes of the chains.
    pub fn set_chains(&self, offset: u64, bytes: &[u8]) {
        self.context.queue.write_buffer(&self.chains, offset, bytes);
    }

    /// Builds the pipelines, all at once, and runs each once on nothing: drivers compile at the first dispatch.
    pub fn compile(&mut self, variants: &[Variant]) -> Result<()> {
        self.build_all(variants)?;
        variants.iter().try_for_each(|variant| self.warm(variant))
    }

    /// Builds the pipelines, all at once; those that the device has had before are there already.
    pub fn build_all(&mut self, variants: &[Variant]) -> Result<()> {
        for (variant, pipeline) in self.context.pipelines().iter().filter(|(variant, _)| variants.contains(variant)) {
            self.pipelines.insert(variant.clone(), pipeline.clone());
        }
        let missing: Vec<&Variant> = variants.iter().filter(|v| !self.pipelines.contains_key(v)).collect();
        let this = &*self;
        let built: Vec<Result<wgpu::ComputePipeline>> = std::thread::scope(|scope| {
            let threads: Vec<_> = missing.iter().map(|v| scope.spawn(move || this.build(v))).collect();
            threads.into_iter().map(|thread| thread.join().expect("building a pipeline does not panic")).collect()
        });
        for (variant, pipeline) in missing.into_iter().zip(built) {
            self.pipelines.insert(variant.clone(), pipeline?);
        }
        Ok(())
    }

    /// Runs a pipeline once on nothing and waits, unless that was done on this device before.
    pub fn warm(&mut self, variant: &Variant) -> Result<()> {
        if self.context.pipelines().contains_key(variant) {
            return Ok(());
        }
        self.submit(&[Dispatch { variant: variant.clone(), uniform: PassUniform::default() }])?;
        self.wait()?;
        self.context.pipelines().insert(variant.clone(), self.pipelines[variant].clone());
        Ok(())
    }

    fn build(&self, variant: &Variant) -> Result<wgpu::ComputePipeline> {
        let device = &self.context.device;
        let text = compose(variant)
            .map_err(|e| Error::runtime(format!("a shader does not compose, please report it: {e}")))?;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(variant.pass),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(variant.pass),
            bind_group_layouts: &[Some(&self.scene.layout), Some(&self.layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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

    /// Records and submits dispatches in order, at most 256 of them.
    pub fn submit(&mut self, dispatches: &[Dispatch]) -> Result<()> {
        assert!(dispatches.len() <= PASS_SLOTS, "{} passes in one submission", dispatches.len());
        let mut bytes = vec![0u8; dispatches.len() * PASS_STRIDE];
        for (slot, dispatch) in bytes.chunks_exact_mut(PASS_STRIDE).zip(dispatches) {
            if !self.pipelines.contains_key(&dispatch.variant) {
                self.pipelines.insert(dispatch.variant.clone(), self.build(&dispatch.variant)?);
            }
            slot[..size_of::<PassUniform>()].copy_from_slice(bytemuck::bytes_of(&dispatch.uniform));
        }
        self.context.queue.write_buffer(&self.uniforms, 0, &bytes);
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_bind_group(0, &self.scene.group, &[]);
            for (i, dispatch) in dispatches.iter().enumerate() {
                let groups = dispatch.uniform.entries.div_ceil(WORKGROUP).max(1);
                // Two dimensions where one is too short; passes that expect this compute their index from both.
                let rows = groups.div_ceil(65535);
                pass.set_pipeline(&self.pipelines[&dispatch.variant]);
                pass.set_bind_group(1, &self.group, &[(i * PASS_STRIDE) as u32]);
                pass.dispatch_workgroups(groups.div_ceil(rows), rows, 1);
            }
        }
        self.hand_over(encoder);
        Ok(())
    }

    fn hand_over(&mut self, encoder: wgpu::CommandEncoder) {
        let commands = encoder.finish();
        let start = Instant::now();
        self.context.queue.submit([commands]);
        self.device_time += start.elapsed();
    }

    /// Waits until all submitted work is done.
    pub fn wait(&mut self) -> Result<()> {
        let start = Instant::now();
        let result = self.context.device.poll(wgpu::PollType::wait_indefinitely());
        self.device_time += start.elapsed();
        result.map(|_| ()).map_err(|e| Error::runtime(format!("the device stopped answering: {e}")))
    }

    /// Zeroes a buffer.
    pub fn clear(&mut self, buffer: Buffer) {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(self.buffer(buffer), 0, None);
        self.hand_over(encoder);
    }

    fn buffer(&self, buffer: Buffer) -> &wgpu::Buffer {
        match buffer {
            Buffer::Chains => &self.chains,
            Buffer::Output => &self.output,
            Buffer::Counters => &self.counters,
        }
    }

    /// Waits for all work, then copies a byte range of a buffer.
    pub fn read(&mut self, buffer: Buffer, range: Range<u64>) -> Result<Vec<u8>> {
        self.read_ranges(buffer, std::slice::from_ref(&range))
    }

    /// Waits for all work, then copies byte ranges of a buffer, one after another.
    pub fn read_ranges(&mut self, buffer: Buffer, ranges: &[Range<u64>]) -> Result<Vec<u8>> {
        let total: u64 = ranges.iter().map(|r| r.end - r.start).sum();
        let device = &self.context.device;
        if self.staging.as_ref().is_none_or(|s| s.size() < total) {
            self.staging = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("staging"),
                size: total.next_power_of_two().max(4096),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let staging = self.staging.take().expect("just made");
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut at = 0;
        for range in ranges {
            let size = range.end - range.start;
            encoder.copy_buffer_to_buffer(self.buffer(buffer), range.start, &staging, at, size);
            at += size;
        }
        self.hand_over(encoder);
        let slice = staging.slice(..total);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        self.wait()?;
        let bytes = slice
            .get_mapped_range()
            .map_err(|e| Error::runtime(format!("the device's memory could not be read: {e}")))?
            .to_vec();
        staging.unmap();
        self.staging = Some(staging);
        Ok(bytes)
    }
}
