#define_import_path bevy_field_patterns::cell_debug

// Looks at the search for cells; `CellDebug` explains them. Words and units as in `cells.wgsl`.

#import bevy_field_patterns::cell_layout
#import bevy_field_patterns::noise::unit_random
#import bevy_field_patterns::cells::{CellPoint, Cell, load_site, seen_from, cell_words}

const DEBUG_LABEL: u32 = 1u;
const DEBUG_SEED: u32 = 2u;
const DEBUG_CHECK: u32 = 4u;

const GREEN: vec3<f32> = vec3(0.05, 0.5, 0.2);
const RED: vec3<f32> = vec3(0.8, 0.02, 0.02);

// Linear colours. The label's three bytes are red, green and blue, 255 being 1.
fn debug_color(debug: u32, cell: Cell, point: CellPoint) -> vec3<f32> {
    switch debug {
        case DEBUG_LABEL: {
            let bytes = vec3(cell.sample & 255u, (cell.sample >> 8u) & 255u, (cell.sample >> 16u) & 255u);
            return vec3<f32>(bytes) / 255.0;
        }
        case DEBUG_SEED: {
            let right = vec3(GREEN.x, 0.2 + 0.6 * unit_random(cell.seed), GREEN.z);
            return select(RED, right, cell.seed == cell.sample);
        }
        case DEBUG_CHECK: {
            return select(GREEN, RED, nearer_exists(cell, point));
        }
        default: { return vec3(f32(cell.evaluations) / 32.0); }
    }
}

// Whether a sample is nearer than the one that was found: a look at all of them. A tie within rounding is none.
fn nearer_exists(cell: Cell, point: CellPoint) -> bool {
    let site_base = cell_words[point.tag + cell_layout::SITE_BASE];
    let samples = cell_words[point.tag + cell_layout::SAMPLES];
    let own = dot(cell.seen, cell.seen);
    for (var sample = 0u; sample < samples; sample++) {
        let seen = seen_from(load_site(site_base, sample), point.x);
        if dot(seen, seen) < own - 1e-4 * (1.0 + own) {
            return true;
        }
    }
    return false;
}
