//! The parameters of a pattern's sources, as words of the surface buffer; the same as in `parameters.wgsl`.

use crate::field::{DistanceRamp, Falloff, PixelSize, ScalarRamp, VortexCore};
use bevy::math::{Mat3A, Vec3};
use bytemuck::{Pod, Zeroable};

/// All of them. What a source does not use is 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Parameters {
    pub(super) directions: DirectionParameters,
    pub(super) cores: Vec<CoreParameters>,
    pub(super) frequencies: FrequencyParameters,
}

impl Parameters {
    pub(super) fn words(&self) -> Vec<u32> {
        let mut words: Vec<u32> = bytemuck::cast_slice(&[self.directions]).to_vec();
        words.extend_from_slice(&self.frequencies.0);
        words.extend_from_slice(bytemuck::cast_slice(&self.cores));
        words
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(super) struct DirectionParameters {
    linear: [f32; 9],
    pub(super) blend: f32,
    pub(super) cores: u32,
    pub(super) choice: u32,
    pub(super) base: [f32; 3],
    pad: u32,
}

impl DirectionParameters {
    /// What carries given vectors into the pattern's space.
    pub(super) fn carry(&mut self, linear: Option<Mat3A>) {
        self.linear = linear.unwrap_or(Mat3A::IDENTITY).to_cols_array();
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(super) struct CoreParameters {
    position: [f32; 3],
    radius: f32,
    strength: f32,
    gaussian: u32,
    pad: [u32; 2],
}

impl CoreParameters {
    /// Whether the vortex turns the other way than before, or has moved by more than its radius.
    pub(super) fn leaps(&self, before: &Self) -> bool {
        let way = Vec3::from(self.position).distance(before.position.into());
        self.strength * before.strength < 0.0 || way > self.radius
    }
}

impl From<VortexCore> for CoreParameters {
    fn from(core: VortexCore) -> Self {
        Self {
            position: core.position.to_array(),
            radius: core.radius,
            strength: core.strength,
            gaussian: u32::from(core.falloff == Falloff::Gaussian),
            pad: [0; 2],
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct FrequencyParameters([u32; 16]);

impl FrequencyParameters {
    fn of(numbers: &[f32]) -> Self {
        let mut words = [0; 16];
        for (word, number) in words.iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
        Self(words)
    }

    pub(super) fn distance(ramp: &DistanceRamp) -> Self {
        let [Vec3 { x, y, z }, b] = ramp.segment;
        let [near, far] = ramp.frequencies;
        Self::of(&[x, y, z, b.x, b.y, b.z, ramp.near, ramp.far, near, far])
    }

    pub(super) fn screen(size: &PixelSize, pixels: f32) -> Self {
        let plane = size.plane;
        Self::of(&[plane.x, plane.y, plane.z, plane.w, size.least, pixels])
    }

    /// `index`: of the scalar, 0 or 1.
    pub(super) fn scalar(index: u32, ramp: &ScalarRamp) -> Self {
        let [low, high] = ramp.values;
        let [low_frequency, high_frequency] = ramp.frequencies;
        let mut parameters = Self::of(&[0.0, low, high, low_frequency, high_frequency]);
        parameters.0[0] = index;
        parameters
    }
}
