//! Static operations that an entry point reaches.
//!
//! A call counts what it calls, each time anew; a loop counts once; a branch counts all its sides. So the numbers
//! compare texts, not run times.

use std::collections::HashMap;
use std::ops::AddAssign;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, BinaryOperator, Block, Expression, Function, Handle, MathFunction, Statement,
    TypeInner,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Static operations reachable from an entry point: a call counts what it calls, a loop once, a branch all its sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Scalar operations: arithmetic, comparisons, selections, conversions and bit operations.
    pub arithmetic: u64,
    /// Scalar square roots, exponentials, logarithms, powers and trigonometric functions.
    pub transcendental: u64,
    /// Texels loaded without a sampler.
    pub texture_loads: u64,
    /// Samples taken through a sampler.
    pub texture_samples: u64,
    /// Texels stored.
    pub texture_stores: u64,
    /// Loads from uniform and storage buffers.
    pub buffer_reads: u64,
    /// Bytes of those loads.
    pub buffer_read_bytes: u64,
    /// Stores to storage buffers.
    pub buffer_writes: u64,
    /// Bytes of those stores.
    pub buffer_write_bytes: u64,
    /// Loads from workgroup memory.
    pub workgroup_reads: u64,
    /// Stores to workgroup memory.
    pub workgroup_writes: u64,
    /// Atomic operations.
    pub atomics: u64,
    /// Barriers.
    pub barriers: u64,
    /// `if` and `switch`.
    pub branches: u64,
    /// Loops.
    pub loops: u64,
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        self.arithmetic += other.arithmetic;
        self.transcendental += other.transcendental;
        self.texture_loads += other.texture_loads;
        self.texture_samples += other.texture_samples;
        self.texture_stores += other.texture_stores;
        self.buffer_reads += other.buffer_reads;
        self.buffer_read_bytes += other.buffer_read_bytes;
        self.buffer_writes += other.buffer_writes;
        self.buffer_write_bytes += other.buffer_write_bytes;
        self.workgroup_reads += other.workgroup_reads;
        self.workgroup_writes += other.workgroup_writes;
        self.atomics += other.atomics;
        self.barriers += other.barriers;
        self.branches += other.branches;
        self.loops += other.loops;
    }
}

/// The cost of the entry point at `index`.
pub(super) fn of(module: &naga::Module, info: &ModuleInfo, index: usize) -> Cost {
    let mut counted = HashMap::new();
    // naga's functions call only functions declared before them.
    for (handle, function) in module.functions.iter() {
        let cost = Counter { module, function, info: &info[handle], counted: &counted }.function();
        counted.insert(handle, cost);
    }
    let function = &module.entry_points[index].function;
    Counter { module, function, info: info.get_entry_point(index), counted: &counted }.function()
}

struct Counter<'a> {
    module: &'a naga::Module,
    function: &'a Function,
    info: &'a FunctionInfo,
    counted: &'a HashMap<Handle<Function>, Cost>,
}

impl Counter<'_> {
    fn function(&self) -> Cost {
        let mut cost = Cost::default();
        self.block(&self.function.body, &mut cost);
        cost
    }

    fn block(&self, block: &Block, cost: &mut Cost) {
        for statement in block {
            self.statement(statement, cost);
        }
    }

    fn statement(&self, statement: &Statement, cost: &mut Cost) {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    self.expression(expression, cost);
                }
            }
            Statement::Block(block) => self.block(block, cost),
            Statement::If { accept, reject, .. } => {
                cost.branches += 1;
                self.block(accept, cost);
                self.block(reject, cost);
            }
            Statement::Switch { cases, .. } => {
                cost.branches += 1;
                for case in cases {
                    self.block(&case.body, cost);
                }
            }
            Statement::Loop { body, continuing, .. } => {
                cost.loops += 1;
                self.block(body, cost);
                self.block(continuing, cost);
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => cost.barriers += 1,
            Statement::Store { pointer, value } => match self.space(*pointer) {
                Some(AddressSpace::Storage { .. }) => {
                    cost.buffer_writes += 1;
                    cost.buffer_write_bytes += self.bytes(*value);
                }
                Some(AddressSpace::WorkGroup) => cost.workgroup_writes += 1,
                _ => {}
            },
            Statement::WorkGroupUniformLoad { .. } => {
                // It stands between two barriers.
                cost.barriers += 2;
                cost.workgroup_reads += 1;
            }
            Statement::ImageStore { .. } => cost.texture_stores += 1,
            Statement::Atomic { .. } | Statement::ImageAtomic { .. } => cost.atomics += 1,
            Statement::Call { function, .. } => {
                *cost += self.counted.get(function).copied().unwrap_or_default();
            }
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. } => cost.arithmetic += 1,
            _ => {}
        }
    }

    fn expression(&self, handle: Handle<Expression>, cost: &mut Cost) {
        match &self.function.expressions[handle] {
            Expression::Load { pointer } => match self.space(*pointer) {
                Some(AddressSpace::Storage { .. } | AddressSpace::Uniform) => {
                    cost.buffer_reads += 1;
                    cost.buffer_read_bytes += self.bytes(handle);
                }
                Some(AddressSpace::WorkGroup) => cost.workgroup_reads += 1,
                _ => {}
            },
            Expression::ImageSample { .. } => cost.texture_samples += 1,
            Expression::ImageLoad { .. } => cost.texture_loads += 1,
            Expression::Binary { op: BinaryOperator::Multiply, left, right } => {
                cost.arithmetic +=
                    self.product(*left, *right).unwrap_or_else(|| self.scalars(handle));
            }
            Expression::Unary { .. }
            | Expression::Binary { .. }
            | Expression::Select { .. }
            | Expression::Derivative { .. }
            | Expression::As { .. } => cost.arithmetic += self.scalars(handle),
            Expression::Relational { argument, .. } => cost.arithmetic += self.scalars(*argument),
            Expression::Math { fun, arg, .. } => self.math(handle, *fun, *arg, cost),
            _ => {}
        }
    }

    fn math(
        &self,
        handle: Handle<Expression>,
        function: MathFunction,
        argument: Handle<Expression>,
        cost: &mut Cost,
    ) {
        use MathFunction as Math;
        // A reduction works on the scalars of its argument, anything else on those of its result.
        let scalars = self.scalars(handle).max(self.scalars(argument));
        match function {
            Math::Cos
            | Math::Cosh
            | Math::Sin
            | Math::Sinh
            | Math::Tan
            | Math::Tanh
            | Math::Acos
            | Math::Asin
            | Math::Atan
            | Math::Atan2
            | Math::Asinh
            | Math::Acosh
            | Math::Atanh
            | Math::Exp
            | Math::Exp2
            | Math::Log
            | Math::Log2
            | Math::Pow
            | Math::Sqrt
            | Math::InverseSqrt => cost.transcendental += scalars,
            Math::Length | Math::Distance | Math::Normalize => {
                cost.transcendental += 1;
                cost.arithmetic += scalars;
            }
            _ => cost.arithmetic += scalars,
        }
    }

    /// Multiplications of a product with a matrix.
    fn product(&self, left: Handle<Expression>, right: Handle<Expression>) -> Option<u64> {
        let matrix = |handle| match *self.inner(handle) {
            TypeInner::Matrix { columns, rows, .. } => Some((columns as u64, rows as u64)),
            _ => None,
        };
        let vector = |handle| matches!(self.inner(handle), TypeInner::Vector { .. });
        match (matrix(left), matrix(right)) {
            (Some((inner, rows)), Some((columns, _))) => Some(inner * rows * columns),
            (Some((columns, rows)), None) if vector(right) => Some(columns * rows),
            (None, Some((columns, rows))) if vector(left) => Some(columns * rows),
            _ => None,
        }
    }

    fn inner(&self, handle: Handle<Expression>) -> &TypeInner {
        self.info[handle].ty.inner_with(&self.module.types)
    }

    fn scalars(&self, handle: Handle<Expression>) -> u64 {
        match *self.inner(handle) {
            TypeInner::Vector { size, .. } => size as u64,
            TypeInner::Matrix { columns, rows, .. } => columns as u64 * rows as u64,
            _ => 1,
        }
    }

    fn bytes(&self, handle: Handle<Expression>) -> u64 {
        let size = self.inner(handle).try_size(self.module.to_ctx());
        size.map_or(0, u64::from)
    }

    /// Where a pointer points.
    fn space(&self, pointer: Handle<Expression>) -> Option<AddressSpace> {
        self.inner(pointer).pointer_space()
    }
}

#[cfg(test)]
mod tests {
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    fn cost(body: &str) -> Cost {
        let text = format!(
            "@group(0) @binding(0) var<storage, read> a: array<vec4<f32>>;
            @group(0) @binding(1) var<storage, read_write> b: array<vec4<f32>>;
            @group(0) @binding(2) var t: texture_2d<f32>;
            var<workgroup> tile: array<f32, 4>;
            fn twice(x: vec4<f32>) -> vec4<f32> {{ return x * 2.0 + exp(x); }}
            @compute @workgroup_size(1) fn main(@builtin(local_invocation_index) i: u32) {{ {body} }}"
        );
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        of(&module, &info, 0)
    }

    #[test]
    fn memory_is_counted_where_it_is_touched() {
        let copied = Cost {
            buffer_reads: 1,
            buffer_read_bytes: 16,
            buffer_writes: 1,
            buffer_write_bytes: 16,
            ..Cost::default()
        };
        assert_eq!(cost("b[i] = a[i];"), copied);
        let component = Cost {
            buffer_read_bytes: 4,
            workgroup_writes: 1,
            buffer_writes: 0,
            buffer_write_bytes: 0,
            ..copied
        };
        assert_eq!(cost("tile[i] = a[i].x;"), component);
    }

    #[test]
    fn a_call_counts_what_it_calls_each_time() {
        let once = cost("b[i] = twice(a[i]);");
        let again = cost("b[i] = twice(twice(a[i]));");
        assert_eq!((once.arithmetic, once.transcendental), (8, 4));
        assert_eq!((again.arithmetic, again.transcendental), (16, 8));
    }

    #[test]
    fn a_loop_counts_once_and_a_branch_counts_all_its_sides() {
        let looped = cost("for (var k = 0u; k < 9u; k += 1u) { tile[k % 4u] = 1.0; }");
        assert_eq!((looped.loops, looped.workgroup_writes), (1, 1));
        let branched =
            cost("if i > 1u { tile[0] = 1.0; } else { tile[1] = 1.0; workgroupBarrier(); }");
        assert_eq!((branched.branches, branched.workgroup_writes, branched.barriers), (1, 2, 1));
    }

    #[test]
    fn products_and_reductions_count_their_scalars() {
        let cost = |body: &str| cost(body).arithmetic;
        assert_eq!(cost("tile[0] = dot(a[0], a[1]);"), 4);
        assert_eq!(cost("b[0] = mat4x4<f32>(a[0], a[1], a[2], a[3]) * a[4];"), 16);
        assert_eq!(cost("b[0] = a[0] * a[1];"), 4);
    }
}
