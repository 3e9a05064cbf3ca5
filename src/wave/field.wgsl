// The field passes: directions of an entity, projected from its axis (the twin of `tangent.rs`) or given by the processor.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::passes::{surface, geometry, edges, load_item, load_level, WORKGROUP}
#import bevy_field_patterns::tangent::{project_tangent, store_direction, store_turned}

fn project_vertex(record: u32, i: u32) {
    let n = geometry[surface[record + 5u] + 2u * i + 1u].xyz;
    let frequency = bitcast<f32>(surface[record + 10u]);
    let axis = bitcast<vec3<f32>>(vec3(surface[record + 12u], surface[record + 13u], surface[record + 14u]));
    store_turned(record, i, project_tangent(axis, n), n, frequency);
}

@compute @workgroup_size(64)
fn project_axis(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        project_vertex(item.x, i);
    }
}

// The processor lays (d, f) of each vertex down where the edge constants will be, which follow from them.
@compute @workgroup_size(64)
fn take_directions(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let given = load_level(item.x, 0u).edge_base;
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let last = edges[given + 2u * i + 1u];
        store_direction(item.x, i, vec3(edges[given + 2u * i], last.x), last.y);
    }
}
