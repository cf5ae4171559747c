//! How long each pass takes: by the device's time stamps, or by wall-clock time where it has none.

use std::time::{Duration, Instant};

use sglow_runtime::timing::{PassTimer, Stamps};

use crate::device::{DeviceError, Gpu};
use crate::readback;

/// How times were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Time stamps written by the device around each pass.
    Timestamps,
    /// The CPU's clock around the submission of each pass and its end: submission costs are inside.
    Wall,
}

impl std::fmt::Display for Clock {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Timestamps => "device time stamps",
            Self::Wall => "wall clock",
        })
    }
}

/// The most passes that one frame may time.
const CAPACITY: u32 = 64;

enum Method {
    Timestamps { queries: wgpu::QuerySet, period: f64 },
    Wall { since: Instant, times: Vec<Duration> },
}

/// Times the passes of one frame.
pub struct Timer<'a> {
    gpu: &'a Gpu,
    method: Method,
    labels: Vec<String>,
    dispatches: Vec<usize>,
}

impl<'a> Timer<'a> {
    /// A timer by the best clock the device has.
    pub fn new(gpu: &'a Gpu) -> Self {
        Self::with(gpu, if gpu.has_timestamps() { Clock::Timestamps } else { Clock::Wall })
    }

    /// A timer by a clock of choice; without time stamps on the device it is the wall's.
    pub fn with(gpu: &'a Gpu, clock: Clock) -> Self {
        let method = if clock == Clock::Timestamps && gpu.has_timestamps() {
            let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("sglow timer"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * CAPACITY,
            });
            Method::Timestamps { queries, period: f64::from(gpu.queue.get_timestamp_period()) }
        } else {
            Method::Wall { since: Instant::now(), times: Vec::new() }
        };
        Self { gpu, method, labels: Vec::new(), dispatches: Vec::new() }
    }

    /// How this timer takes its times.
    pub fn clock(&self) -> Clock {
        match self.method {
            Method::Timestamps { .. } => Clock::Timestamps,
            Method::Wall { .. } => Clock::Wall,
        }
    }

    /// The dispatches of each compute pass in the order they were announced; 0 of a render pass.
    pub fn dispatches(&self) -> Vec<usize> {
        self.dispatches.clone()
    }

    /// The time of each pass in the order they were announced, once the work is submitted. Waits for the device.
    pub fn finish(self) -> Result<Vec<(String, Duration)>, DeviceError> {
        let times = match &self.method {
            Method::Wall { times, .. } => times.clone(),
            Method::Timestamps { queries, period } => {
                let count = 2 * self.labels.len() as u32;
                if count == 0 {
                    return Ok(Vec::new());
                }
                let resolved = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("sglow timer"),
                    size: u64::from(count) * 8,
                    usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                });
                let mut encoder = self
                    .gpu
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encoder.resolve_query_set(queries, 0..count, &resolved, 0);
                self.gpu.queue.submit([encoder.finish()]);
                let stamps: Vec<u64> = readback::buffer(self.gpu, &resolved)?;
                stamps
                    .chunks_exact(2)
                    .map(|pair| {
                        Duration::from_nanos(
                            (pair[1].saturating_sub(pair[0]) as f64 * period) as u64,
                        )
                    })
                    .collect()
            }
        };
        Ok(self.labels.into_iter().zip(times).collect())
    }
}

impl PassTimer for Timer<'_> {
    fn begin(&mut self, label: &str) -> Option<Stamps<'_>> {
        let index = self.labels.len() as u32;
        if index >= CAPACITY {
            return None;
        }
        self.labels.push(label.to_owned());
        self.dispatches.push(0);
        match &mut self.method {
            Method::Timestamps { queries, .. } => Some(Stamps { queries, begin: 2 * index }),
            Method::Wall { since, .. } => {
                *since = Instant::now();
                None
            }
        }
    }

    fn dispatched(&mut self, count: usize) {
        if let Some(last) = self.dispatches.last_mut() {
            *last += count;
        }
    }

    fn end(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if let Method::Wall { since, times } = &mut self.method {
            let fresh =
                self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let filled = std::mem::replace(encoder, fresh);
            self.gpu.queue.submit([filled.finish()]);
            // What goes wrong here is reported by `Gpu::finish`, which every frame ends with.
            let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
            if times.len() < self.labels.len() {
                times.push(since.elapsed());
            }
        }
    }
}
