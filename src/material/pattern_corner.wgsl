#define_import_path bevy_field_patterns::pattern_corner

// Which corner of which triangle a vertex is. The mesh drawn has no indices: three vertices in a row are a triangle.
//
// pattern       (tag, triangle), the same at all three corners
// barycentrics  weights of corners 0 and 1 at this vertex

#import bevy_pbr::{mesh_bindings::mesh, mesh_functions}

struct PatternCorner {
    pattern: vec2<u32>,
    barycentrics: vec2<f32>,
}

fn pattern_corner(instance_index: u32, vertex_index: u32) -> PatternCorner {
    // Bevy keeps many meshes in one buffer: count from this mesh's first vertex.
    let local = vertex_index - mesh[instance_index].first_vertex_index;
    let corner = local % 3u;
    return PatternCorner(
        vec2(mesh_functions::get_tag(instance_index), local / 3u),
        vec2(select(0.0, 1.0, corner == 0u), select(0.0, 1.0, corner == 1u)),
    );
}
