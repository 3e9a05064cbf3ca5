#define_import_path bevy_field_patterns::cell_style

// From a cell to what it does with a pixel. `cells.rs` explains the settings.
//
// Layer    a colour over the base: rgb premultiplied, w the share of the base that is left; mixes of layers are layers
// border   signed distance from the border line, in the unit of the width; the line is as wide as `border_width`
// pixel    how far the border distance moves over a pixel, in that unit
// fade     0 near, 1 where cells are smaller than pixels and their mean is drawn

#import bevy_field_patterns::cell_layout
#import bevy_field_patterns::noise::{unit_random, vector_noise}
#import bevy_field_patterns::quad::quad_shared
#import bevy_field_patterns::cells::{
    CellPoint, Cell, cell_point, find_cell, has_cells, cell_uv, cell_uv_step, mean_radius, half_gradient, cell_words,
    cell_sites, TINY,
}

const FILL_PALETTE: u32 = 1u;
const FILL_VALUES: u32 = 2u;
const UNIT_PIXELS: u32 = 0u;
const UNIT_WORLD: u32 = 1u;
const UNIT_RELATIVE: u32 = 2u;
const FLAG_ELLIPSES: u32 = 1u;
const FLAG_TILE_BY_VALUE: u32 = 2u;
// Of the area, as of the closest packing of ellipses.
const PACKED: f32 = 0.9069;
// A line in pixels takes no more of a cell's radius.
const MAX_PIXEL_LINE: f32 = 0.35;

struct CellStyle {
    palette: array<vec4<f32>, 16>,
    mean_color: vec4<f32>,
    border_color: vec4<f32>,
    gap_color: vec4<f32>,
    border_width: f32,
    border_unit: u32,
    fill_kind: u32,
    palette_len: u32,
    jitter: f32,
    rounding: f32,
    noise: f32,
    noise_scale: f32,
    bump: f32,
    bump_width: f32,
    ellipse_radius: f32,
    texture_radius: f32,
    tiles: vec2<u32>,
    flags: u32,
    debug: u32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(102) var<uniform> style: CellStyle;
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var tile_image: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var tile_sampler: sampler;

struct ScreenFrame {
    // How the world moves along the screen. [world units/pixel]
    dx: vec3<f32>,
    dy: vec3<f32>,
    // Of the fragment. [pixels]
    at: vec4<f32>,
}

struct CellPaint {
    defined: bool,
    layer: vec4<f32>,
    // Share of the pixel that a cut-out leaves.
    solid: f32,
    // Of the height of a bump. [world units/pixel]
    slope: vec2<f32>,
    fade: f32,
}

// Takes derivatives: call it in uniform control flow.
fn screen_frame(world_position: vec3<f32>, frag_coord: vec4<f32>) -> ScreenFrame {
    return ScreenFrame(dpdx(world_position), dpdy(world_position), frag_coord);
}

// The point whose cell is drawn: wobbling about the fragment's own, for borders that are not straight. The same everywhere
// on a mesh, so that it has no seams. Takes derivatives: call it in uniform control flow.
fn styled_point(pattern: vec2<u32>, rest: vec3<f32>) -> CellPoint {
    var point = cell_point(pattern, rest);
    if style.noise == 0.0 || !has_cells(point) {
        return point;
    }
    // Not by derivatives of the wobble: helper invocations need not see the buffers.
    let scale = max(mean_radius(point.tag), TINY);
    let x = wobbled(point.x, point.normal, scale);
    point.dx = wobbled(point.x + point.dx, point.normal, scale) - x;
    point.dy = wobbled(point.x + point.dy, point.normal, scale) - x;
    point.x = x;
    return point;
}

// A point of the surface moved along it, by waves about as long as `scale`.
fn wobbled(x: vec3<f32>, normal: vec3<f32>, scale: f32) -> vec3<f32> {
    let p = style.noise_scale * x / scale;
    let wobble = vector_noise(p) + 0.5 * vector_noise(2.3125 * p + 17.0);
    return x + scale * style.noise * (wobble - normal * dot(normal, wobble));
}

fn premultiplied(color: vec4<f32>) -> vec4<f32> {
    return vec4(color.rgb * color.a, 1.0 - color.a);
}

fn over(layer: vec4<f32>, top: vec4<f32>) -> vec4<f32> {
    return vec4(top.rgb + layer.rgb * top.w, layer.w * top.w);
}

fn value_of(tag: u32, sample: u32) -> vec4<f32> {
    if (cell_words[tag + cell_layout::FLAGS] & cell_layout::FLAG_VALUES) == 0u {
        return vec4(1.0);
    }
    return cell_sites[cell_words[tag + cell_layout::VALUE_BASE] + sample];
}

fn fill_of(tag: u32, sample: u32) -> vec4<f32> {
    var color = vec4(0.0);
    if style.fill_kind == FILL_PALETTE {
        color = style.palette[u32(unit_random(sample) * f32(style.palette_len))];
    } else if style.fill_kind == FILL_VALUES {
        color = value_of(tag, sample);
    }
    let brightness = 1.0 + style.jitter * (2.0 * unit_random(sample ^ 0x9E3779B9u) - 1.0);
    return premultiplied(color) * brightness;
}

fn mean_fill(tag: u32) -> vec4<f32> {
    var color = vec4(0.0);
    if style.fill_kind == FILL_PALETTE {
        color = style.mean_color;
    } else if style.fill_kind == FILL_VALUES {
        color = vec4(1.0);
        if (cell_words[tag + cell_layout::FLAGS] & cell_layout::FLAG_VALUES) != 0u {
            for (var c = 0u; c < 4u; c++) {
                color[c] = bitcast<f32>(cell_words[tag + cell_layout::MEAN_VALUE + c]);
            }
        }
    }
    return premultiplied(color);
}

#ifdef CELLS_TEXTURE
// How the cell's square moves along the screen, for `tile_of`. [squares/pixel] Takes derivatives: call it in uniform control
// flow.
fn tile_gradient(point: CellPoint, cell: Cell, frame: ScreenFrame) -> vec4<f32> {
    let dx = cell_uv_step(cell, point.dx, style.texture_radius);
    let dy = cell_uv_step(cell, point.dy, style.texture_radius);
    return quad_shared(vec4(dx, dy), cell.defined, frame.at);
}

// The cell's tile of the atlas, read with the gradients of the cell, so that borders have no seams.
fn tile_of(point: CellPoint, cell: Cell, gradient: vec4<f32>) -> vec4<f32> {
    let count = style.tiles.x * style.tiles.y;
    var pick = unit_random(cell.sample ^ 0x85EBCA6Bu);
    if (style.flags & FLAG_TILE_BY_VALUE) != 0u {
        pick = clamp(dot(value_of(point.tag, cell.sample).rgb, vec3(0.2126, 0.7152, 0.0722)), 0.0, 0.99999);
    }
    let tile = min(u32(pick * f32(count)), count - 1u);
    let grid = vec2<f32>(style.tiles);
    let dx = gradient.xy;
    let dy = gradient.zw;
    // Filters must not reach into the next tile.
    let margin = min(0.5 * (abs(dx) + abs(dy)) + 0.5 * grid / vec2<f32>(textureDimensions(tile_image)), vec2(0.5));
    let uv = clamp(cell_uv(cell, style.texture_radius), margin, 1.0 - margin);
    let at = (vec2(f32(tile % style.tiles.x), f32(tile / style.tiles.x)) + uv) / grid;
    return premultiplied(textureSampleGrad(tile_image, tile_sampler, at, dx / grid, dy / grid));
}
#endif

// The share of a pixel that a line of half width w covers, b from its middle: a box filter along the way across.
fn line_coverage(b: f32, w: f32, pixel: f32) -> f32 {
    let p = max(pixel, TINY);
    return clamp((min(b + 0.5 * p, w) - max(b - 0.5 * p, -w)) / p, 0.0, 1.0);
}

// How far the world moves where the border distance moves by one. [world units/length]
fn world_scale(per_pixel: vec2<f32>, frame: ScreenFrame) -> f32 {
    let e = dot(frame.dx, frame.dx);
    let f = dot(frame.dx, frame.dy);
    let g = dot(frame.dy, frame.dy);
    let b = per_pixel;
    let steepness = (g * b.x * b.x - 2.0 * f * b.x * b.y + e * b.y * b.y) / max(e * g - f * f, TINY);
    return inverseSqrt(max(steepness, TINY));
}

// An ellipse's outline in place of the border.
fn to_ellipse(cell: Cell, normal: vec3<f32>) -> Cell {
    var ellipse = cell;
    let distance = length(cell.seen);
    let gradient = half_gradient(cell.site, cell.seen) / max(distance, 1e-6);
    let along = gradient - normal * dot(normal, gradient);
    let slope = max(length(along), TINY);
    ellipse.border = (style.ellipse_radius - distance) / slope;
    ellipse.inwards = -along / slope;
    return ellipse;
}
