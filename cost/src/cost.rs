//! What a compiler says of shaders.

use serde::{Deserialize, Serialize};

/// The compiler that made the figures.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Compiler {
    /// Driver and version, such as `radv Mesa 22.3.6`.
    pub driver: String,
    /// The family of GPUs that it compiles for, as `RADV_FORCE_FAMILY` names it.
    pub family: String,
    /// The driver's name of the device.
    pub device: String,
}

/// What the compiler says of one entry point.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cost {
    /// The variant's identifier.
    pub id: String,
    /// Name of the entry point.
    pub entry_point: String,
    /// Machine instructions.
    pub instructions: u64,
    /// Size of the machine code, bytes.
    pub code_bytes: u64,
    /// Vector registers of one lane.
    pub vgprs: u64,
    /// Scalar registers of one subgroup; on RDNA always 128.
    pub sgprs: u64,
    /// Vector registers that did not fit.
    pub spilled_vgprs: u64,
    /// Scalar registers that did not fit.
    pub spilled_sgprs: u64,
    /// Private memory of one subgroup, bytes.
    pub scratch_bytes: u64,
    /// Memory of one workgroup, bytes.
    pub lds_bytes: u64,
    /// How many subgroups a SIMD holds at once.
    pub subgroups_per_simd: u64,
    /// ACO's estimate of the cycles that one subgroup keeps the busiest unit. Loops count 8 times and branches a
    /// fixed share, so it does not compare shaders of different control flow.
    pub inverse_throughput: u64,
    /// Loops in the machine code. One that the compiler has unrolled is none.
    pub loops: u64,
    /// Instructions of the longest loop that has no loop inside; none without loops.
    pub loop_instructions: Option<u64>,
    /// Cycles that one pass of one subgroup through that loop keeps the vector units, every path taken; none without
    /// loops or for a family whose rates are not known here.
    pub loop_issue_cycles: Option<u64>,
}

/// A variant that was not compiled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// The variant's identifier.
    pub id: String,
    /// Why it was not compiled.
    pub why: String,
}

/// The figures of shaders.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Costs {
    /// What made them.
    pub compiler: Compiler,
    /// By identifier, then by entry point.
    pub costs: Vec<Cost>,
    /// By identifier.
    pub skipped: Vec<Skipped>,
}

impl Cost {
    /// The figures by their names; none where one has no value.
    pub(crate) fn figures(&self) -> Vec<(String, Option<u64>)> {
        let all = serde_json::to_value(self).unwrap_or_default();
        let figures = all.as_object().into_iter().flatten();
        let figures = figures.filter(|(_, value)| !value.is_string());
        figures.map(|(name, value)| (name.clone(), value.as_u64())).collect()
    }
}

impl Costs {
    /// Puts both lists in their order.
    pub(crate) fn sort(&mut self) {
        self.costs.sort_by(|a, b| (&a.id, &a.entry_point).cmp(&(&b.id, &b.entry_point)));
        self.skipped.sort_by(|a, b| a.id.cmp(&b.id));
    }
}
