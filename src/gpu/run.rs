//! A run on the device: its buffers behind bind group 1, its pipelines, and recorded dispatches.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytemuck::Pod;

use super::context::Context;
use super::layout::{PassUniform, WEIGHT_ENTRIES, strategy_words};
use super::pipelines::{Builder, Built, Compilation};
use super::scene::{GpuScene, SceneData};
use super::shader::Variant;
use super::timer::Timer;
use super::workgroups::{group_stride, workgroups};
use crate::ensemble::pool::MAX_EDGES;
use crate::{Error, Result};

/// Passes that one submission can hold.
pub const PASS_SLOTS: usize = 256;
/// Uniform offsets are multiples of this on every device.
const PASS_STRIDE: usize = 256;

/// Bytes of each buffer that a run needs.
#[derive(Debug, Clone, Copy, Default)]
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
    timer: Option<Timer>,
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
        let strategies = uniform("strategies", 4 * (strategy_words(MAX_EDGES) + WEIGHT_ENTRIES));
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
        context.check()?;
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
            timer: Timer::new(context),
            device_time: Duration::ZERO,
        })
    }

    /// Sets log P(edges, light-side vertices), row-major: [`strategy_words`].
    pub fn set_strategies(&self, log_probability: &[f32]) {
        self.context.queue.write_buffer(&self.strategies, 0, bytemuck::cast_slice(log_probability));
    }

    /// Sets w of the two-stage target, by tiles of the film; behind the strategies of paths of up to `max_edges` edges.
    pub fn set_pixel_weights(&self, max_edges: u32, weights: &[f32; WEIGHT_ENTRIES]) {
        let offset = 4 * strategy_words(max_edges) as u64;
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

    /// Builds pipelines, all at once, and has the driver compile them.
    pub fn compile(&mut self, variants: &[Variant]) -> Result<()> {
        let missing = self.missing(variants);
        let built = self.builder().build_all(&missing)?;
        let mut compilation = self.adopt(built);
        while compilation.step(self)? {}
        Ok(())
    }

    /// Those of `variants` that have not run on the device before; the others are taken over.
    pub fn missing(&mut self, variants: &[Variant]) -> Vec<Variant> {
        let known = self.context.pipelines();
        let mut missing = Vec::new();
        for variant in variants {
            match known.get(variant) {
                Some(pipeline) => drop(self.pipelines.insert(variant.clone(), pipeline.clone())),
                None => missing.push(variant.clone()),
            }
        }
        missing
    }

    /// What builds pipelines for this run elsewhere, to be handed to [`Run::adopt`].
    pub fn builder(&self) -> Builder {
        Builder {
            device: self.context.device.clone(),
            sources: self.context.sources(),
            workgroup: self.context.workgroup,
            layouts: [self.scene.layout.clone(), self.layout.clone()],
        }
    }

    /// Takes pipelines over; they are ready once the compilation is done.
    pub fn adopt(&mut self, built: Built) -> Compilation {
        let variants = built.iter().map(|(variant, _)| variant.clone()).collect();
        self.pipelines.extend(built);
        Compilation::new(variants)
    }

    /// Runs a pipeline once on nothing, and waits: from then on the device knows it.
    pub(super) fn once(&mut self, variant: &Variant) -> Result<()> {
        self.submit(&[Dispatch { variant: variant.clone(), uniform: PassUniform::default() }])?;
        self.wait()?;
        self.context.pipelines().insert(variant.clone(), self.pipelines[variant].clone());
        Ok(())
    }

    pub(super) fn context(&self) -> &'a Context {
        self.context
    }

    /// Records and submits dispatches in order, at most 256 of them.
    pub fn submit(&mut self, dispatches: &[Dispatch]) -> Result<()> {
        self.record(dispatches, false)
    }

    /// The same, and adds up how long they take: see [`Run::times`].
    pub fn submit_timed(&mut self, dispatches: &[Dispatch]) -> Result<()> {
        if self.timer.as_ref().is_some_and(|timer| !timer.has_room(dispatches.len())) {
            self.read_stamps()?;
        }
        self.record(dispatches, true)
    }

    /// Seconds on the device that dispatches of [`Run::submit_timed`] took since the last call, by where they count
    /// (`counters_offset`); waits for them. Empty where the device has no clock.
    pub fn times(&mut self) -> Result<BTreeMap<u32, f64>> {
        self.read_stamps()?;
        Ok(self.timer.as_mut().map(Timer::seconds).unwrap_or_default())
    }

    fn read_stamps(&mut self) -> Result<()> {
        let Some((stamps, waiting)) = self.timer.as_ref().map(|timer| (timer.stamps.clone(), timer.waiting())) else {
            return Ok(());
        };
        if waiting > 0 {
            let bytes = self.look_at_copy(&stamps, std::slice::from_ref(&(0..waiting)), <[u8]>::to_vec)?;
            self.timer.iter_mut().for_each(|timer| timer.take(&bytes));
        }
        Ok(())
    }

    fn record(&mut self, dispatches: &[Dispatch], timed: bool) -> Result<()> {
        assert!(dispatches.len() <= PASS_SLOTS, "{} passes in one submission", dispatches.len());
        let mut bytes = vec![0u8; dispatches.len() * PASS_STRIDE];
        for (slot, dispatch) in bytes.chunks_exact_mut(PASS_STRIDE).zip(dispatches) {
            if !self.pipelines.contains_key(&dispatch.variant) {
                self.pipelines.insert(dispatch.variant.clone(), self.builder().build(&dispatch.variant)?);
            }
            let [x, y] = workgroups(dispatch.uniform.entries, self.context.workgroup);
            let uniform = PassUniform { group_stride: group_stride(x * y), ..dispatch.uniform };
            slot[..size_of::<PassUniform>()].copy_from_slice(bytemuck::bytes_of(&uniform));
        }
        self.context.queue.write_buffer(&self.uniforms, 0, &bytes);
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        let mut timer = self.timer.as_mut().filter(|_| timed);
        // Stamps are those of whole passes: each has the dispatches of one counter.
        let label = |dispatch: &Dispatch| dispatch.uniform.counters_offset;
        let stamped = timer.is_some();
        let mut slots = 0..;
        for part in dispatches.chunk_by(|a, b| !stamped || label(a) == label(b)) {
            let timestamp_writes = timer.as_mut().map(|timer| timer.stamp(label(&part[0])));
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            pass.set_bind_group(0, &self.scene.group, &[]);
            for (dispatch, i) in part.iter().zip(&mut slots) {
                let [x, y] = workgroups(dispatch.uniform.entries, self.context.workgroup);
                pass.set_pipeline(&self.pipelines[&dispatch.variant]);
                pass.set_bind_group(1, &self.group, &[(i * PASS_STRIDE) as u32]);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
        if let Some(timer) = timer {
            timer.resolve(&mut encoder);
        }
        self.hand_over(encoder);
        self.context.check()
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
        // What the device says of itself explains more than that it stopped.
        self.context.check()?;
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

    /// Waits for all work, then copies a byte range of a buffer, as the words or rows that lie there.
    pub fn read<T: Pod>(&mut self, buffer: Buffer, range: Range<u64>) -> Result<Vec<T>> {
        self.read_ranges(buffer, std::slice::from_ref(&range))
    }

    /// Waits for all work, then copies byte ranges of a buffer, one after another.
    pub fn read_ranges<T: Pod>(&mut self, buffer: Buffer, ranges: &[Range<u64>]) -> Result<Vec<T>> {
        self.look_at(buffer, ranges, bytemuck::pod_collect_to_vec)
    }

    /// Waits for all work, then shows byte ranges of a buffer, one after another: for a look at a few of many.
    pub fn look_at<T>(&mut self, buffer: Buffer, ranges: &[Range<u64>], look: impl FnOnce(&[u8]) -> T) -> Result<T> {
        let source = self.buffer(buffer).clone();
        self.look_at_copy(&source, ranges, look)
    }

    fn look_at_copy<T>(
        &mut self,
        source: &wgpu::Buffer,
        ranges: &[Range<u64>],
        look: impl FnOnce(&[u8]) -> T,
    ) -> Result<T> {
        let total: u64 = ranges.iter().map(|r| r.end - r.start).sum();
        if total == 0 {
            // There is nothing to map.
            return Ok(look(bytemuck::cast_slice::<u128, u8>(&[])));
        }
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
            encoder.copy_buffer_to_buffer(source, range.start, &staging, at, size);
            at += size;
        }
        self.hand_over(encoder);
        self.context.check()?;
        let slice = staging.slice(..total);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        self.wait()?;
        let seen = slice
            .get_mapped_range()
            .map(|bytes| look(&bytes))
            .map_err(|e| Error::runtime(format!("the device's memory could not be read: {e}")))?;
        staging.unmap();
        self.staging = Some(staging);
        Ok(seen)
    }
}
