// No loop, and a function of its own, so that a file that ends between functions can be tried.
@group(0) @binding(0) var<storage, read_write> data: array<u32>;
fn next(value: u32) -> u32 { return value + 1u; }
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) at: vec3<u32>) { data[at.x] = next(data[at.x]); }
