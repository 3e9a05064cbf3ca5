#define_import_path bevy_field_patterns::noise

// Random numbers and smooth noise. Pure functions.

// A scrambled word (PCG, O'Neill 2014).
fn scrambled(word: u32) -> u32 {
    let state = word * 747796405u + 2891336453u;
    let mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (mixed >> 22u) ^ mixed;
}

// 0 to 1, without 1.
fn unit_random(word: u32) -> f32 {
    return f32(scrambled(word) >> 8u) / 16777216.0;
}

// Four numbers from -1 to 1 for a lattice point.
fn lattice(p: vec3<i32>) -> vec4<f32> {
    let q = bitcast<vec3<u32>>(p);
    let a = scrambled(q.x + scrambled(q.y + scrambled(q.z)));
    let b = scrambled(a);
    return 2.0 * vec4(f32(a & 0xffffu), f32(a >> 16u), f32(b >> 16u), f32(b & 0xffffu)) / 65535.0 - 1.0;
}

// Four numbers that vary smoothly, over about 1 in space: value noise, each -1 to 1, twice differentiable.
fn smooth_noise(p: vec3<f32>) -> vec4<f32> {
    let cell = floor(p);
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let i = vec3<i32>(cell);
    var sum = vec4(0.0);
    for (var k = 0; k < 8; k++) {
        let corner = vec3(k & 1, (k >> 1u) & 1, k >> 2u);
        let share = mix(1.0 - w, w, vec3<f32>(corner));
        sum += share.x * share.y * share.z * lattice(i + corner);
    }
    return sum;
}

// A vector that varies smoothly, over about 1 in space.
fn vector_noise(p: vec3<f32>) -> vec3<f32> {
    return smooth_noise(p).xyz;
}
