// A line on every crest of the wave, over a colour that tells the direction of the field.

#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#import bevy_pbr::mesh_view_bindings::view
#import bevy_field_patterns::wave::{pattern_point, sample_wave}
#import bevy_field_patterns::coverage::pulse_coverage

// Colour of a line, and its share of a period.
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> line: vec4<f32>;

@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> FragmentOutput {
    let wave = sample_wave(pattern_point(pattern, barycentrics));
    let to_eye = normalize(view.world_position - in.world_position.xyz);
    let facing = abs(dot(normalize(in.world_normal), to_eye));
    // d and -d are the same for a line field, and so are their colours.
    let ground = mix(vec3(0.02, 0.03, 0.08), wave.direction * wave.direction, 0.6) * facing;
    // Phase 1/4 is a crest; the pixel's sides keep far lines from flickering.
    let turns = atan2(wave.phasor.y, wave.phasor.x) / 6.2831853 - 0.25;
    let crest = pulse_coverage(turns, line.w, wave.sides).value * wave.confidence;
    var out: FragmentOutput;
    out.color = vec4(mix(ground, line.rgb * (0.4 + 0.6 * facing), crest), 1.0);
    return out;
}
