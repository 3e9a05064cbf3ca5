#define_import_path bevy_field_patterns::deform

// What carries vectors that were given at rest to where the surface is: the twin of `deformations` in `twin.rs`. Glossary
// in `passes.wgsl`; words of a pose in `layout.rs`.

#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::parameters::linear_map
#import bevy_field_patterns::passes::{surface, geometry, load_level}
#import bevy_field_patterns::tangent::any_tangent

// Added to the matrix of a vertex's edges, which is divided by its trace.
const RIDGE: f32 = 1e-6;

fn outer(a: vec3<f32>, b: vec3<f32>) -> mat3x3<f32> {
    return mat3x3(a * b.x, a * b.y, a * b.z);
}

// What carries the vectors of an entity.
struct Carrier {
    is_posed: bool,
    // Positions and normals as they are, and at rest.
    base: u32,
    rest: u32,
    level: LevelRecord,
    // Of a surface that is not posed.
    linear: mat3x3<f32>,
}

fn load_carrier(record: u32) -> Carrier {
    let pose = surface[record + 26u];
    let rest = surface[pose + 5u];
    return Carrier(pose != 0u, surface[record + 5u], rest, load_level(record, 0u), linear_map(record));
}

// Of a posed surface: the map that best explains where the edges to the neighbours have gone, and takes the normal at rest
// to the normal now.
fn deformation(carrier: Carrier, i: u32) -> mat3x3<f32> {
    let base = carrier.base;
    let rest = carrier.rest;
    let level = carrier.level;
    let v = geometry[rest + 2u * i];
    let n = geometry[rest + 2u * i + 1u].xyz;
    let v_now = geometry[base + 2u * i].xyz;
    let n_now = geometry[base + 2u * i + 1u].xyz;
    let x = any_tangent(n);
    let y = cross(n, x);
    let scale = inverseSqrt(max(v.w, 1.17549435e-38));
    var aa = 0.0;
    var ab = 0.0;
    var bb = 0.0;
    // Sums of the edges as they are now, times the tangential coordinates they had.
    var along_x = vec3(0.0);
    var along_y = vec3(0.0);
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let e = (geometry[rest + 2u * j].xyz - v.xyz) * scale;
        let moved = (geometry[base + 2u * j].xyz - v_now) * scale;
        let a = dot(e, x);
        let b = dot(e, y);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        along_x += a * moved;
        along_y += b * moved;
    }
    let trace = aa + bb;
    if !(trace > 0.0) {
        return mat3x3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    }
    aa = aa / trace + RIDGE;
    ab = ab / trace;
    bb = bb / trace + RIDGE;
    let determinant = (aa * bb - ab * ab) * trace;
    let x_now = (bb * along_x - ab * along_y) / determinant;
    let y_now = (aa * along_y - ab * along_x) / determinant;
    // Across the surface as much as along it in the mean.
    let across = sqrt(length(cross(x_now, y_now)));
    return outer(x_now, x) + outer(y_now, y) + outer(across * n_now, n);
}

// What carries vectors given at vertex i into the pattern's space.
fn carrying_map(carrier: Carrier, i: u32) -> mat3x3<f32> {
    if !carrier.is_posed {
        return carrier.linear;
    }
    return deformation(carrier, i);
}
