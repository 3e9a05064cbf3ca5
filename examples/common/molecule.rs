//! Caffeine: its electron density's surface and the charge on it.
//!
//! In: an edge length. Out: a smooth closed surface in ångströms, and a charge per vertex. Geometry and charges are
//! `PubChem`'s, the National Library of Medicine's database: 3D conformer of compound 2519 (coordinates in Å) and its MMFF94
//! partial charges (in elementary charges; those not listed there are 0).
//! <https://pubchem.ncbi.nlm.nih.gov/compound/2519>

use bevy::prelude::*;

use super::{isosurface, mesh_file::RawMesh};

/// One atom.
#[derive(Clone, Copy, Debug)]
pub struct Atom {
    /// H, C, N or O.
    pub element: char,
    /// In Å.
    pub position: Vec3,
    /// MMFF94 partial charge, in elementary charges.
    pub charge: f32,
}

impl Atom {
    /// Van der Waals radius in Å (Bondi 1964).
    pub fn radius(&self) -> f32 {
        match self.element {
            'H' => 1.20,
            'N' => 1.55,
            'O' => 1.52,
            _ => 1.70,
        }
    }
}

const fn atom(element: char, x: f32, y: f32, z: f32, charge: f32) -> Atom {
    Atom {
        element,
        position: Vec3::new(x, y, z),
        charge,
    }
}

/// The 24 atoms.
pub const CAFFEINE: [Atom; 24] = [
    atom('O', 0.4700, 2.5688, 0.0006, -0.57),
    atom('O', -3.1271, -0.4436, -0.0003, -0.57),
    atom('N', -0.9686, -1.3125, 0.0000, -0.42),
    atom('N', 2.2182, 0.1412, -0.0003, 0.05),
    atom('N', -1.3477, 1.0797, -0.0001, -0.42),
    atom('N', 1.4119, -1.9372, 0.0002, -0.57),
    atom('C', 0.8579, 0.2592, -0.0008, -0.24),
    atom('C', 0.3897, -1.0264, -0.0004, 0.29),
    atom('C', 0.0307, 1.4220, -0.0006, 0.71),
    atom('C', -1.9061, -0.2495, -0.0004, 0.69),
    atom('C', 2.5032, -1.1998, 0.0003, 0.04),
    atom('C', -1.4276, -2.6960, 0.0008, 0.3),
    atom('C', 3.1926, 1.2061, 0.0003, 0.26),
    atom('C', -2.2969, 2.1881, 0.0007, 0.3),
    atom('H', 3.5163, -1.5787, 0.0008, 0.15),
    atom('H', -1.0451, -3.1973, -0.8937, 0.0),
    atom('H', -2.5186, -2.7596, 0.0011, 0.0),
    atom('H', -1.0447, -3.1963, 0.8957, 0.0),
    atom('H', 4.1992, 0.7801, 0.0002, 0.0),
    atom('H', 3.0468, 1.8092, -0.8992, 0.0),
    atom('H', 3.0466, 1.8083, 0.9004, 0.0),
    atom('H', -1.8087, 3.1651, -0.0003, 0.0),
    atom('H', -2.9322, 2.1027, 0.8881, 0.0),
    atom('H', -2.9346, 2.1021, -0.8849, 0.0),
];

/// How fast the density of an atom falls (Blinn 1982): at 3 the surface keeps near the atoms and has no creases.
const DECAY: f32 = 3.0;

/// The density of an atom at a point: 1 at its radius.
fn density(atom: &Atom, p: Vec3) -> f32 {
    let from = p.distance_squared(atom.position) / atom.radius().powi(2);
    (DECAY * (1.0 - from)).exp()
}

/// The surface where the density is 1, with edges about `edge` Å long.
pub fn surface(atoms: &[Atom], edge: f32) -> RawMesh {
    const SIZE: f32 = 1.5;
    let distance = |p: Vec3| {
        let density: f32 = atoms.iter().map(|atom| density(atom, p)).sum();
        // What it would be for one atom of mean size, so that it grows as a distance does.
        SIZE * (1.0 - density.max(1e-30).ln() / DECAY).max(0.0).sqrt() - SIZE
    };
    let room = Vec3::splat(2.6);
    let corners =
        |pick: fn(Vec3, Vec3) -> Vec3| atoms.iter().map(|atom| atom.position).reduce(pick).unwrap_or_default();
    isosurface::mesh(distance, corners(Vec3::min) - room, corners(Vec3::max) + room, edge)
}

/// The charge at points of the surface: of the atoms near it, each as much as it has of the density.
pub fn charges(atoms: &[Atom], points: &[Vec3]) -> Vec<f32> {
    let at = |&p: &Vec3| {
        let (charge, density) = atoms.iter().fold((0.0, 0.0), |(charge, sum), atom| {
            let density = density(atom, p);
            (charge + density * atom.charge, sum + density)
        });
        charge / density.max(f32::MIN_POSITIVE)
    };
    points.iter().map(at).collect()
}
