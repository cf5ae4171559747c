//! Static operations that an entry point reaches: those outside loops, and those of each turn of each loop.
//!
//! A call counts what it calls, each time anew; a branch counts all its sides. How often a loop turns is not known here,
//! so the numbers compare texts; times a number of turns that the reader knows they compare work, not run times.

use std::collections::HashMap;
use std::ops::AddAssign;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, BinaryOperator, Block, Expression, Function, Handle, MathFunction, Statement,
    TypeInner,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Static operations reachable from an entry point: a call counts what it calls, a branch all its sides.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cost {
    /// Outside all loops: once for an invocation.
    pub once: Operations,
    /// Its loops, each followed by those inside it: a loop stands inside the last one before it of smaller depth. A
    /// function that is called twice has its loops here twice.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<LoopCost>,
}

/// What one loop does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoopCost {
    /// The function whose text has the loop.
    pub function: String,
    /// Number of loops around it and itself, those around calls of its function included: at least 1.
    pub depth: u32,
    /// Each turn, its condition included, without the loops inside it.
    pub turn: Operations,
}

/// Numbers of operations. One that is absent is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Operations {
    /// Scalar operations: arithmetic, comparisons, selections, conversions and bit operations.
    #[serde(skip_serializing_if = "is_zero")]
    pub arithmetic: u64,
    /// Scalar square roots, exponentials, logarithms, powers and trigonometric functions.
    #[serde(skip_serializing_if = "is_zero")]
    pub transcendental: u64,
    /// Texels loaded without a sampler.
    #[serde(skip_serializing_if = "is_zero")]
    pub texture_loads: u64,
    /// Samples taken through a sampler.
    #[serde(skip_serializing_if = "is_zero")]
    pub texture_samples: u64,
    /// Texels stored.
    #[serde(skip_serializing_if = "is_zero")]
    pub texture_stores: u64,
    /// Loads from uniform and storage buffers.
    #[serde(skip_serializing_if = "is_zero")]
    pub buffer_reads: u64,
    /// Bytes of those loads.
    #[serde(skip_serializing_if = "is_zero")]
    pub buffer_read_bytes: u64,
    /// Stores to storage buffers.
    #[serde(skip_serializing_if = "is_zero")]
    pub buffer_writes: u64,
    /// Bytes of those stores.
    #[serde(skip_serializing_if = "is_zero")]
    pub buffer_write_bytes: u64,
    /// Loads from workgroup memory.
    #[serde(skip_serializing_if = "is_zero")]
    pub workgroup_reads: u64,
    /// Stores to workgroup memory.
    #[serde(skip_serializing_if = "is_zero")]
    pub workgroup_writes: u64,
    /// Atomic operations.
    #[serde(skip_serializing_if = "is_zero")]
    pub atomics: u64,
    /// Barriers.
    #[serde(skip_serializing_if = "is_zero")]
    pub barriers: u64,
    /// `if` and `switch`; the condition of a loop is one.
    #[serde(skip_serializing_if = "is_zero")]
    pub branches: u64,
}

impl Cost {
    /// All operations of the text, each loop once.
    #[must_use]
    pub fn text(&self) -> Operations {
        let mut sum = self.once;
        self.loops.iter().for_each(|one| sum += one.turn);
        sum
    }

    /// The loops without a loop inside.
    pub fn innermost(&self) -> impl Iterator<Item = &LoopCost> {
        let next = self.loops.iter().skip(1).map(|next| next.depth).chain([0]);
        let innermost = self.loops.iter().zip(next).filter(|(one, next)| *next <= one.depth);
        innermost.map(|(one, _)| one)
    }
}

impl Operations {
    /// Scalar operations of every kind.
    #[must_use]
    pub fn scalars(&self) -> u64 {
        self.arithmetic + self.transcendental
    }
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

impl AddAssign for Operations {
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
    }
}

/// The cost of the entry point at `index`.
pub(super) fn of(module: &naga::Module, info: &ModuleInfo, index: usize) -> Cost {
    let mut counted = HashMap::new();
    // naga's functions call only functions declared before them.
    for (handle, function) in module.functions.iter() {
        let cost = Counter::new(module, function, &info[handle], &counted).count();
        counted.insert(handle, cost);
    }
    let entry_point = &module.entry_points[index];
    let info = info.get_entry_point(index);
    let counter = Counter::new(module, &entry_point.function, info, &counted);
    Counter { name: &entry_point.name, ..counter }.count()
}

struct Counter<'a> {
    module: &'a naga::Module,
    function: &'a Function,
    name: &'a str,
    info: &'a FunctionInfo,
    counted: &'a HashMap<Handle<Function>, Cost>,
    cost: Cost,
    /// The innermost loop at this place of the text, among those of `cost`.
    inside: Option<usize>,
}

impl<'a> Counter<'a> {
    fn new(
        module: &'a naga::Module,
        function: &'a Function,
        info: &'a FunctionInfo,
        counted: &'a HashMap<Handle<Function>, Cost>,
    ) -> Self {
        let name = function.name.as_deref().unwrap_or_default();
        Self { module, function, name, info, counted, cost: Cost::default(), inside: None }
    }

    fn count(mut self) -> Cost {
        self.block(&self.function.body);
        self.cost
    }

    /// The operations that this place of the text adds to.
    fn here(&mut self) -> &mut Operations {
        match self.inside {
            Some(at) => &mut self.cost.loops[at].turn,
            None => &mut self.cost.once,
        }
    }

    fn depth(&self) -> u32 {
        self.inside.map_or(0, |at| self.cost.loops[at].depth)
    }

    fn block(&mut self, block: &Block) {
        for statement in block {
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    self.expression(expression);
                }
            }
            Statement::Block(block) => self.block(block),
            Statement::If { accept, reject, .. } => {
                self.here().branches += 1;
                self.block(accept);
                self.block(reject);
            }
            Statement::Switch { cases, .. } => {
                self.here().branches += 1;
                for case in cases {
                    self.block(&case.body);
                }
            }
            Statement::Loop { body, continuing, .. } => {
                let around = self.inside;
                let (function, depth) = (self.name.to_owned(), self.depth() + 1);
                self.inside = Some(self.cost.loops.len());
                self.cost.loops.push(LoopCost { function, depth, turn: Operations::default() });
                self.block(body);
                self.block(continuing);
                self.inside = around;
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => self.here().barriers += 1,
            Statement::Store { pointer, value } => match self.space(*pointer) {
                Some(AddressSpace::Storage { .. }) => {
                    let bytes = self.bytes(*value);
                    self.here().buffer_writes += 1;
                    self.here().buffer_write_bytes += bytes;
                }
                Some(AddressSpace::WorkGroup) => self.here().workgroup_writes += 1,
                _ => {}
            },
            Statement::WorkGroupUniformLoad { .. } => {
                // It stands between two barriers.
                self.here().barriers += 2;
                self.here().workgroup_reads += 1;
            }
            Statement::ImageStore { .. } => self.here().texture_stores += 1,
            Statement::Atomic { .. } | Statement::ImageAtomic { .. } => self.here().atomics += 1,
            Statement::Call { function, .. } => self.call(*function),
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. } => self.here().arithmetic += 1,
            _ => {}
        }
    }

    fn call(&mut self, function: Handle<Function>) {
        let counted = self.counted;
        if let Some(called) = counted.get(&function) {
            *self.here() += called.once;
            let around = self.depth();
            let loops = called.loops.iter();
            let deeper = loops.map(|one| LoopCost { depth: around + one.depth, ..one.clone() });
            self.cost.loops.extend(deeper);
        }
    }

    fn expression(&mut self, handle: Handle<Expression>) {
        match &self.function.expressions[handle] {
            Expression::Load { pointer } => match self.space(*pointer) {
                Some(AddressSpace::Storage { .. } | AddressSpace::Uniform) => {
                    let bytes = self.bytes(handle);
                    self.here().buffer_reads += 1;
                    self.here().buffer_read_bytes += bytes;
                }
                Some(AddressSpace::WorkGroup) => self.here().workgroup_reads += 1,
                _ => {}
            },
            Expression::ImageSample { .. } => self.here().texture_samples += 1,
            Expression::ImageLoad { .. } => self.here().texture_loads += 1,
            Expression::Binary { op: BinaryOperator::Multiply, left, right } => {
                let product = self.product(*left, *right);
                let scalars = product.unwrap_or_else(|| self.scalars(handle));
                self.here().arithmetic += scalars;
            }
            Expression::Unary { .. }
            | Expression::Binary { .. }
            | Expression::Select { .. }
            | Expression::Derivative { .. }
            | Expression::As { .. } => {
                let scalars = self.scalars(handle);
                self.here().arithmetic += scalars;
            }
            Expression::Relational { argument, .. } => {
                let scalars = self.scalars(*argument);
                self.here().arithmetic += scalars;
            }
            Expression::Math { fun, arg, .. } => self.math(handle, *fun, *arg),
            _ => {}
        }
    }

    fn math(
        &mut self,
        handle: Handle<Expression>,
        function: MathFunction,
        argument: Handle<Expression>,
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
            | Math::InverseSqrt => self.here().transcendental += scalars,
            Math::Length | Math::Distance | Math::Normalize => {
                self.here().transcendental += 1;
                self.here().arithmetic += scalars;
            }
            _ => self.here().arithmetic += scalars,
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
            fn fill() {{ tile[0] = 1.0; loop {{ tile[1] = 1.0; break; }} }}
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
        let copied = Operations {
            buffer_reads: 1,
            buffer_read_bytes: 16,
            buffer_writes: 1,
            buffer_write_bytes: 16,
            ..Operations::default()
        };
        assert_eq!(cost("b[i] = a[i];"), Cost { once: copied, loops: Vec::new() });
        let component = Operations {
            buffer_read_bytes: 4,
            workgroup_writes: 1,
            buffer_writes: 0,
            buffer_write_bytes: 0,
            ..copied
        };
        assert_eq!(cost("tile[i] = a[i].x;").once, component);
    }

    #[test]
    fn a_call_counts_what_it_calls_each_time() {
        let once = cost("b[i] = twice(a[i]);").once;
        let again = cost("b[i] = twice(twice(a[i]));").once;
        assert_eq!((once.arithmetic, once.transcendental), (8, 4));
        assert_eq!((again.arithmetic, again.transcendental), (16, 8));
    }

    #[test]
    fn a_branch_counts_all_its_sides() {
        let branched =
            cost("if i > 1u { tile[0] = 1.0; } else { tile[1] = 1.0; workgroupBarrier(); }").once;
        assert_eq!((branched.branches, branched.workgroup_writes, branched.barriers), (1, 2, 1));
    }

    /// Function, depth and stores to workgroup memory of each loop.
    fn loops(cost: &Cost) -> Vec<(&str, u32, u64)> {
        let loops = cost.loops.iter();
        loops.map(|one| (one.function.as_str(), one.depth, one.turn.workgroup_writes)).collect()
    }

    #[test]
    fn what_runs_each_turn_is_apart_from_what_runs_once() {
        let looped = cost(
            "tile[0] = 1.0; loop { tile[1] = exp(tile[2]); if tile[1] > 9.0 { break; } } tile[3] = 2.0;",
        );
        let turn = Operations {
            arithmetic: 1,
            transcendental: 1,
            workgroup_reads: 2,
            workgroup_writes: 1,
            branches: 1,
            ..Operations::default()
        };
        let expected = LoopCost { function: "main".to_owned(), depth: 1, turn };
        assert_eq!(looped.loops, [expected]);
        let once = Operations { workgroup_writes: 2, ..Operations::default() };
        assert_eq!(looped.once, once);
        // Negative control: the same text without the loop runs once.
        let straight =
            cost("tile[0] = 1.0; tile[1] = exp(tile[2]); if tile[1] > 9.0 { } tile[3] = 2.0;");
        assert_eq!((straight.once, straight.loops.len()), (looped.text(), 0));
    }

    #[test]
    fn the_condition_and_the_step_of_a_loop_run_each_turn() {
        let looped = cost("for (var k = 0u; k < 9u; k += 1u) { }");
        let turn = looped.loops[0].turn;
        // The comparison, whose negation leaves the loop, and the sum.
        assert_eq!((turn.branches, turn.scalars(), looped.once.scalars()), (1, 2, 0));
    }

    #[test]
    fn nested_loops_are_a_list_with_depths_whoever_calls_them() {
        let nested = cost(
            "for (var k = 0u; k < 9u; k += 1u) {
                tile[0] = 1.0;
                for (var l = 0u; l < k; l += 1u) { tile[1] = 1.0; tile[2] = 1.0; }
                fill();
                tile[3] = 1.0;
            }
            fill();",
        );
        // What a called function does once it does each turn of the loop around the call.
        let expected = [("main", 1, 3), ("main", 2, 2), ("fill", 2, 1), ("fill", 1, 1)];
        assert_eq!(loops(&nested), expected);
        let innermost: Vec<_> = nested.innermost().map(|one| one.depth).collect();
        assert_eq!(innermost, [2, 2, 1]);
        assert_eq!(nested.once.workgroup_writes, 1);
        assert_eq!(nested.text().workgroup_writes, 8);
    }

    #[test]
    fn what_is_zero_is_not_written_and_read_as_zero() {
        let cost = cost("tile[0] = 1.0; loop { tile[1] = 1.0; break; }");
        let text = serde_json::to_string(&cost).unwrap();
        let expected = r#"{"once":{"workgroup_writes":1},"loops":[{"function":"main","depth":1,"turn":{"workgroup_writes":1}}]}"#;
        assert_eq!(text, expected);
        assert_eq!(serde_json::from_str::<Cost>(&text).unwrap(), cost);
        // Negative control: a number of another name is refused.
        let other = text.replace("workgroup_writes", "workgroup_write");
        assert!(serde_json::from_str::<Cost>(&other).is_err());
    }

    #[test]
    fn products_and_reductions_count_their_scalars() {
        let cost = |body: &str| cost(body).once.arithmetic;
        assert_eq!(cost("tile[0] = dot(a[0], a[1]);"), 4);
        assert_eq!(cost("b[0] = mat4x4<f32>(a[0], a[1], a[2], a[3]) * a[4];"), 16);
        assert_eq!(cost("b[0] = a[0] * a[1];"), 4);
    }
}
