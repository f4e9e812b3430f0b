//! Where a card's time goes: a timestamp before and after each dispatch, summed by stage.

use super::device::Gpu;
use crate::backend::BackendError;
use std::sync::{Mutex, PoisonError};

/// Dispatches whose times are kept between two readings; those beyond are counted without a time.
const MOST_PENDING: u32 = 2048;

/// What one stage took.
#[derive(Clone, Debug, PartialEq)]
pub struct StageTime {
    /// The kernel's name.
    pub name: &'static str,
    /// Seconds until its pipeline was there; next to nothing where it was compiled before.
    pub compile_seconds: f64,
    /// How often it was started.
    pub dispatches: u64,
    /// Threads that were asked for, in all.
    pub threads: u64,
    /// Seconds on the device.
    pub seconds: f64,
}

/// Sums, and what waits to be read.
#[derive(Default)]
struct State {
    totals: Vec<StageTime>,
    /// Places in `totals` of the dispatches whose two timestamps stand in the query set, in order.
    pending: Vec<usize>,
}

impl State {
    fn place_of(&mut self, name: &'static str) -> usize {
        self.totals.iter().position(|t| t.name == name).unwrap_or_else(|| {
            self.totals.push(StageTime { name, compile_seconds: 0.0, dispatches: 0, threads: 0, seconds: 0.0 });
            self.totals.len() - 1
        })
    }
}

/// The clock of one picture or several.
pub(super) struct StageClock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    nanoseconds: f64,
    state: Mutex<State>,
}

impl StageClock {
    /// `None` where the device has no timestamps.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let count = 2 * MOST_PENDING;
        let descriptor = wgpu::QuerySetDescriptor { label: Some("stage times"), ty: wgpu::QueryType::Timestamp, count };
        Some(Self {
            queries: gpu.device.create_query_set(&descriptor),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage times"),
                size: 8 * u64::from(count),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            nanoseconds: f64::from(gpu.queue.get_timestamp_period()),
            state: Mutex::default(),
        })
    }

    /// Counts a dispatch that is about to be recorded, and says where its timestamps go; `None` once all places are taken.
    pub fn begin(&self, name: &'static str, threads: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let at = state.place_of(name);
        state.totals[at].dispatches += 1;
        state.totals[at].threads += u64::from(threads);
        let k = state.pending.len() as u32;
        if k >= MOST_PENDING {
            return None;
        }
        state.pending.push(at);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * k),
            end_of_pass_write_index: Some(2 * k + 1),
        })
    }

    /// Notes how long a stage's pipeline took; the longest time counts.
    pub fn compiled(&self, name: &'static str, seconds: f64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let at = state.place_of(name);
        state.totals[at].compile_seconds = seconds.max(state.totals[at].compile_seconds);
    }

    /// Forgets all dispatches; what compiling took stays.
    pub fn restart(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        for t in &mut state.totals {
            *t = StageTime { dispatches: 0, threads: 0, seconds: 0.0, ..*t };
        }
    }

    /// Reads the times once half of the places are taken: reading waits for the device, which the times must not show.
    pub fn read_when_filling(&self, gpu: &Gpu) -> Result<(), BackendError> {
        let n = self.state.lock().unwrap_or_else(PoisonError::into_inner).pending.len() as u32;
        if n < MOST_PENDING / 2 { Ok(()) } else { self.read(gpu) }
    }

    /// Reads the times of all dispatches so far; they must have been submitted.
    pub fn read(&self, gpu: &Gpu) -> Result<(), BackendError> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let pending = std::mem::take(&mut state.pending);
        if pending.is_empty() {
            return Ok(());
        }
        let n = 2 * pending.len() as u32;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.resolve_query_set(&self.queries, 0..n, &self.resolved, 0);
        let bytes = gpu.submit_and_read(encoder, &self.resolved, 0, 8 * u64::from(n))?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        for (at, pair) in pending.into_iter().zip(ticks.chunks_exact(2)) {
            state.totals[at].seconds += pair[1].saturating_sub(pair[0]) as f64 * self.nanoseconds * 1e-9;
        }
        Ok(())
    }

    /// The sums, longest first.
    pub fn totals(&self) -> Vec<StageTime> {
        let mut list = self.state.lock().unwrap_or_else(PoisonError::into_inner).totals.clone();
        list.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        list
    }
}
