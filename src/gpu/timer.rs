//! How long dispatches take, by the device's own clock.

use std::collections::BTreeMap;

use super::context::Context;

/// Time stamps that are kept until they are read: as many as a query set may hold everywhere.
const STAMPS: u32 = 4096;
/// Stamps are resolved to offsets that are multiples of 256 bytes.
const STAMPS_ALIGNED: u32 = 32;

/// Time stamps of compute passes, a label each; only on devices that have them.
pub(super) struct Timer {
    set: wgpu::QuerySet,
    /// Where stamps are resolved to, 8 bytes each.
    pub(super) stamps: wgpu::Buffer,
    tick_s: f64,
    /// Label and first stamp of each pass that is not read yet.
    passes: Vec<(u32, u32)>,
    /// First stamps of this submission, and after its last.
    open: u32,
    next: u32,
    seconds: BTreeMap<u32, f64>,
}

impl Timer {
    /// None on devices without a clock.
    pub(super) fn new(context: &Context) -> Option<Self> {
        let device = &context.device;
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: STAMPS,
            }),
            stamps: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: 8 * u64::from(STAMPS),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            tick_s: 1e-9 * f64::from(context.queue.get_timestamp_period()),
            passes: Vec::new(),
            open: 0,
            next: 0,
            seconds: BTreeMap::new(),
        })
    }

    /// Whether a submission of so many passes has room; if not, read first.
    pub(super) fn has_room(&self, passes: usize) -> bool {
        self.next as usize + 2 * passes <= STAMPS as usize
    }

    /// For the next pass of a submission.
    pub(super) fn stamp(&mut self, label: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = self.next;
        self.next += 2;
        self.passes.push((label, first));
        wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// After the last pass of a submission.
    pub(super) fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, self.open..self.next, &self.stamps, 8 * u64::from(self.open));
        self.next = self.next.next_multiple_of(STAMPS_ALIGNED).min(STAMPS);
        self.open = self.next;
    }

    /// Bytes of `stamps` that are waiting to be read.
    pub(super) fn waiting(&self) -> u64 {
        8 * u64::from(self.open)
    }

    /// Takes what was read of `stamps`; all of it is free again.
    pub(super) fn take(&mut self, bytes: &[u8]) {
        let stamp = |i: u32| {
            let at = 8 * i as usize;
            bytes.get(at..at + 8).map_or(0, |word| u64::from_le_bytes(word.try_into().expect("8 bytes")))
        };
        for (label, first) in self.passes.drain(..) {
            let ticks = stamp(first + 1).saturating_sub(stamp(first));
            *self.seconds.entry(label).or_default() += ticks as f64 * self.tick_s;
        }
        (self.open, self.next) = (0, 0);
    }

    /// Seconds by label since the last call.
    pub(super) fn seconds(&mut self) -> BTreeMap<u32, f64> {
        std::mem::take(&mut self.seconds)
    }
}
