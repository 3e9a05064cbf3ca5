#define_import_path bevy_field_patterns::texture_patch

// The middle of the period cell that a fragment lies in, wherever on the mesh that is: by steps of Newton's method, each
// walked along the surface from triangle to triangle; the twin of `wave/shade_patch.rs`.
//
// goal    the phases of both waves at the middle, u and v [periods]
// edge c  of a triangle: from its corner c to the next

#import bevy_field_patterns::triangle_pair::WavePair
#import bevy_field_patterns::triangle_wave::{Wave, TINY, barycentric_gradients}
#import bevy_field_patterns::wave::{
    PatternPoint, load_corners, pattern_frame, sample_pair, surface, texture_point,
}

// Places looked at, one step of Newton's method after the other.
const PLACES: u32 = 7u;
// Triangles that one step may cross.
const MAX_CROSSED: u32 = 64u;
// Near enough to the middle [periods].
const CLOSE: f32 = 0.005;
// The triangle across an edge at the border.
const NONE: u32 = 0xFFFFFFFFu;

// Where the phases are those of the goal. Where a cell has no middle (at a branch), or none within a cell's diagonal is found,
// the point itself: its neighbours may find another one, which would be specks.
fn cell_middle(point: PatternPoint, goal: vec2<f32>) -> PatternPoint {
    var at = point;
    var begin = vec3(0.0);
    for (var place = 0u; place < PLACES; place++) {
        let pair = main_pair(at);
        if place == 0u {
            begin = pair.first.position;
        }
        if distance(pair.first.position, begin) > cell_diagonal(pair) {
            break;
        }
        let missing = goal - texture_point(pair).uv;
        let near = missing - round(missing);
        if max(abs(near.x), abs(near.y)) < CLOSE {
            return at;
        }
        at = walked(at, step_by(pair, near));
    }
    return point;
}

// [length]
fn cell_diagonal(pair: WavePair) -> f32 {
    return length(vec2(1.0) / max(vec2(pair.first.frequency, pair.second.frequency), vec2(TINY)));
}

// Both waves as the piece with the largest share sees them.
fn main_pair(point: PatternPoint) -> WavePair {
    let frame = pattern_frame(point);
    var best = sample_pair(frame, point, 0u);
    for (var piece = 1u; piece < frame.pieces; piece++) {
        let pair = sample_pair(frame, point, piece);
        if pair.weight > best.weight {
            best = pair;
        }
    }
    return best;
}

// The step in the triangle's plane by which the phases grow by `turns`; no longer than half a cell's diagonal. [length]
fn step_by(pair: WavePair, turns: vec2<f32>) -> vec3<f32> {
    let n = pair.first.normal;
    let u = pair.first.gradient;
    let v = pair.second.gradient;
    let along = cross(v, n);
    let across = cross(n, u);
    let area = dot(u, along);
    let wanted = (turns.x * along + turns.y * across) / select(area, TINY, abs(area) < TINY);
    return wanted * min(1.0, 0.5 * cell_diagonal(pair) / max(length(wanted), TINY));
}

// The point a step further along the surface; across an edge the step goes on at the angle at which it came. At the border
// it goes on in the plane of the last triangle.
fn walked(point: PatternPoint, step: vec3<f32>) -> PatternPoint {
    var at = point;
    var rest = step;
    for (var crossed = 0u; crossed < MAX_CROSSED; crossed++) {
        let corners = load_corners(at, 0u);
        let move_by = rest * barycentric_gradients(corners);
        let end = at.b + move_by;
        // The edge that is reached first lies opposite a corner whose weight falls to 0.
        var left = 3u;
        var share = 1.0;
        for (var m = 0u; m < 3u; m++) {
            if end[m] < 0.0 && move_by[m] < 0.0 {
                let t = clamp(at.b[m] / -move_by[m], 0.0, 1.0);
                if left == 3u || t < share {
                    left = m;
                    share = t;
                }
            }
        }
        if left == 3u {
            at.b = end;
            return at;
        }
        let edge = (left + 1u) % 3u;
        let next = across_edge(at, edge);
        if next == NONE {
            at.b = end;
            return at;
        }
        let on_edge = at.b + share * move_by;
        rest *= 1.0 - share;
        at = entered(at, next, edge, on_edge, &rest, corners.position);
    }
    return at;
}

fn across_edge(point: PatternPoint, edge: u32) -> u32 {
    let behind_triangles = surface[point.tag + 4u] + 3u * surface[point.tag + 1u];
    return surface[behind_triangles + 3u * point.triangle + edge];
}

fn vertex_of(point: PatternPoint, corner: u32) -> u32 {
    return surface[surface[point.tag + 4u] + 3u * point.triangle + corner];
}

// The same place on the edge in the next triangle, and the step bent into its plane.
fn entered(
    point: PatternPoint,
    next: u32,
    edge: u32,
    b: vec3<f32>,
    step: ptr<function, vec3<f32>>,
    v: mat3x3<f32>,
) -> PatternPoint {
    let other_end = (edge + 1u) % 3u;
    let first = vertex_of(point, edge);
    let second = vertex_of(point, other_end);
    var there = point;
    there.triangle = next;
    there.b = vec3(0.0);
    var third = 0u;
    for (var m = 0u; m < 3u; m++) {
        let vertex = vertex_of(there, m);
        if vertex == first {
            there.b[m] = b[edge];
        } else if vertex == second {
            there.b[m] = b[other_end];
        } else {
            third = m;
        }
    }
    there.b /= max(there.b.x + there.b.y + there.b.z, TINY);
    let line = v[other_end] - v[edge];
    let unit = line / max(length(line), TINY);
    let backwards = rejected(v[3u - edge - other_end] - v[edge], unit);
    let forwards = rejected(load_corners(there, 0u).position[third] - v[edge], unit);
    *step = dot(*step, unit) * unit - dot(*step, backwards) * forwards;
    return there;
}

// The unit direction of a vector's part that is perpendicular to `unit`.
fn rejected(vector: vec3<f32>, unit: vec3<f32>) -> vec3<f32> {
    let part = vector - dot(vector, unit) * unit;
    return part / max(length(part), TINY);
}
