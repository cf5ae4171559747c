//! A stable radix sort of words by words, with nothing that WebGPU does not have.

use bytemuck::{Pod, Zeroable};

use crate::package::Package;
use crate::pipeline::{ComputePass, PipelineError, Step, constant, encode_stage, storage};
use crate::timing::Timer;

/// Bits of a digit; as `shaders/src/cluster/sort.wesl` has them.
const DIGIT_BITS: u32 = 4;
/// Keys of a block.
const BLOCK: u32 = 1024;
/// The most keys: one workgroup a block, of which a dispatch has 65535.
pub const MOST_KEYS: u32 = 65535 * BLOCK;

/// The uniform of the three passes, which are not committed and so have no struct in the bindings; padded to 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Parameters {
    length: u32,
    shift: u32,
    blocks: u32,
    padding: u32,
}

/// The three passes of a digit.
pub(crate) struct SortPasses {
    count: ComputePass,
    scan: ComputePass,
    scatter: ComputePass,
}

impl SortPasses {
    pub(crate) fn variants() -> Vec<String> {
        use sglow_shaders::{sort_count, sort_scan, sort_scatter};
        vec![sort_count::SortCount.id(), sort_scan::SortScan.id(), sort_scatter::SortScatter.id()]
    }

    pub(crate) fn new(device: &wgpu::Device, package: &Package) -> Result<Self, PipelineError> {
        let pass = |id: String| ComputePass::new(device, package, &id, "sort", &[]);
        Ok(Self {
            count: pass(sglow_shaders::sort_count::SortCount.id())?,
            scan: pass(sglow_shaders::sort_scan::SortScan.id())?,
            scatter: pass(sglow_shaders::sort_scatter::SortScatter.id())?,
        })
    }
}

/// The buffers of a sort of a fixed number of keys.
pub(crate) struct SortBuffers {
    /// A uniform for each digit.
    parameters: Vec<wgpu::Buffer>,
    blocks: u32,
    counts: wgpu::Buffer,
    /// What is sorted; it stays as it is.
    keys: wgpu::Buffer,
    /// What digits are sorted into by turns.
    sorted: [wgpu::Buffer; 2],
    /// What moves with the keys, by turns; the first one is what the keys bring.
    values: [wgpu::Buffer; 2],
}

impl SortBuffers {
    /// For `length` keys below 2^`bits`.
    pub(crate) fn new(device: &wgpu::Device, length: u32, bits: u32) -> Self {
        let blocks = length.div_ceil(BLOCK);
        let digits = bits.div_ceil(DIGIT_BITS);
        let parameters = (0..digits).map(|digit| {
            let shift = digit * DIGIT_BITS;
            constant(device, "sglow sort", &Parameters { length, shift, blocks, padding: 0 })
        });
        let words = |label| storage(device, label, u64::from(length));
        Self {
            parameters: parameters.collect(),
            blocks,
            counts: storage(device, "sglow sort counts", 16 * u64::from(blocks)),
            keys: words("sglow keys"),
            sorted: ["sglow sorted keys", "sglow sorted keys"].map(words),
            values: ["sglow sorted values", "sglow sorted values"].map(words),
        }
    }

    /// The bytes of the buffers of `length` keys, without the uniforms.
    pub(crate) fn bytes_of(length: u32) -> u64 {
        4 * (16 * u64::from(length.div_ceil(BLOCK)) + 5 * u64::from(length))
    }

    pub(crate) fn keys(&self) -> &wgpu::Buffer {
        &self.keys
    }

    pub(crate) fn values(&self) -> &wgpu::Buffer {
        &self.values[0]
    }

    pub(crate) fn sorted_keys(&self) -> &wgpu::Buffer {
        match self.parameters.len() {
            0 => &self.keys,
            digits => &self.sorted[(digits - 1) % 2],
        }
    }

    pub(crate) fn sorted_values(&self) -> &wgpu::Buffer {
        &self.values[self.parameters.len() % 2]
    }

    /// The dispatches of all digits, the lowest one first.
    pub(crate) fn steps<'a>(&'a self, passes: &'a SortPasses) -> Vec<Step<'a>> {
        let blocks = [self.blocks, 1, 1];
        let mut steps = Vec::new();
        for (digit, parameters) in self.parameters.iter().enumerate() {
            let keys = if digit == 0 { &self.keys } else { &self.sorted[(digit - 1) % 2] };
            let bind = |buffers: &[&'a wgpu::Buffer]| {
                (0..).zip(buffers.iter().map(|buffer| buffer.as_entire_binding())).collect()
            };
            let counts = &self.counts;
            steps.push(Step {
                pass: &passes.count,
                bindings: bind(&[parameters, keys, counts]),
                workgroups: blocks,
            });
            steps.push(Step {
                pass: &passes.scan,
                bindings: bind(&[parameters, counts]),
                workgroups: [1; 3],
            });
            let (from, to) = (&self.values[digit % 2], &self.values[(digit + 1) % 2]);
            steps.push(Step {
                pass: &passes.scatter,
                bindings: bind(&[parameters, keys, from, counts, &self.sorted[digit % 2], to]),
                workgroups: blocks,
            });
        }
        steps
    }

    pub(crate) fn bytes(&self) -> u64 {
        let buffers = [&self.counts, &self.keys];
        let all = buffers.into_iter().chain(&self.sorted).chain(&self.values);
        all.map(wgpu::Buffer::size).sum()
    }
}

/// A stable sort of words by words.
pub struct RadixSort {
    passes: SortPasses,
    buffers: SortBuffers,
}

impl RadixSort {
    /// A sort of `length` keys, 1 to [`MOST_KEYS`], of which the lowest `bits` count, 0 to 32.
    ///
    /// # Errors
    ///
    /// When the package lacks a variant or the device refuses it.
    pub fn new(
        device: &wgpu::Device,
        package: &Package,
        length: u32,
        bits: u32,
    ) -> Result<Self, PipelineError> {
        Ok(Self {
            passes: SortPasses::new(device, package)?,
            buffers: SortBuffers::new(device, length, bits),
        })
    }

    /// Encodes the sort.
    pub fn encode(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
    ) {
        encode_stage(device, encoder, timer, "sort", &self.buffers.steps(&self.passes));
    }

    /// The keys that are to be sorted: write them here. The sort leaves them as they are.
    pub fn keys(&self) -> &wgpu::Buffer {
        self.buffers.keys()
    }

    /// The values that move with the keys: write them here, for every sort.
    pub fn values(&self) -> &wgpu::Buffer {
        self.buffers.values()
    }

    /// The sorted keys.
    pub fn sorted_keys(&self) -> &wgpu::Buffer {
        self.buffers.sorted_keys()
    }

    /// The values in the order of the sorted keys.
    pub fn sorted_values(&self) -> &wgpu::Buffer {
        self.buffers.sorted_values()
    }
}
