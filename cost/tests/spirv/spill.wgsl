// Needs private memory: an array that is too large for registers and is indexed by data.
@group(0) @binding(0) var<storage, read_write> data: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    var table: array<u32, 2048>;
    for (var i = 0u; i < 2048u; i++) { table[i & 2047u] = data[i ^ at.x]; }
    var sum = 0u;
    for (var i = 0u; i < 64u; i++) { sum += table[data[i] & 2047u]; }
    data[at.x] = sum;
}
