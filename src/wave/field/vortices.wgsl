#define_import_path bevy_field_patterns::vortices

// Flow around vortex cores; the twin of `vortices.rs`, where the formula is.

#import bevy_field_patterns::parameters::{number, vector, parameters, CORES, BASE, FIRST_CORE, CORE_WORDS}
#import bevy_field_patterns::passes::surface

// The velocity at p, where the normal is n.
fn vortex_flow(record: u32, p: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let at = parameters(record);
    var flow = vector(at + BASE);
    let count = surface[at + CORES];
    for (var c = 0u; c < count; c++) {
        let core = at + FIRST_CORE + CORE_WORDS * c;
        let r = (p - vector(core)) / number(core + 3u);
        var h = 2.0 / (1.0 + dot(r, r));
        if surface[core + 5u] == 1u {
            h = exp(0.5 - 0.5 * dot(r, r));
        }
        flow += number(core + 4u) * h * cross(n, r);
    }
    return flow;
}
