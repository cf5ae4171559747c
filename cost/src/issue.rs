//! How long instructions keep the vector units of a SIMD.
//!
//! Rates as in ACO's own estimate (Mesa, `src/amd/compiler/aco_statistics.cpp`). Scalar, memory and export units work
//! beside the vector units and are left out. RDNA has a second unit for transcendentals, which works beside the first.

/// Generations whose rates are known here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Generation {
    /// GFX9: 64 lanes in 4 cycles.
    Gcn,
    /// RDNA 1 and 2: 32 lanes in 1 cycle.
    Rdna,
}

impl Generation {
    /// The generation of a family, as `RADV_FORCE_FAMILY` names it.
    pub(crate) fn of(family: &str) -> Option<Self> {
        match family.to_ascii_lowercase().as_str() {
            "vega10" | "vega12" | "vega20" | "raven" | "raven2" | "renoir" => Some(Self::Gcn),
            "navi10" | "navi12" | "navi14" | "navi21" | "navi22" | "navi23" | "navi24"
            | "vangogh" => Some(Self::Rdna),
            _ => None,
        }
    }

    /// Cycles for which one subgroup of `lanes` keeps the vector units with these instructions.
    pub(crate) fn cycles(self, instructions: &[String], lanes: u32) -> u64 {
        let (mut vector, mut second) = (0, 0);
        for name in instructions.iter().filter(|name| name.starts_with("v_")) {
            let (first, other) = self.rate(class(name));
            (vector, second) = (vector + first, second + other);
        }
        match self {
            Self::Gcn => vector,
            Self::Rdna => vector.max(second) * u64::from(lanes.div_ceil(32)),
        }
    }

    /// Cycles on the vector unit for a whole subgroup of GCN or 32 lanes of RDNA, and on the second unit.
    fn rate(self, class: Class) -> (u64, u64) {
        match (self, class) {
            (Self::Gcn, Class::Plain) => (4, 0),
            (Self::Gcn, Class::Wide) => (8, 0),
            (Self::Gcn, Class::Convert | Class::Quarter | Class::Transcendental) => (16, 0),
            (Self::Gcn, Class::Double) => (64, 0),
            (Self::Rdna, Class::Plain | Class::Convert) => (1, 0),
            (Self::Rdna, Class::Wide) => (2, 2),
            (Self::Rdna, Class::Quarter) => (4, 4),
            (Self::Rdna, Class::Transcendental) => (1, 4),
            (Self::Rdna, Class::Double) => (16, 16),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    Plain,
    /// Integers of 64 bits without multiplication.
    Wide,
    Convert,
    /// Products of integers of 32 bits.
    Quarter,
    Transcendental,
    Double,
}

fn class(name: &str) -> Class {
    let starts = |all: &[&str]| all.iter().any(|start| name.starts_with(start));
    if name.contains("_f64") {
        Class::Double
    } else if starts(&["v_rcp_", "v_rsq_", "v_sqrt_", "v_exp_", "v_log_", "v_sin_", "v_cos_"]) {
        Class::Transcendental
    } else if starts(&[
        "v_mul_lo_u32",
        "v_mul_lo_i32",
        "v_mul_hi_u32",
        "v_mul_hi_i32",
        "v_mad_u64",
        "v_mad_i64",
    ]) {
        Class::Quarter
    } else if starts(&["v_cvt_"]) {
        Class::Convert
    } else if ["_b64", "_u64", "_i64"].iter().any(|wide| name.contains(wide)) {
        Class::Wide
    } else {
        Class::Plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(all: &[&str]) -> Vec<String> {
        all.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn scalar_and_memory_cost_nothing() {
        let instructions = names(&["s_mov_b32", "image_store", "ds_read_b32", "s_waitcnt"]);
        assert_eq!(Generation::Gcn.cycles(&instructions, 64), 0);
        assert_eq!(Generation::Rdna.cycles(&instructions, 64), 0);
    }

    #[test]
    fn units_of_rdna_overlap_and_those_of_gcn_do_not() {
        let instructions = names(&["v_rcp_f32_e32", "v_add_f32_e32", "v_add_f32_e32"]);
        assert_eq!(Generation::Rdna.cycles(&instructions, 64), 8);
        assert_eq!(Generation::Rdna.cycles(&instructions, 32), 4);
        assert_eq!(Generation::Gcn.cycles(&instructions, 64), 24);
    }

    #[test]
    fn slow_ones_are_told_apart() {
        assert_eq!(class("v_mul_lo_u32"), Class::Quarter);
        assert_eq!(class("v_lshrrev_b64"), Class::Wide);
        assert_eq!(class("v_cvt_f32_u32_e32"), Class::Convert);
        assert_eq!(class("v_fma_f64"), Class::Double);
        assert_eq!(class("v_fma_f32"), Class::Plain);
        assert_eq!(class("v_mul_hi_u32"), Class::Quarter);
    }
}
