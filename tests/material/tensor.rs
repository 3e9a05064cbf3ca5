//! A tensor's stripes on a GPU: colours and widths are those of the eigenvalues, limits are where they should be.

use bevy::prelude::*;
use bevy_field_patterns::{material::*, wave::Waves};

use crate::{
    Scene, WHITE,
    patterns::Pattern,
    square_on,
    stage::{Lens, Picture},
};

/// First eigenvalue red, second green, blue beyond the limits, on white, unlit.
pub fn style() -> Tensor {
    let plain = |color: LinearRgba| Eigenvalue {
        low_color: (color * 0.2).with_alpha(1.0),
        high_color: color,
        alert_color: LinearRgba::BLUE,
        thin: 0.1,
        thick: 0.8,
        limit: 0.7,
        ..default()
    };
    Tensor {
        first: plain(LinearRgba::RED),
        second: plain(LinearRgba::GREEN),
        gap_color: WHITE,
        ..default()
    }
}

pub fn over(extension: Tensor) -> TensorMaterial {
    TensorMaterial {
        base: StandardMaterial {
            unlit: true,
            ..default()
        },
        extension,
    }
}

fn draw(scene: &mut Scene, mesh: &Handle<Mesh>, tag: u32, extension: Tensor, lens: Lens) -> Picture {
    let material = scene.stage.add(over(extension));
    let body = scene.stage.body(mesh, &material, tag, Transform::IDENTITY);
    let picture = scene.stage.picture(lens);
    scene.stage.clear([body]);
    picture
}

/// On a plane with values that grow upwards everything is known.
pub fn values_are_colours_and_widths(scene: &mut Scene) {
    let mut plane = Pattern::plane(2.0, 8, Vec3::X, 2.0);
    // 0 below to 1 above, and the other way round.
    let values = plane.positions.iter().map(|p| 0.5 + 0.5 * p.y);
    plane.scalars = values.map(|t| Vec2::new(t, 0.4 - 0.4 * t)).collect();
    let mesh = scene.stage.add(plane.mesh());
    let tag = scene.memory.push(&plane);
    scene.upload();
    let lens = square_on(128);
    let style = Tensor {
        line_width: 0.0,
        ..style()
    };
    let picture = draw(scene, &mesh, tag, style.clone(), lens);
    picture.save("tensor plane");
    for y in [4, 40, 64, 100, 124] {
        let value = 1.0 - (y as f32 + 0.5) / 128.0;
        let others = [value, 0.4 - 0.4 * value];
        let width = |value: f32| 0.5 * (0.1 + 0.7 * value);
        // Sums over a row of four periods. White is what neither covers.
        let sums: Vec4 = (0..128).map(|x| picture.at(x, y)).sum::<Vec4>() / 128.0;
        let white = 1.0 - width(others[0]) - width(others[1]);
        let alert = value > 0.7;
        let red = if alert { 0.0 } else { 0.2 + 0.8 * value };
        let expected = Vec3::new(
            white + red * width(others[0]),
            white + (0.2 + 0.8 * others[1]) * width(others[1]),
            white + if alert { width(others[0]) } else { 0.0 },
        );
        assert!(
            (sums.truncate() - expected).abs().max_element() < 0.01,
            "{sums} instead of {expected} at {value}"
        );
    }
    // The limit is a crisp line at its height, through stripes and gaps.
    let lined = draw(
        scene,
        &mesh,
        tag,
        Tensor {
            line_width: 2.0,
            ..style
        },
        lens,
    );
    let dark = |y: usize| (0..128).all(|x| lined.at(x, y).truncate().max_element() < 0.35);
    let rows: Vec<usize> = (0..128).filter(|&y| dark(y)).collect();
    assert!(
        rows.iter().all(|&y| (37..=39).contains(&y)) && !rows.is_empty(),
        "the line is at {rows:?}"
    );
}

/// Values turn with the frames of a cross field: no seams. And holes of a cut-out are where gaps are.
pub fn turns_and_holes(scene: &mut Scene) {
    let mut patterns = [
        Pattern::woven(3.0, Waves::Cross, |_| 0),
        Pattern::woven(3.0, Waves::Cross, |v| v * 7 % 4),
        Pattern::woven(3.0, Waves::Orthogonal { ratio: 1.0 }, |v| v * 7 % 4),
    ];
    for pattern in &mut patterns {
        pattern.scalars = pattern.positions.iter().map(|p| Vec2::new(p.x, 0.5)).collect();
    }
    let mesh = scene.stage.add(patterns[0].mesh());
    let tags = patterns.map(|pattern| scene.memory.push(&pattern));
    scene.upload();
    let both = || Tensor {
        waves: StripeWaves::Both,
        ..style()
    };
    let pictures = tags.map(|tag| draw(scene, &mesh, tag, both(), square_on(128)));
    pictures[0].save("tensor woven");
    assert!(pictures[0].max_difference(&pictures[1]) < 2e-3);
    assert!(
        pictures[0].max_difference(&pictures[2]) > 0.5,
        "the comparison cannot fail"
    );

    let whole = draw(scene, &mesh, tags[0], both(), square_on(128));
    let cut = Tensor { cutout: true, ..both() };
    let holes = draw(scene, &mesh, tags[0], cut, square_on(128));
    holes.save("tensor holes");
    for (a, b) in whole.pixels.iter().zip(&holes.pixels) {
        let gap = a.truncate().min_element() > 0.9;
        assert!(!gap || b.truncate().max_element() < 1e-3, "a gap that is not cut out");
    }
    assert!(holes.pixels.iter().filter(|p| p.truncate().max_element() > 0.2).count() > 2000);
}
