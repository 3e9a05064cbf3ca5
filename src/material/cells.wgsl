#define_import_path bevy_field_patterns::cells

// The cell under a fragment (Kratz et al. 2013, section 6). For any material that binds the two buffers of
// `cells/layout.rs` and is drawn with the vertex shader `pattern_vertex.wgsl`:
//
//     @fragment
//     fn fragment(in: VertexOutput,
//                 @location(10) @interpolate(flat) pattern: vec2<u32>, @location(12) rest: vec3<f32>) -> ... {
//         let cell = find_cell(cell_point(pattern, rest), 0.0);
//         let line = select(0.0, 1.0, cell.border < 0.01);
//
// tag          word offset of the entity's record in `cell_words`, its MeshTag; 0: no cells
// rest space   the mesh's own space, before skin, morph targets and transform [length]
// x            the point that is asked for, in rest space
// M            metric of a sample; major, minor, upright are the rows of its square root [1/length]
// seen         M^(1/2) (x - p): the point in a space where the sample's ellipse is the unit ball
// ring         the samples whose cells touch a sample's cell
//
// Do not import a function under the name of a field: naga_oil replaces both.

#import bevy_field_patterns::cell_layout

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage, read> cell_words: array<u32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage, read> cell_sites: array<vec4<f32>>;

// Rounds of the descent, each over one ring; as in `cells/twin.rs`.
const MAX_ROUNDS: u32 = 8u;
// Farther than any border [length].
const FAR: f32 = 1e30;
const TINY: f32 = 1e-30;

// A fragment's place on a mesh.
struct CellPoint {
    tag: u32,
    triangle: u32,
    // [length], and its derivatives along the screen [length/pixel].
    x: vec3<f32>,
    dx: vec3<f32>,
    dy: vec3<f32>,
    // Unit normal of the triangle, of either sign.
    normal: vec3<f32>,
}

struct Site {
    p: vec3<f32>,
    major: vec3<f32>,
    minor: vec3<f32>,
    upright: vec3<f32>,
    // Mean radius of the ellipse [length].
    radius: f32,
}

struct Cell {
    // There is a cell here.
    defined: bool,
    // Whose cell it is.
    sample: u32,
    site: Site,
    // In axes of the sample's ellipse: along the long one, the short one, the normal [1].
    seen: vec3<f32>,
    // Distance from the border to first order [length]; below 0 only where it is rounded.
    border: f32,
    // The way from the border inwards: unit, tangent to the surface; 0 without neighbours.
    inwards: vec3<f32>,
    // The sample behind the nearest border.
    neighbor: u32,
    // Where the descent began, and distances it has evaluated.
    seed: u32,
    evaluations: u32,
}

// Takes derivatives: call it first, in uniform control flow.
fn cell_point(pattern: vec2<u32>, rest: vec3<f32>) -> CellPoint {
    let dx = dpdx(rest);
    let dy = dpdy(rest);
    let normal = cross(dx, dy);
    return CellPoint(pattern.x, pattern.y, rest, dx, dy, normal / max(length(normal), TINY));
}

fn has_cells(point: CellPoint) -> bool {
    return point.tag != 0u
        && point.tag + cell_layout::MEAN_VALUE < arrayLength(&cell_words)
        && cell_words[point.tag + cell_layout::CHECK_WORD] == (cell_layout::CHECK ^ point.tag)
        && point.triangle < cell_words[point.tag + cell_layout::TRIANGLES];
}

fn load_site(site_base: u32, sample: u32) -> Site {
    let first = cell_sites[site_base + 3u * sample];
    let major = cell_sites[site_base + 3u * sample + 1u].xyz;
    let minor = cell_sites[site_base + 3u * sample + 2u].xyz;
    return Site(first.xyz, major, minor, first.w * cross(major, minor), first.w);
}

fn seen_from(site: Site, x: vec3<f32>) -> vec3<f32> {
    let r = x - site.p;
    return vec3(dot(site.major, r), dot(site.minor, r), dot(site.upright, r));
}

// Half the gradient of the squared distance, M (x - p). [1/length]
fn half_gradient(site: Site, seen: vec3<f32>) -> vec3<f32> {
    return site.major * seen.x + site.minor * seen.y + site.upright * seen.z;
}

// The nearest of the three seeds, each in its own metric.
fn nearest_seed(point: CellPoint) -> Cell {
    let site_base = cell_words[point.tag + cell_layout::SITE_BASE];
    let seeds = cell_words[point.tag + cell_layout::SEED_BASE] + 3u * point.triangle;
    var cell: Cell;
    cell.defined = true;
    for (var c = 0u; c < 3u; c++) {
        let sample = cell_words[seeds + c];
        if c > 0u && sample == cell.sample {
            continue;
        }
        let site = load_site(site_base, sample);
        let seen = seen_from(site, point.x);
        if c == 0u || dot(seen, seen) < dot(cell.seen, cell.seen) {
            cell.sample = sample;
            cell.site = site;
            cell.seen = seen;
        }
        cell.evaluations += 1u;
    }
    cell.seed = cell.sample;
    return cell;
}

// The cell of a point: from the nearest seed on to the nearest neighbour, as long as that is nearer. The last ring is
// that of the cell itself, so the border comes with it: where d_j^2 - d^2 = 0, to first order along the surface, for the
// nearest of all neighbours j. `rounding`, in mean radii of the cell, rounds its corners; 0 leaves them.
fn find_cell(point: CellPoint, rounding: f32) -> Cell {
    var cell: Cell;
    if !has_cells(point) {
        return cell;
    }
    cell = nearest_seed(point);
    let site_base = cell_words[point.tag + cell_layout::SITE_BASE];
    let offsets = cell_words[point.tag + cell_layout::OFFSET_BASE];
    let neighbors = cell_words[point.tag + cell_layout::NEIGHBOR_BASE];
    for (var turn = 0u; turn < MAX_ROUNDS; turn++) {
        let own = dot(cell.seen, cell.seen);
        let own_gradient = half_gradient(cell.site, cell.seen);
        var next = cell.sample;
        var nearest = own;
        var blend = 0.0;
        var blended = vec3(0.0);
        let softness = rounding * cell.site.radius;
        cell.border = FAR;
        let end = cell_words[offsets + cell.sample + 1u];
        for (var k = cell_words[offsets + cell.sample]; k < end; k++) {
            let sample = cell_words[neighbors + k];
            let site = load_site(site_base, sample);
            let seen = seen_from(site, point.x);
            let distance = dot(seen, seen);
            if distance < nearest {
                nearest = distance;
                next = sample;
            }
            let across = half_gradient(site, seen) - own_gradient;
            let along = across - point.normal * dot(point.normal, across);
            let steepness = inverseSqrt(max(dot(along, along), TINY));
            let border = 0.5 * (distance - own) * steepness;
            if softness > 0.0 {
                let weight = exp(-border / softness);
                blend += weight;
                blended += weight * steepness * along;
            }
            if border < cell.border {
                cell.border = border;
                cell.inwards = along;
                cell.neighbor = sample;
            }
            cell.evaluations += 1u;
        }
        if next == cell.sample {
            if softness > 0.0 && blend > 0.0 {
                cell.border = min(cell.border, -softness * log(blend));
                cell.inwards = blended;
            }
            break;
        }
        cell.sample = next;
        cell.site = load_site(site_base, next);
        cell.seen = seen_from(cell.site, point.x);
        cell.border = 0.0;
    }
    cell.inwards *= inverseSqrt(max(dot(cell.inwards, cell.inwards), TINY));
    return cell;
}

// The point in a square about the cell whose middle is the sample and whose sides lie `radius` ellipse radii from it
// (Eq. 11 and 12, corrected). u along the long axis.
fn cell_uv(cell: Cell, radius: f32) -> vec2<f32> {
    return 0.5 + 0.5 * cell.seen.xy / radius;
}

// How `cell_uv` moves with a step in rest space; for `textureSampleGrad`.
fn cell_uv_step(cell: Cell, step: vec3<f32>, radius: f32) -> vec2<f32> {
    return 0.5 * vec2(dot(cell.site.major, step), dot(cell.site.minor, step)) / radius;
}

// Mean radius of all samples' ellipses. [length]
fn mean_radius(tag: u32) -> f32 {
    return bitcast<f32>(cell_words[tag + cell_layout::RADIUS]);
}
