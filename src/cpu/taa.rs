//! Twin of `taa/blend_frames`: a frame blended into the mean of those before it.

use glam::{IVec2, Vec2, Vec3, Vec4};

use crate::color::luminance;
use crate::shared::FrameData;

const LEAST_DEVIATION: f32 = 1e-5;

/// How frames are blended.
#[derive(Clone, Copy, Debug)]
pub struct Blend {
    /// Of the newest frame, where something moves.
    pub least_weight: f32,
    /// The same where nothing does.
    pub least_weight_at_rest: f32,
    /// How far from the mean around a pixel its history may lie, in standard deviations.
    pub most_deviations: f32,
    /// How far one outside is moved there where nothing moves.
    pub clip_at_rest: f32,
    /// What is brighter than white counts less.
    pub weighs_brightness: bool,
    /// Motion is that of the nearest surface of 3x3 pixels.
    pub takes_nearest: bool,
}

/// As the shader does it.
pub const BLEND: Blend = Blend {
    least_weight: 0.1,
    least_weight_at_rest: 0.04,
    most_deviations: 1.25,
    clip_at_rest: 0.25,
    weighs_brightness: true,
    takes_nearest: true,
};

/// What goes in, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Its constants.
    pub frame: &'a FrameData,
    /// The frame.
    pub radiance: &'a [Vec3],
    /// near / view z; 0 where there is no surface.
    pub depth: &'a [f32],
    /// From pixels to where their surfaces were, and near / view z there.
    pub motion: &'a [Vec4],
    /// The picture of the frame before, with the number of its frames, below 0 where something moved.
    pub before: &'a [Vec4],
    /// What makes white 1.
    pub exposure: f32,
}

/// The picture, with the number of frames in it, below 0 where something moves.
#[must_use]
pub fn blend_frames(input: Input<'_>, by: Blend) -> Vec<Vec4> {
    let [width, height] = input.frame.size_px.map(|edge| edge as i32);
    (0..width * height).map(|index| pixel(input, by, IVec2::new(index % width, index / width))).collect()
}

fn pixel(input: Input<'_>, by: Blend, pixel: IVec2) -> Vec4 {
    let here = input.radiance_at(pixel);
    let motion = input.motion_of(by, pixel);
    let at = pixel.as_vec2() + motion.truncate();
    let was_inside = at.cmpge(Vec2::splat(-0.5)).all() && at.cmplt(input.size().as_vec2() - 0.5).all();
    if input.frame.history_is_valid == 0 || motion.z <= 0.0 || !was_inside {
        return here.extend(1.0);
    }
    let count = input.before[input.index((at + 0.5).floor().as_ivec2())].w;
    let moves = at != pixel.as_vec2();
    let is_at_rest = !moves && count > 1.0;
    let share = if is_at_rest { by.clip_at_rest } else { 1.0 };
    let history = input.clipped(by, pixel, input.history_at(at), share);
    let least_weight = if is_at_rest { by.least_weight_at_rest } else { by.least_weight };
    let weight = (1.0 / (count.abs() + 1.0)).max(least_weight);
    let of_here = weight * input.display_weight(by, here);
    let of_history = (1.0 - weight) * input.display_weight(by, history);
    let mean = (of_here * here + of_history * history) / (of_here + of_history);
    let frames = if moves { -1.0 / weight } else { 1.0 / weight };
    if luminance(mean) < 3e38 { mean.extend(frames) } else { here.extend(1.0) }
}

/// Where a camera sees something, in pixels, and its distance along the viewing direction.
fn seen_at(size: IVec2, from_eye: Vec3, [forward, right, up]: [[f32; 3]; 3]) -> Vec3 {
    let [forward, right, up] = [forward, right, up].map(Vec3::from_array);
    let ahead = from_eye.dot(forward);
    let ndc = Vec2::new(from_eye.dot(right) / right.length_squared(), -from_eye.dot(up) / up.length_squared()) / ahead;
    ((ndc * 0.5 + 0.5) * size.as_vec2()).extend(ahead)
}

/// Weights of four texels in a row for a place between the second and the third (Catmull and Rom 1974).
fn sharp_weights(f: f32) -> [f32; 4] {
    [
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (-2.5 + 1.5 * f),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (-0.5 + 0.5 * f),
    ]
}

/// The 3x3 pixels around one.
fn around(pixel: IVec2) -> impl Iterator<Item = IVec2> {
    (0..9).map(move |i| pixel + IVec2::new(i % 3, i / 3) - 1)
}

impl Input<'_> {
    fn size(&self) -> IVec2 {
        IVec2::from_array(self.frame.size_px.map(|edge| edge as i32))
    }

    /// Of the nearest pixel of the picture.
    fn index(&self, pixel: IVec2) -> usize {
        let inside = pixel.clamp(IVec2::ZERO, self.size() - 1);
        (inside.y * self.size().x + inside.x) as usize
    }

    fn radiance_at(&self, pixel: IVec2) -> Vec3 {
        self.radiance[self.index(pixel)]
    }

    fn background_motion(&self, pixel: IVec2) -> Vec3 {
        let data = self.frame;
        let ndc = (pixel.as_vec2() + 0.5) / self.size().as_vec2() * 2.0 - 1.0;
        let direction = Vec3::from_array(data.forward_ws) + ndc.x * Vec3::from_array(data.right_ws)
            - ndc.y * Vec3::from_array(data.up_ws);
        let now = seen_at(self.size(), direction, [data.forward_ws, data.right_ws, data.up_ws]);
        let before = [data.previous_forward_ws, data.previous_right_ws, data.previous_up_ws];
        let before = seen_at(self.size(), direction, before);
        (before.truncate() - now.truncate()).extend(before.z)
    }

    fn motion_of(&self, by: Blend, pixel: IVec2) -> Vec3 {
        let mut nearest = self.index(pixel);
        if by.takes_nearest {
            let mut greatest = 0.0;
            for index in around(pixel).map(|p| self.index(p)) {
                if self.depth[index] > greatest {
                    (nearest, greatest) = (index, self.depth[index]);
                }
            }
        }
        if self.depth[nearest] > 0.0 { self.motion[nearest].truncate() } else { self.background_motion(pixel) }
    }

    fn history_at(&self, at: Vec2) -> Vec3 {
        let (first, share) = (at.floor().as_ivec2() - 1, at - at.floor());
        let [across, down] = [share.x, share.y].map(sharp_weights);
        let tap = |i: usize| {
            let weight = across[i % 4] * down[i / 4];
            let texel = self.before[self.index(first + IVec2::new(i as i32 % 4, i as i32 / 4))];
            if weight == 0.0 { Vec3::ZERO } else { weight * texel.truncate() }
        };
        (0..16).map(tap).sum::<Vec3>().max(Vec3::ZERO)
    }

    /// Exposed radiance with luminances up to 1, as luma and two differences of colour.
    fn comparable(&self, radiance: Vec3) -> Vec3 {
        let exposed = radiance * self.exposure;
        let c = exposed / (1.0 + luminance(exposed));
        Vec3::new(0.25 * c.x + 0.5 * c.y + 0.25 * c.z, 0.5 * (c.x - c.z), 0.5 * c.y - 0.25 * (c.x + c.z))
    }

    fn radiance_of(&self, compared: Vec3) -> Vec3 {
        let rest = compared.x - compared.z;
        let c = Vec3::new(rest + compared.y, compared.x + compared.z, rest - compared.y);
        (c / (self.exposure * (1.0 - luminance(c)).max(1e-6))).max(Vec3::ZERO)
    }

    fn clipped(&self, by: Blend, pixel: IVec2, history: Vec3, share: f32) -> Vec3 {
        let colors: Vec<Vec3> = around(pixel).map(|p| self.comparable(self.radiance_at(p))).collect();
        let mean = colors.iter().sum::<Vec3>() / 9.0;
        let variance = colors.iter().map(|color| (color - mean) * (color - mean)).sum::<Vec3>() / 9.0;
        let deviation = variance.map(f32::sqrt);
        let offset = self.comparable(history) - mean;
        let most = (offset.abs() / (by.most_deviations * deviation).max(Vec3::splat(LEAST_DEVIATION))).max_element();
        if most > 1.0 { self.radiance_of(mean + offset * (1.0 + share * (1.0 / most - 1.0))) } else { history }
    }

    fn display_weight(&self, by: Blend, radiance: Vec3) -> f32 {
        if by.weighs_brightness { 1.0 / (luminance(radiance) * self.exposure).max(1.0) } else { 1.0 }
    }
}
