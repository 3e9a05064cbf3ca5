//! Which vertices of a mesh are one vertex of its surface.
//!
//! In: the positions of a mesh's vertices. Out: for each one its welded vertex. Meshes repeat vertices along seams of
//! UVs, normals and materials; a pattern must not be cut there, so vertices at the same place are one.
//!
//! "The same place" is the transitive closure of "no farther apart than a tolerance", which does not depend on the order
//! of the vertices. Equal positions are found first, with a hash table. Then, where there is a tolerance:
//!
//! * The vertices are sorted into cubes with a diagonal just below the tolerance; all vertices in a cube are one.
//! * Vertices in different cubes can only be close if the cubes are at most two apart along each axis. The sorted cubes
//!   are walked with one cursor per row of neighbours (13 rows, by symmetry), and cubes that are not yet joined are
//!   compared vertex by vertex.
//! * A union-find forest collects what is joined.
//!
//! The default tolerance is a few units of rounding. Seams need it: where the ends of a closed curve are computed from
//! angles of 0 and 2π they are not equal, since sin 2π is not 0 in floating point. Bevy's `Torus` and `Sphere` are such.

use super::order::argsort;
use bevy::{math::DVec3, platform::collections::HashMap, prelude::*};

/// How mesh vertices become vertices of the surface.
///
/// Vertices are one if they are no farther apart than the larger of the two tolerances, directly or through others. Keep
/// them well below the length of the edges: chains of close vertices collapse into one, and triangles with them.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default)]
pub struct WeldOptions {
    /// Tolerance in the mesh's units, 0 or more. Default 0.
    pub tolerance: f32,
    /// Tolerance in units of rounding, `f32::EPSILON` times the mesh's largest coordinate; 0 or more. Default 4, which
    /// closes the seams of Bevy's primitives. With 0 in both fields only equal positions are welded.
    pub rounding: f32,
}

impl Default for WeldOptions {
    fn default() -> Self {
        Self {
            tolerance: 0.0,
            rounding: 4.0,
        }
    }
}

impl WeldOptions {
    /// The larger of the two tolerances, in the mesh's units. Negative and NaN fields count as 0.
    fn distance(&self, positions: &[Vec3]) -> f64 {
        let largest = positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let rounding = f64::from(self.rounding) * f64::from(f32::EPSILON) * f64::from(largest);
        f64::from(self.tolerance).max(rounding).max(0.0)
    }
}

/// The result of welding.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Weld {
    /// The welded vertex of each mesh vertex. Welded vertices are numbered in the order of first appearance.
    pub vertex_of: Vec<u32>,
    /// The first mesh vertex of each welded vertex, ascending.
    pub first: Vec<u32>,
}

/// Welds vertices at the same place. `positions` must be finite; -0.0 and 0.0 are the same.
pub fn weld(positions: &[Vec3], options: &WeldOptions) -> Weld {
    let exact = weld_equal(positions);
    let distance = options.distance(positions);
    if distance > 0.0 {
        let distinct: Vec<Vec3> = exact.first.iter().map(|&v| positions[v as usize]).collect();
        exact.then(&weld_close(&distinct, distance))
    } else {
        exact
    }
}

impl Weld {
    /// Welds the welded vertices once more.
    fn then(&self, next: &Self) -> Self {
        Self {
            vertex_of: self.vertex_of.iter().map(|&v| next.vertex_of[v as usize]).collect(),
            first: next.first.iter().map(|&v| self.first[v as usize]).collect(),
        }
    }
}

fn weld_equal(positions: &[Vec3]) -> Weld {
    let mut welded = HashMap::with_capacity(positions.len());
    let mut weld = Weld {
        vertex_of: Vec::with_capacity(positions.len()),
        first: Vec::new(),
    };
    for (p, vertex) in positions.iter().zip(0..) {
        // Adding 0.0 turns -0.0 into 0.0.
        let key = (p + Vec3::ZERO).to_array().map(f32::to_bits);
        let next = weld.first.len() as u32;
        let id = *welded.entry(key).or_insert(next);
        if id == next {
            weld.first.push(vertex);
        }
        weld.vertex_of.push(id);
    }
    weld
}

fn weld_close(positions: &[Vec3], tolerance: f64) -> Weld {
    let grid = Grid::new(positions, tolerance);
    let mut sets = UnionFind((0..positions.len() as u32).collect());
    for cube in 0..grid.cubes.len() {
        let [first, others @ ..] = grid.members(cube) else {
            continue;
        };
        for other in others {
            sets.unite(*first, *other);
        }
    }
    let close = |a: u32, b: u32| {
        let difference = positions[a as usize].as_dvec3() - positions[b as usize].as_dvec3();
        difference.length_squared() <= tolerance * tolerance
    };
    grid.for_neighbors(|a, b| {
        let (a, b) = (grid.members(a), grid.members(b));
        if sets.find(a[0]) != sets.find(b[0]) && a.iter().any(|&v| b.iter().any(|&w| close(v, w))) {
            sets.unite(a[0], b[0]);
        }
    });
    sets.into_weld()
}

/// Vertices in cubes; each occupied cube once, in lexicographic order of (z, y, x).
struct Grid {
    cubes: Vec<DVec3>,
    offsets: Vec<u32>,
    vertices: Vec<u32>,
}

impl Grid {
    /// A little less than 1 / √3, so that rounding never puts two vertices into a cube that are too far apart.
    const SIDE: f64 = 0.577;
    /// Cubes that are farther apart along an axis hold no close vertices: 2 * 0.577 > 1.
    const REACH: f64 = 2.0;

    fn new(positions: &[Vec3], tolerance: f64) -> Self {
        // f64 holds every cube's whole coordinates; beyond 2^53, where it does not, f32 positions are cubes apart.
        let side = tolerance * Self::SIDE;
        let cubes: Vec<DVec3> = positions.iter().map(|p| (p.as_dvec3() / side).floor()).collect();
        let mut vertices: Vec<u32> = (0..positions.len() as u32).collect();
        #[expect(
            clippy::needless_range_loop,
            reason = "the axis of a vector, not an element of `cubes`"
        )]
        for axis in 0..3 {
            let keys: Vec<u64> = vertices.iter().map(|&v| ascending(cubes[v as usize][axis])).collect();
            vertices = argsort(&keys).into_iter().map(|i| vertices[i as usize]).collect();
        }
        let mut grid = Self {
            cubes: Vec::new(),
            offsets: Vec::new(),
            vertices,
        };
        for (&vertex, i) in grid.vertices.iter().zip(0..) {
            let cube = cubes[vertex as usize];
            if grid.cubes.last() != Some(&cube) {
                grid.cubes.push(cube);
                grid.offsets.push(i);
            }
        }
        grid.offsets.push(positions.len() as u32);
        grid
    }

    fn members(&self, cube: usize) -> &[u32] {
        &self.vertices[self.offsets[cube] as usize..self.offsets[cube + 1] as usize]
    }

    /// Calls `visit` with every pair of cubes that are within reach of each other.
    fn for_neighbors(&self, mut visit: impl FnMut(usize, usize)) {
        let steps = || (-2..=2).map(f64::from);
        let rows = steps()
            .flat_map(|z| steps().map(move |y| (z, y)))
            .filter(|&row| row >= (0.0, 0.0));
        for (z, y) in rows {
            // The row's begin moves forward only, since the cubes are in order.
            let mut begin = 0;
            for (a, cube) in self.cubes.iter().enumerate() {
                let row = (cube.z + z, cube.y + y);
                let key = |c: &DVec3| (c.z, c.y, c.x);
                while begin < self.cubes.len() && key(&self.cubes[begin]) < (row.0, row.1, cube.x - Self::REACH) {
                    begin += 1;
                }
                let in_row = |c: &DVec3| (c.z, c.y) == row && c.x <= cube.x + Self::REACH;
                for b in (begin..self.cubes.len()).take_while(|&b| in_row(&self.cubes[b])) {
                    if a != b {
                        visit(a, b);
                    }
                }
            }
        }
    }
}

/// The bits of a number, so that they sort as the number does.
fn ascending(x: f64) -> u64 {
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// A forest of parents; roots are their own parents and the smallest of their set.
struct UnionFind(Vec<u32>);

impl UnionFind {
    fn find(&mut self, mut a: u32) -> u32 {
        while self.0[a as usize] != a {
            let grandparent = self.0[self.0[a as usize] as usize];
            self.0[a as usize] = grandparent;
            a = grandparent;
        }
        a
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    fn into_weld(mut self) -> Weld {
        let roots: Vec<u32> = (0..self.0.len() as u32).map(|v| self.find(v)).collect();
        let mut weld = Weld {
            vertex_of: Vec::with_capacity(roots.len()),
            first: Vec::new(),
        };
        for (&root, vertex) in roots.iter().zip(0..) {
            // A root is the smallest of its set, so its number is known when the others come.
            if root == vertex {
                weld.vertex_of.push(weld.first.len() as u32);
                weld.first.push(vertex);
            } else {
                weld.vertex_of.push(weld.vertex_of[root as usize]);
            }
        }
        weld
    }
}
