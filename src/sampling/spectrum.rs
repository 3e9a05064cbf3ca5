//! The power spectrum of a point set: blue noise has no power at low frequencies.

use bevy::math::DVec2;
use glam_matrix_extras::SymmetricDMat2;
use std::f64::consts::TAU;

/// The power of a point set at the frequencies (i, j) in periods per width and height, i and j from -half to half.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerSpectrum {
    /// Largest frequency on each axis.
    pub half: u32,
    /// |Σ exp(-2πi k·p)|²/n, row by row from (-half, -half), 2 half + 1 per row: 1 on average for white noise.
    /// Frequency 0 is set to 0.
    pub power: Vec<f32>,
    /// Number of points.
    points: usize,
    /// Width and height of the domain.
    extent: DVec2,
}

/// The power spectrum of points in the rectangle from `min` to `max`. The example `sample` draws it with `--spectrum`. Takes n (2 half + 1) (half + 1) complex
/// multiplications.
pub fn power_spectrum(points: &[DVec2], min: DVec2, max: DVec2, half: u32) -> PowerSpectrum {
    let extent = max - min;
    let (n, width) = (half as usize, 2 * half as usize + 1);
    let unit: Vec<DVec2> = points.iter().map(|p| (p - min) / extent).collect();
    let mut power = vec![0.0; width * width];
    let mut row = vec![DVec2::ZERO; width];
    // The spectrum of real data is symmetric: the upper half is enough.
    for j in 0..=n {
        row.fill(DVec2::ZERO);
        for p in &unit {
            let mut phasor = DVec2::from_angle(-TAU * (j as f64 * p.y - n as f64 * p.x));
            let turn = DVec2::from_angle(-TAU * p.x);
            for sum in &mut row {
                *sum += phasor;
                phasor = phasor.rotate(turn);
            }
        }
        for (i, sum) in row.iter().enumerate() {
            let value = (sum.length_squared() / unit.len().max(1) as f64) as f32;
            power[(n + j) * width + i] = value;
            power[(n - j) * width + (width - 1 - i)] = value;
        }
    }
    power[n * width + n] = 0.0;
    PowerSpectrum {
        half,
        power,
        points: points.len(),
        extent,
    }
}

impl PowerSpectrum {
    /// The mean power of the frequencies up to half of that of the mean spacing; 1 for white noise. Frequencies are
    /// measured in the plane in which `metric` is isotropic: identity, or the constant metric of the set. Those on the two
    /// axes are left out: there the power is that of the border, along which samples lie in line.
    pub fn low_frequency(&self, metric: SymmetricDMat2) -> f32 {
        self.band(metric, 0.0, 0.5)
    }

    /// The mean power of `bins` bands of equal width, from 0 to `largest` times the frequency of the mean spacing; the
    /// radial profile. Bands without a frequency are 0.
    pub fn radial(&self, metric: SymmetricDMat2, largest: f64, bins: u32) -> Vec<f32> {
        let width = largest / f64::from(bins);
        (0..bins)
            .map(|bin| self.band(metric, f64::from(bin) * width, f64::from(bin + 1) * width))
            .collect()
    }

    /// The mean power from one frequency to another, in those of the mean spacing.
    fn band(&self, metric: SymmetricDMat2, from: f64, to: f64) -> f32 {
        let inverse = metric.inverse();
        let area = self.extent.element_product() * metric.determinant().sqrt();
        // The hexagonal packing's lattice frequency, squared.
        let mean = 2.0 / 3.0_f64.sqrt() * self.points as f64 / area;
        let half = i64::from(self.half);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        let frequencies = (-half..=half).flat_map(|j| (-half..=half).map(move |i| DVec2::new(i as f64, j as f64)));
        for (&power, k) in self.power.iter().zip(frequencies) {
            let k = k / self.extent;
            let squared = k.dot(inverse * k) / mean;
            if k.x != 0.0 && k.y != 0.0 && squared >= from * from && squared < to * to {
                sum += f64::from(power);
                count += 1.0;
            }
        }
        (sum / count.max(1.0)) as f32
    }
}
