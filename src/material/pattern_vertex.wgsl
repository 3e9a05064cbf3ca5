// The vertex shader of pattern materials: the steps of Bevy's `mesh.wgsl`, plus the corner of the triangle and the
// position at rest.
// `Varyings` is `bevy_pbr::forward_io::VertexOutput` with the same locations, and three more from 10 on, so that fragment
// shaders take Bevy's struct and ours as separate parameters.

#import bevy_pbr::{
    mesh_bindings::mesh,
    mesh_functions,
    skinning,
    morph,
    forward_io::Vertex,
    view_transformations::position_world_to_clip,
}
#import bevy_field_patterns::pattern_corner::pattern_corner

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) world_normal: vec3<f32>,
#ifdef VERTEX_UVS_A
    @location(2) uv: vec2<f32>,
#endif
#ifdef VERTEX_UVS_B
    @location(3) uv_b: vec2<f32>,
#endif
#ifdef VERTEX_TANGENTS
    @location(4) world_tangent: vec4<f32>,
#endif
#ifdef VERTEX_COLORS
    @location(5) color: vec4<f32>,
#endif
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    @location(6) @interpolate(flat) instance_index: u32,
#endif
#ifdef VISIBILITY_RANGE_DITHER
    @location(7) @interpolate(flat) visibility_range_dither: i32,
#endif
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
    @location(12) rest: vec3<f32>,
}

#ifdef MORPH_TARGETS
// The instance index is passed along, as in Bevy, to work around a bug of wgpu on DX12 (naga issue 2416).
fn morphed(vertex_in: Vertex, instance_index: u32) -> Vertex {
    var vertex = vertex_in;
    let local = vertex.index - mesh[instance_index].first_vertex_index;
    let count = morph::layer_count(instance_index);
    for (var i = 0u; i < count; i++) {
        let weight = morph::weight_at(i, instance_index);
        if weight == 0.0 {
            continue;
        }
        vertex.position += weight * morph::morph_position(local, i, instance_index);
#ifdef VERTEX_NORMALS
        vertex.normal += weight * morph::morph_normal(local, i, instance_index);
#endif
#ifdef VERTEX_TANGENTS
        vertex.tangent += vec4(weight * morph::morph_tangent(local, i, instance_index), 0.0);
#endif
    }
    return vertex;
}
#endif

@vertex
fn vertex(
    vertex_in: Vertex,
#ifndef MORPH_TARGETS
    // With morph targets it is already a field of Vertex; a builtin may appear only once.
    @builtin(vertex_index) vertex_index: u32,
#endif
) -> Varyings {
    var out: Varyings;
    let instance = vertex_in.instance_index;
#ifdef MORPH_TARGETS
    let vertex_index = vertex_in.index;
    let vertex = morphed(vertex_in, instance);
#else
    let vertex = vertex_in;
#endif

    let mesh_world_from_local = mesh_functions::get_world_from_local(instance);
#ifdef SKINNED
    let world_from_local = skinning::skin_model(vertex.joint_indices, vertex.joint_weights, instance);
#else
    let world_from_local = mesh_world_from_local;
#endif

#ifdef VERTEX_NORMALS
#ifdef SKINNED
    out.world_normal = skinning::skin_normals(world_from_local, vertex.normal);
#else
    out.world_normal = mesh_functions::mesh_normal_local_to_world(vertex.normal, instance);
#endif
#endif
#ifdef VERTEX_POSITIONS
    out.world_position = mesh_functions::mesh_position_local_to_world(world_from_local, vec4(vertex.position, 1.0));
    out.position = position_world_to_clip(out.world_position.xyz);
#endif
#ifdef VERTEX_UVS_A
    out.uv = vertex.uv;
#endif
#ifdef VERTEX_UVS_B
    out.uv_b = vertex.uv_b;
#endif
#ifdef VERTEX_TANGENTS
    out.world_tangent = mesh_functions::mesh_tangent_local_to_world(world_from_local, vertex.tangent, instance);
#endif
#ifdef VERTEX_COLORS
    out.color = vertex.color;
#endif
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    out.instance_index = instance;
#endif
#ifdef VISIBILITY_RANGE_DITHER
    out.visibility_range_dither =
        mesh_functions::get_visibility_range_dither_level(instance, mesh_world_from_local[3]);
#endif

    let corner = pattern_corner(instance, vertex_index);
    out.pattern = corner.pattern;
    out.barycentrics = corner.barycentrics;
#ifdef VERTEX_POSITIONS
    // Before skin and morph targets.
    out.rest = vertex_in.position;
#endif
    return out;
}
