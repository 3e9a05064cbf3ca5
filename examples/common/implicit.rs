//! Solids as signed distances, and unions of them without creases.
//!
//! In: points of space, sizes. Out: distances, negative inside. All of them change by about the way a point moves or
//! less, which the mesher ([`isosurface`](super::isosurface)) counts on to leave out empty space.

use bevy::prelude::*;

/// Union with a fillet: `blend` is the difference of distances below which the two melt. Its second derivative is
/// continuous, so that curvatures are.
pub fn smooth_union(a: f32, b: f32, blend: f32) -> f32 {
    let near = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - near.powi(3) * blend / 6.0
}

/// Union of any number of solids at once, smooth everywhere and in no order: -blend·ln Σ exp(-d/blend). Where n of them
/// meet it swells by blend·ln n.
pub fn melt(distances: impl Iterator<Item = f32> + Clone, blend: f32) -> f32 {
    let nearest = distances.clone().fold(f32::INFINITY, f32::min);
    let sum: f32 = distances.map(|d| ((nearest - d) / blend).exp()).sum();
    nearest - blend * sum.ln()
}

/// A ball.
pub fn ball(p: Vec3, centre: Vec3, radius: f32) -> f32 {
    p.distance(centre) - radius
}

/// An ellipsoid along the axes. Too short far away, right near the surface.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let scaled = (p - centre) / radii;
    let slope = (scaled / radii).length();
    let level = scaled.length();
    if slope == 0.0 {
        -radii.min_element()
    } else {
        level * (level - 1.0) / slope
    }
}

/// A rod with round ends, whose radius goes from `from.w` to `to.w`.
pub fn limb(p: Vec3, from: Vec4, to: Vec4) -> f32 {
    let (t, near) = nearest_on_segment(p, from.xyz(), to.xyz());
    p.distance(near) - from.w.lerp(to.w, t)
}

/// The nearest point of a segment, and where it is, 0 to 1.
pub fn nearest_on_segment(p: Vec3, a: Vec3, b: Vec3) -> (f32, Vec3) {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (t, a + t * along)
}

/// A tube along a chain of points, each with a radius in w.
#[derive(Clone, Debug)]
pub struct Tube {
    points: Vec<Vec4>,
    /// A ball around all of it: what is far from the ball need not look at the points.
    centre: Vec3,
    reach: f32,
}

impl Tube {
    /// Through `points`, 2 or more: positions and, in w, radii.
    pub fn new(points: Vec<Vec4>) -> Self {
        let centre = points.iter().map(|p| p.xyz()).sum::<Vec3>() / points.len() as f32;
        let reach = points.iter().map(|p| p.xyz().distance(centre) + p.w);
        Self {
            reach: reach.fold(0.0, f32::max),
            centre,
            points,
        }
    }

    /// Positions and radii.
    pub fn points(&self) -> &[Vec4] {
        &self.points
    }

    /// Less than the distance, and cheap.
    pub fn at_least(&self, p: Vec3) -> f32 {
        p.distance(self.centre) - self.reach
    }

    /// The distance, and the unit direction of the tube where it is nearest.
    pub fn distance(&self, p: Vec3) -> (f32, Vec3) {
        let (d, [from, to]) = self.points.array_windows().fold(
            (f32::INFINITY, [Vec4::ZERO; 2]),
            |(best, segment), &[from, to]| match limb(p, from, to) {
                d if d < best => (d, [from, to]),
                _ => (best, segment),
            },
        );
        (d, (to - from).xyz().normalize_or_zero())
    }
}

/// The gradient of a distance, by differences over the corners of a tetrahedron of half-width `step`.
pub fn gradient(distance: &impl Fn(Vec3) -> f32, p: Vec3, step: f32) -> Vec3 {
    const CORNERS: [Vec3; 4] = [
        Vec3::new(1.0, -1.0, -1.0),
        Vec3::new(-1.0, -1.0, 1.0),
        Vec3::new(-1.0, 1.0, -1.0),
        Vec3::new(1.0, 1.0, 1.0),
    ];
    let sum: Vec3 = CORNERS.iter().map(|&corner| corner * distance(p + step * corner)).sum();
    sum / (4.0 * step)
}

/// The matrix of second derivatives of a distance, by central differences of width `step`.
pub fn hessian(distance: &impl Fn(Vec3) -> f32, p: Vec3, step: f32) -> Mat3 {
    let slope = |axis: Vec3| {
        let component = |along: Vec3| {
            distance(p + step * (axis + along))
                - distance(p + step * (axis - along))
                - distance(p - step * (axis - along))
                + distance(p - step * (axis + along))
        };
        Vec3::from_array(Vec3::AXES.map(component)) / (4.0 * step * step)
    };
    let columns = Vec3::AXES.map(slope);
    Mat3::from_cols(columns[0], columns[1], columns[2])
}
