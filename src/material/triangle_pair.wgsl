#define_import_path bevy_field_patterns::triangle_pair

// Two waves inside a triangle, in one frame (section 3.6 of Lichtenberg et al. 2018); the twin of `wave/shade_pair.rs`.
// Pure functions.
//
// first, second  the waves along d and along n x d
// k              quarter turns that bring a corner's frame nearest to another's
// closed         the turns around the triangle undo each other; otherwise no frame fits all three corners
// piece          a closed triangle is one piece. Any other is drawn as the blend of three, each of which knows one edge only,
//                so that it meets its neighbours.
//
// The frame is the triangle's own: a neighbour may see the same place turned by half a turn (line field) or by quarter
// turns (cross field).

#import bevy_field_patterns::kite
#import bevy_field_patterns::kite::{Coupling, Frame}
#import bevy_field_patterns::triangle_wave::{
    Corners, Wave, MIN_EDGE_WEIGHT, barycentric_gradients, corner_sum, offset, triangle_normal,
}

struct PairCorners {
    first: Corners,
    second: Corners,
}

struct Turns {
    // From corner 1 to 0, from 2 to 0, from 2 to 1.
    one: u32,
    two: u32,
    across: u32,
    closed: bool,
}

struct WavePair {
    first: Wave,
    second: Wave,
    // Share of this piece, 0 to 1; the pieces' shares sum to 1.
    weight: f32,
}

fn corner_frame(pair: PairCorners, m: u32) -> Frame {
    return Frame(pair.first.direction[m], pair.second.direction[m]);
}

fn corner_turns(pair: PairCorners, coupling: Coupling) -> Turns {
    let frame_0 = corner_frame(pair, 0u);
    let frame_1 = corner_frame(pair, 1u);
    let frame_2 = corner_frame(pair, 2u);
    let one = kite::quarter_turns(coupling, frame_1, frame_0);
    let two = kite::quarter_turns(coupling, frame_2, frame_0);
    let across = kite::quarter_turns(coupling, frame_2, frame_1);
    return Turns(one, two, across, ((one + across - two) & 3u) == 0u);
}

// Corner m turned by k quarter turns.
fn turn_corner(pair: PairCorners, m: u32, k: u32) -> PairCorners {
    var turned = pair;
    if k == 0u {
        return turned;
    }
    let swap = kite::turned_wave(k, 0u) == 1u;
    var d_first = select(pair.first.direction[m], pair.second.direction[m], swap);
    var d_second = select(pair.second.direction[m], pair.first.direction[m], swap);
    var z_first = select(pair.first.z[m], pair.second.z[m], swap);
    var z_second = select(pair.second.z[m], pair.first.z[m], swap);
    if kite::turned_reversed(k, 0u) {
        d_first = -d_first;
        z_first = kite::reversed(z_first);
    }
    if kite::turned_reversed(k, 1u) {
        d_second = -d_second;
        z_second = kite::reversed(z_second);
    }
    turned.first.direction[m] = d_first;
    turned.second.direction[m] = d_second;
    turned.first.z[m] = z_first;
    turned.second.z[m] = z_second;
    return turned;
}

fn pair_pieces(turns: Turns) -> u32 {
    return select(3u, 1u, turns.closed);
}

// Both waves at barycentrics b, as one piece sees them.
fn pair_in_triangle(pair: PairCorners, turns: Turns, vector: bool, b: vec3<f32>, piece: u32) -> WavePair {
    var corners = pair;
    var weight = b;
    var slopes = barycentric_gradients(pair.first);
    var out: WavePair;
    out.weight = 1.0;
    if turns.closed {
        corners = turn_corner(turn_corner(corners, 1u, turns.one), 2u, turns.two);
    } else {
        let inside = max(b, vec3(MIN_EDGE_WEIGHT));
        let product = inside * inside.yzx;
        out.weight = product[piece] / (product.x + product.y + product.z);
        switch piece {
            case 0u: {
                corners = turn_corner(corners, 1u, turns.one);
                weight = vec3(inside.xy, 0.0);
            }
            case 1u: {
                corners = turn_corner(corners, 2u, turns.across);
                weight = vec3(0.0, inside.yz);
            }
            default: {
                corners = turn_corner(corners, 2u, turns.two);
                weight = vec3(inside.x, 0.0, inside.z);
            }
        }
        weight /= weight.x + weight.y + weight.z;
        slopes = mat3x3<f32>();
    }
    out.first = placed(corner_sum(corners.first, weight, b, slopes), corners.first, vector, !turns.closed, b);
    out.second = placed(corner_sum(corners.second, weight, b, slopes), corners.second, vector, !turns.closed, b);
    return out;
}

fn placed(given: Wave, corners: Corners, vector: bool, odd: bool, b: vec3<f32>) -> Wave {
    var wave = given;
    wave.defined = true;
    wave.vector = vector;
    wave.odd = odd;
    wave.position = corners.position[0] + offset(corners, 0u, b);
    wave.normal = triangle_normal(corners);
    return wave;
}
