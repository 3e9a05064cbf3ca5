//! Metrics: what a user can rely on of eigenvalues, ellipses, structure tensors, volumes and smoothing.

use bevy::math::{DMat3, DQuat, DVec2, DVec3, UVec2, UVec3, Vec3};
use bevy::prelude::Dir3;
use bevy_field_patterns::{
    error::PatternError,
    sampling::metric::*,
    surface::{SurfaceGraph, WeldOptions},
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3, SymmetricMat3};

/// A small generator of numbers in -1..1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn rotation(&mut self) -> DMat3 {
        DMat3::from_quat(DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next()).normalize())
    }
}

fn symmetric(rotation: DMat3, values: DVec3) -> SymmetricDMat3 {
    SymmetricDMat3::from_mat3_unchecked(rotation * DMat3::from_diagonal(values) * rotation.transpose())
}

#[test]
fn eigenvectors_are_exact_to_rounding() {
    let mut numbers = Numbers(1);
    let spectra: [(&str, fn(&mut Numbers) -> DVec3); 6] = [
        ("random", |n| DVec3::new(n.next(), n.next(), n.next())),
        ("double", |n| {
            let a = n.next();
            DVec3::new(a, a, 2.0 * a + 0.5)
        }),
        ("ratio 1e6", |n| DVec3::new(1.0, 1e3, 1e6 * (1.5 + n.next()))),
        ("nearly isotropic", |n| {
            1.0 + 1e-9 * DVec3::new(n.next(), n.next(), n.next())
        }),
        ("rank 1", |n| DVec3::new(0.0, 0.0, 1.0 + 0.5 * n.next())),
        ("huge and tiny", |n| {
            DVec3::new(1.0, 2.0, 3.0) * 10.0_f64.powf(150.0 * n.next())
        }),
    ];
    for (name, values) in spectra {
        for _ in 0..20_000 {
            let (rotation, values) = (numbers.rotation(), values(&mut numbers));
            let m = symmetric(rotation, values);
            let eigen = SymmetricEigen3::new(&m);
            assert!(
                eigen.values.x <= eigen.values.y && eigen.values.y <= eigen.values.z,
                "{name}: {eigen:?}"
            );
            let size = values.abs().max_element();
            for k in 0..3 {
                let v = eigen.vectors.col(k);
                let residual = ((m * v) / size - v * (eigen.values[k] / size)).length();
                assert!(residual <= 1e-14, "{name}: residual {residual:e} of {m:?}");
            }
            let off = (eigen.vectors.transpose() * eigen.vectors - DMat3::IDENTITY).to_cols_array();
            assert!(
                off.iter().all(|x| x.abs() <= 1e-14),
                "{name}: not orthonormal: {eigen:?}"
            );
        }
    }
    for (a, b, c) in [(1.0, 0.0, 1.0), (0.0, 0.0, 0.0), (-3.0, 1e-9, 2.0), (1.0, -5.0, 1.0)] {
        let m = SymmetricDMat2::new(a, b, c);
        let eigen = SymmetricEigen2::new(&m);
        assert!(eigen.values.x <= eigen.values.y);
        for k in 0..2 {
            let v = eigen.vectors.col(k);
            assert!((m * v - v * eigen.values[k]).length() <= 1e-14 * 8.0, "{m:?}");
        }
        assert!((eigen.vectors.determinant().abs() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn a_metric_measures_its_own_axes_as_one() {
    let mut numbers = Numbers(2);
    for _ in 0..1000 {
        let frame = numbers.rotation().as_mat3();
        let (tangent, normal) = (frame.x_axis, frame.z_axis);
        let m = ellipse(tangent, normal, 3.0, 0.5);
        let length = |v: Vec3| v.dot(m * v).sqrt();
        assert!((length(tangent * 3.0) - 1.0).abs() < 1e-5);
        assert!((length(frame.y_axis * 0.5) - 1.0).abs() < 1e-5);
        // The eigenvalue along the normal is the geometric mean of the others.
        assert!((length(normal * 1.5_f32.sqrt()) - 1.0).abs() < 1e-5);
        // A metric of the surface projected onto the surface is itself.
        let projected = on_surface(&m, normal);
        assert!(
            (projected - m).abs().to_cols_array().iter().all(|e| *e < 2e-5),
            "{m:?} {projected:?}"
        );
        // A metric of space measures tangents as before.
        let space = symmetric(numbers.rotation(), DVec3::new(0.3, 1.0, 4.0)).as_symmetric_mat3();
        let projected = on_surface(&space, normal);
        let v = tangent * 0.7 - frame.y_axis * 0.2;
        assert!((v.dot(projected * v) - v.dot(space * v)).abs() < 1e-5);
    }
    let planar = planar_ellipse(0.3, 2.0, 0.25);
    let long = DVec2::from_angle(0.3) * 2.0;
    assert!((long.dot(planar * long) - 1.0).abs() < 1e-12);
}

#[test]
fn a_tensor_s_eigenvalues_become_lengths() {
    let mapping = EigenvalueMapping {
        range: bevy::math::Vec2::new(0.0, 2.0),
        lengths: bevy::math::Vec2::new(0.1, 1.0),
        max_ratio: 4.0,
    };
    // Compression counts as tension does.
    let tensor = SymmetricMat3::from_diagonal(Vec3::new(-2.0, 0.0, 77.0));
    let m = mapping.metric(&tensor, Vec3::Z);
    assert!((m.m00 - 1.0).abs() < 1e-5, "{m:?}");
    // 0.1 is lengthened to a quarter of the long axis.
    assert!((m.m11 - 16.0).abs() < 1e-3, "{m:?}");
    let planar = mapping.planar_metric(&SymmetricDMat2::new(-2.0, 0.0, 0.0));
    assert!(
        (planar.m00 - 1.0).abs() < 1e-6 && (planar.m11 - 16.0).abs() < 1e-4,
        "{planar:?}"
    );
    // A tensor that is the same in all directions makes circles.
    let round = mapping.metric(&SymmetricMat3::IDENTITY, Vec3::X);
    assert!((round.m11 - round.m22).abs() < 1e-5 && round.m12.abs() < 1e-5);
}

#[test]
fn samples_of_an_image_lie_along_its_edges() {
    let size = UVec2::new(64, 48);
    // A step along the line x = 32.
    let step: Vec<Vec3> = (0..64 * 48)
        .map(|i| Vec3::splat(if i % 64 < 32 { 0.0 } else { 1.0 }))
        .collect();
    let structure = Structure::default();
    let metrics = metric_of_pixels(&step, size, &structure);
    let (edge, quiet) = (metrics[24 * 64 + 32], metrics[24 * 64 + 2]);
    let ratio = (edge.m00 / edge.m11).sqrt();
    assert!(edge.m01.abs() < 1e-9 && (2.5..=4.0).contains(&ratio), "{edge:?}");
    assert!((quiet.m00 - quiet.m11).abs() < 1e-6, "{quiet:?}");
    // Smaller where something is.
    assert!(edge.determinant() > 2.0 * quiet.determinant());
    // A flat image has circles only.
    let flat = metric_of_pixels(&vec![Vec3::ONE; 64 * 48], size, &structure);
    assert!(flat.iter().all(|m| (m.m00 - 1.0).abs() < 1e-9 && m.m01 == 0.0));
}

#[test]
fn a_volume_and_an_image_agree_on_a_slice() {
    // φ depends on x alone: samples lie in the planes x = const.
    let size = UVec3::new(24, 20, 16);
    let scalars: Vec<f32> = (0..24 * 20 * 16).map(|i| ((i % 24) as f32 * 0.8).sin()).collect();
    let (min, max) = (Vec3::ZERO, Vec3::new(2.3, 1.9, 1.5));
    let volume = MetricVolume::from_scalars(min, max, size, &scalars, &Structure::default()).unwrap();
    let slice = Slice {
        origin: Vec3::new(0.0, 0.0, 0.7),
        u: Dir3::X,
        v: Dir3::Y,
    };
    let m = volume.on_slice(&slice, DVec2::new(1.1, 0.9));
    assert!(m.m00 > 4.0 * m.m11 && m.m01.abs() < 1e-6 * m.m00, "{m:?}");
    // Across the gradient it is isotropic.
    let across = Slice {
        u: Dir3::Y,
        v: Dir3::Z,
        ..slice
    };
    let m = volume.on_slice(&across, DVec2::new(0.9, 0.4));
    assert!((m.m00 - m.m11).abs() < 1e-3 * m.m00, "{m:?}");
    // Trilinear: exact at grid points, constant outside.
    let metrics: Vec<SymmetricMat3> = (1..=8)
        .map(|k| SymmetricMat3::from_diagonal(Vec3::splat(k as f32)))
        .collect();
    let cube = MetricVolume::new(Vec3::ZERO, Vec3::ONE, UVec3::splat(2), metrics).unwrap();
    assert_eq!(cube.at(DVec3::new(1.0, 0.0, 1.0)).m00, 6.0);
    assert_eq!(cube.at(DVec3::splat(0.5)).m00, 4.5);
    assert_eq!(cube.at(DVec3::splat(9.0)).m00, 8.0);

    let bad = |metrics| MetricVolume::new(Vec3::ZERO, Vec3::ONE, UVec3::new(2, 1, 1), metrics).unwrap_err();
    assert!(matches!(bad(vec![]), PatternError::WrongLength { .. }));
    let one = SymmetricMat3::IDENTITY;
    assert!(matches!(
        bad(vec![one, one * f32::NAN]),
        PatternError::NotFinite { index: 1, .. }
    ));
    assert!(matches!(
        bad(vec![one * -1.0, one]),
        PatternError::NotPositive { index: 0, .. }
    ));
}

/// A flat sheet of n × n vertices over the unit square.
fn sheet(n: usize) -> SurfaceGraph {
    let positions: Vec<Vec3> = (0..n * n)
        .map(|i| Vec3::new((i % n) as f32, (i / n) as f32, 0.0) / (n - 1) as f32)
        .collect();
    let quad = |x: usize, y: usize| {
        let [a, b, c, d] = [y * n + x, y * n + x + 1, (y + 1) * n + x, (y + 1) * n + x + 1].map(|v| v as u32);
        [[a, b, d], [a, d, c]]
    };
    let triangles: Vec<[u32; 3]> = (0..n - 1)
        .flat_map(|y| (0..n - 1).flat_map(move |x| quad(x, y)))
        .collect();
    SurfaceGraph::from_triangles(&positions, &triangles, &WeldOptions::default()).unwrap()
}

#[test]
fn smoothing_keeps_areas_and_rounds_off_a_pole() {
    let graph = sheet(33);
    // Long axes around the centre, where no direction is right.
    let mut metrics: Vec<SymmetricMat3> = graph
        .positions
        .iter()
        .map(|p| {
            let tangent = (*p - Vec3::new(0.5, 0.5, 0.0)).cross(Vec3::Z).normalize_or(Vec3::X);
            ellipse(tangent, Vec3::Z, 2.0, 0.5)
        })
        .collect();
    let constant = vec![ellipse(Vec3::X, Vec3::Z, 3.0, 1.0); graph.len()];
    let mut smoothed = constant.clone();
    smooth(&graph, &mut smoothed, 10);
    assert!(
        smoothed
            .iter()
            .zip(&constant)
            .all(|(a, b)| (*a - *b).abs().to_cols_array().iter().all(|e| *e < 1e-5))
    );

    smooth(&graph, &mut metrics, 15);
    let ratio = |m: &SymmetricMat3| {
        let planar = SymmetricEigen2::new(&SymmetricDMat2::new(m.m00.into(), m.m01.into(), m.m11.into()));
        (planar.values.y / planar.values.x).sqrt()
    };
    for (m, p) in metrics.iter().zip(&graph.positions) {
        let area = m.m00 * m.m11 - m.m01 * m.m01;
        assert!((area - 1.0).abs() < 1e-4, "the area changed: {m:?}");
        let radius = p.distance(Vec3::new(0.5, 0.5, 0.0));
        if radius < 1e-3 {
            // From 4; the mesh itself is not round, its diagonals all run one way.
            assert!(ratio(m) < 1.6, "not round at the pole: {}", ratio(m));
        } else if radius > 0.3 && p.x > 0.2 && p.x < 0.8 && p.y > 0.2 && p.y < 0.8 {
            assert!(ratio(m) > 3.0, "lost at {p}: {}", ratio(m));
        }
    }
}

#[test]
fn scalars_on_a_surface_give_the_metric_of_the_same_image() {
    let graph = sheet(65);
    let scalars: Vec<f32> = graph
        .positions
        .iter()
        .map(|p| if p.x < 0.5 { 0.0 } else { 1.0 })
        .collect();
    let metrics = metric_of_scalars(&graph, &scalars, &Structure::default());
    for (m, p) in metrics.iter().zip(&graph.positions) {
        if (p.x - 0.5).abs() < 0.02 && (0.1..0.9).contains(&p.y) {
            assert!(
                (m.m00 / m.m11).sqrt() > 2.5 && m.m01.abs() < 1e-3 * m.m00,
                "{m:?} at {p}"
            );
        } else if p.x < 0.1 {
            assert!((m.m00 - 1.0).abs() < 1e-5, "{m:?} at {p}");
        }
    }
}
