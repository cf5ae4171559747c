//! A function of a shader on the CPU, in f32, under any [`Arithmetic`]: what its text does on a driver that one has not.
//!
//! The text's naga IR is taken apart into operations on scalars, with every call inlined, as drivers do. Functions with
//! loops, bindings or pointers into buffers are not mirrored; those of a function library have none.

mod build;
mod chance;
mod expression;
mod operation;
mod rearrange;
mod step;

use std::collections::HashMap;

use naga::Module;
use naga::valid::ModuleInfo;
use sglow_results::arithmetic::Arithmetic;

use self::build::{Builder, unsupported};
use self::operation::{Operation, evaluate};
use self::step::{Register, Step};

pub use self::step::MirrorError;

/// A function, ready to run.
#[derive(Clone, Debug)]
pub struct Mirror {
    steps: Vec<Step>,
    constants: Vec<(Register, u32)>,
    registers: usize,
    inputs: Vec<Register>,
    outputs: Vec<Register>,
    arithmetic: Arithmetic,
}

impl Mirror {
    /// Takes a function of a module apart.
    ///
    /// # Errors
    ///
    /// When there is no such function, or when it or one that it calls does what is not mirrored.
    pub fn new(
        module: &Module,
        info: &ModuleInfo,
        name: &str,
        arithmetic: Arithmetic,
    ) -> Result<Self, MirrorError> {
        let found = module.functions.iter().find(|(_, one)| one.name.as_deref() == Some(name));
        let Some((handle, function)) = found else {
            let known = module.functions.iter().filter_map(|(_, one)| one.name.clone());
            return Err(MirrorError::NoFunction { name: name.to_owned(), known: known.collect() });
        };
        let mut builder = Builder {
            module,
            info,
            arithmetic,
            steps: Vec::new(),
            constants: Vec::new(),
            constant_of: HashMap::new(),
            definitions: Vec::new(),
        };
        let mut arguments = Vec::new();
        for argument in &function.arguments {
            let width = builder.width(&module.types[argument.ty].inner);
            let width =
                width.ok_or_else(|| unsupported(function, "an argument of unsized type"))?;
            arguments.push((0..width).map(|_| builder.register()).collect::<Vec<_>>());
        }
        let inputs = arguments.concat();
        let outputs = builder.call(handle, arguments)?;
        let mut mirror = Self {
            steps: builder.steps,
            constants: builder.constants,
            registers: builder.definitions.len(),
            inputs,
            outputs,
            arithmetic,
        };
        mirror.drop_unused();
        Ok(mirror)
    }

    /// How many scalars the function takes.
    #[must_use]
    pub fn input_count(&self) -> usize {
        self.inputs.len()
    }

    /// How many scalars it returns.
    #[must_use]
    pub fn output_count(&self) -> usize {
        self.outputs.len()
    }

    /// How many operations it takes at most.
    #[must_use]
    pub fn step_count(&self) -> usize {
        self.steps.len()
    }

    /// The floating-point literals that it reads, and what else is constant in it: near these it may branch.
    #[must_use]
    pub fn literals(&self) -> Vec<f32> {
        let values = self.constants.iter().map(|(_, bits)| f32::from_bits(*bits));
        values.filter(|value| value.is_normal()).collect()
    }

    /// A register file for [`Self::run`], to be used again.
    #[must_use]
    pub fn registers(&self) -> Vec<u32> {
        let mut registers = vec![0; self.registers];
        for &(register, bits) in &self.constants {
            registers[register as usize] = bits;
        }
        registers
    }

    /// Runs the function once: bits of its inputs in, bits of its result out.
    ///
    /// # Panics
    ///
    /// When `registers` is not of this mirror, or `input` or `output` are too short.
    pub fn run(&self, registers: &mut [u32], input: &[u32], output: &mut [u32]) {
        for (register, bits) in self.inputs.iter().zip(input) {
            registers[*register as usize] = *bits;
        }
        let mut at = 0;
        while let Some(step) = self.steps.get(at) {
            let [a, b, c] = step.operands.map(|operand| registers[operand as usize]);
            at += 1;
            match step.operation {
                Operation::Jump => at = step.to as usize,
                Operation::JumpUnless => {
                    if a == 0 {
                        at = step.to as usize;
                    }
                }
                operation => {
                    registers[step.to as usize] = evaluate(operation, a, b, c, self.arithmetic);
                }
            }
        }
        for (register, bits) in self.outputs.iter().zip(output) {
            *bits = registers[*register as usize];
        }
    }

    /// Removes steps whose result nothing reads. Jumps only lead forward, so that one pass from the end finds them.
    fn drop_unused(&mut self) {
        let mut used = vec![false; self.registers];
        for output in &self.outputs {
            used[*output as usize] = true;
        }
        let mut keep = vec![false; self.steps.len()];
        for (index, step) in self.steps.iter().enumerate().rev() {
            let jumps = matches!(step.operation, Operation::Jump | Operation::JumpUnless);
            if jumps || used[step.to as usize] {
                keep[index] = true;
                if step.operation != Operation::Jump {
                    step.operands.iter().for_each(|operand| used[*operand as usize] = true);
                }
            }
        }
        let mut moved = Vec::with_capacity(self.steps.len() + 1);
        let mut count = 0;
        for kept in &keep {
            moved.push(count);
            count += u32::from(*kept);
        }
        moved.push(count);
        let mut kept = keep.iter();
        self.steps.retain(|_| kept.next().copied().unwrap_or(false));
        for step in &mut self.steps {
            if matches!(step.operation, Operation::Jump | Operation::JumpUnless) {
                step.to = moved[step.to as usize];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    fn mirror(text: &str, name: &str, arithmetic: Arithmetic) -> Mirror {
        let module = naga::front::wgsl::parse_str(text).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        Mirror::new(&module, &info, name, arithmetic).unwrap()
    }

    fn run(mirror: &Mirror, input: &[f32]) -> Vec<f32> {
        let input: Vec<u32> = input.iter().map(|value| value.to_bits()).collect();
        let mut output = vec![0; mirror.output_count()];
        mirror.run(&mut mirror.registers(), &input, &mut output);
        output.into_iter().map(f32::from_bits).collect()
    }

    const TEXT: &str = "
        struct Lobe { axis: vec3<f32>, sharpness: f32 }
        const SCALE = vec2<f32>(2.0, 3.0);
        fn early(x: f32) -> f32 {
            if x < 0.0 { return -x; }
            return sqrt(x);
        }
        fn whole(v: vec3<f32>, s: f32) -> Lobe {
            var axis = v;
            if s > 10.0 { axis.y = early(s); } else { axis = axis / s; }
            return Lobe(normalize(axis) * SCALE.y, mix(s, dot(v, v.zyx), 0.25));
        }
        fn swallowed(x: f32) -> f32 { return (x + 1e8) - 1e8; }
        fn contracted(x: f32) -> f32 { return x * x - 1.0; }
        fn scaled(a: f32, b: f32, c: f32) -> f32 { return a * (b / c); }
    ";

    #[test]
    fn calls_branches_variables_and_structs_are_taken_apart() {
        let whole = mirror(TEXT, "whole", Arithmetic::Written);
        let expected = |v: [f32; 3], s: f32| {
            let mut axis = v;
            if s > 10.0 {
                axis[1] = s.sqrt();
            } else {
                axis = axis.map(|part| part / s);
            }
            let squared = (axis[0] * axis[0] + axis[1] * axis[1]) + axis[2] * axis[2];
            let scale = (1.0 / f64::from(squared).sqrt()) as f32;
            let dot = (v[0] * v[2] + v[1] * v[1]) + v[2] * v[0];
            let [x, y, z] = axis.map(|part| part * scale * 3.0);
            vec![x, y, z, s * 0.75 + dot * 0.25]
        };
        for (v, s) in [([1.0, 2.0, 3.0], 4.0), ([0.3, -2.0, 0.1], 49.0)] {
            assert_eq!(run(&whole, &[v[0], v[1], v[2], s]), expected(v, s));
        }
        let early = mirror(TEXT, "early", Arithmetic::Written);
        assert_eq!((run(&early, &[-2.5]), run(&early, &[9.0])), (vec![2.5], vec![3.0]));
    }

    #[test]
    fn arithmetics_do_what_drivers_do() {
        let swallowed = |arithmetic| run(&mirror(TEXT, "swallowed", arithmetic), &[3.0])[0];
        assert_eq!(swallowed(Arithmetic::Written), 0.0);
        assert_eq!(swallowed(Arithmetic::Reassociated(1)), 3.0);
        let x = 1.1;
        let contracted = |arithmetic| run(&mirror(TEXT, "contracted", arithmetic), &[x])[0];
        assert_eq!(contracted(Arithmetic::Written), x * x - 1.0);
        assert_eq!(contracted(Arithmetic::Contracted), x.mul_add(x, -1.0));
        assert_ne!(x.mul_add(x, -1.0), x * x - 1.0);
        let scaled = |arithmetic| run(&mirror(TEXT, "scaled", arithmetic), &[1e30, 1e30, 1e30])[0];
        assert_eq!(scaled(Arithmetic::Written), 1e30);
        let orders = (1..=8).map(|seed| scaled(Arithmetic::Reassociated(seed)));
        assert!(orders.filter(|value| value.is_infinite()).count() > 0, "no order overflows");
        let tiny = f32::from_bits(77);
        let scaled = |arithmetic| run(&mirror(TEXT, "scaled", arithmetic), &[1.0, tiny, 1.0])[0];
        assert_eq!((scaled(Arithmetic::Written), scaled(Arithmetic::Flushed)), (tiny, 0.0));
        let granted = run(&mirror(TEXT, "early", Arithmetic::Granted(1)), &[2.0])[0];
        let ulps = (granted - 2.0_f32.sqrt()).abs() / f32::EPSILON;
        assert!(ulps > 0.0 && ulps <= 4.5, "{ulps}");
    }

    #[test]
    fn what_is_not_mirrored_is_named() {
        let text = "fn spin(x: f32) -> f32 { var y = x; loop { y = y * 0.5; if y < 1.0 { break; } } return y; }";
        let module = naga::front::wgsl::parse_str(text).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        let error = Mirror::new(&module, &info, "spin", Arithmetic::Written).unwrap_err();
        assert!(error.to_string().contains("Loop"), "{error}");
        let error = Mirror::new(&module, &info, "spun", Arithmetic::Written).unwrap_err();
        assert!(error.to_string().contains("it has: spin"), "{error}");
    }
}
