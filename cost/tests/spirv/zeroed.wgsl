// Workgroup memory that is 0 at the start. naga's program writes that as stores; the module beside has it as the
// variable's initialiser instead (an edit by hand), as drivers with `shaderZeroInitializeWorkgroupMemory` take it.
@group(0) @binding(0) var<storage, read_write> data: array<u32>;
var<workgroup> shared_sums: array<u32, 256>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) at: vec3<u32>) { data[at.x] = shared_sums[data[at.x] & 255u]; }
