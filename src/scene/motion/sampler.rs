//! Values between keys.

use glam::{Quat, Vec4};

/// How values follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Between {
    /// The earlier key's value holds.
    Step,
    /// A straight line; the shorter arc of a rotation.
    Linear,
    /// Hermite's spline with a tangent before and after each key.
    CubicSpline,
}

/// Keys of one property.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Sampler {
    times_s: Vec<f32>,
    values: Vec<f32>,
    /// Numbers of one value.
    width: usize,
    between: Between,
    is_rotation: bool,
}

impl Sampler {
    /// Keys in the order of their times; a spline has a tangent, a value and another tangent at each.
    ///
    /// # Errors
    /// What is wrong with them, in a few words.
    pub fn new(
        times_s: Vec<f32>,
        values: Vec<f32>,
        width: usize,
        between: Between,
        is_rotation: bool,
    ) -> Result<Self, &'static str> {
        let per_key = width * if between == Between::CubicSpline { 3 } else { 1 };
        if times_s.is_empty() || width == 0 {
            return Err("without keys");
        }
        if times_s.len() * per_key != values.len() {
            return Err("whose values are not as many as its keys");
        }
        if !times_s.iter().chain(&values).all(|number| number.is_finite()) {
            return Err("with a number that is not finite");
        }
        if times_s[0] < 0.0 || times_s.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("whose keys are out of order");
        }
        let sampler = Self { times_s, values, width, between, is_rotation };
        if is_rotation && (0..sampler.times_s.len()).any(|key| quaternion(sampler.value(key)).length() < 1e-6) {
            return Err("with a rotation that is none");
        }
        Ok(sampler)
    }

    /// Times of the keys in seconds.
    pub fn times_s(&self) -> &[f32] {
        &self.times_s
    }

    /// The value at a time; the first and the last key's hold outside.
    pub fn at(&self, time_s: f32) -> Vec<f32> {
        let next = self.times_s.partition_point(|key_s| *key_s <= time_s);
        let value = match next {
            0 => self.value(0).to_vec(),
            next if next == self.times_s.len() => self.value(next - 1).to_vec(),
            next => self.within(next - 1, time_s),
        };
        if self.is_rotation { normalized(&value).unwrap_or_else(|| self.value(0).to_vec()) } else { value }
    }

    /// Between a key and the next.
    fn within(&self, key: usize, time_s: f32) -> Vec<f32> {
        let step_s = self.times_s[key + 1] - self.times_s[key];
        let t = ((time_s - self.times_s[key]) / step_s).clamp(0.0, 1.0);
        let (from, to) = (self.value(key), self.value(key + 1));
        match self.between {
            Between::Step => from.to_vec(),
            Between::Linear if self.is_rotation => {
                let turned = quaternion(from).normalize().slerp(quaternion(to).normalize(), t);
                turned.to_array().to_vec()
            }
            Between::Linear => from.iter().zip(to).map(|(from, to)| from + (to - from) * t).collect(),
            Between::CubicSpline => {
                let (out, into) = (self.part(key, 2), self.part(key + 1, 0));
                let (t2, t3) = (t * t, t * t * t);
                let value = |i: usize| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                        + step_s * (t3 - 2.0 * t2 + t) * out[i]
                        + (3.0 * t2 - 2.0 * t3) * to[i]
                        + step_s * (t3 - t2) * into[i]
                };
                (0..self.width).map(value).collect()
            }
        }
    }

    fn value(&self, key: usize) -> &[f32] {
        if self.between == Between::CubicSpline { self.part(key, 1) } else { self.slice(key) }
    }

    /// Tangent before, value or tangent after a key of a spline.
    fn part(&self, key: usize, part: usize) -> &[f32] {
        self.slice(3 * key + part)
    }

    fn slice(&self, index: usize) -> &[f32] {
        &self.values[index * self.width..(index + 1) * self.width]
    }
}

fn quaternion(value: &[f32]) -> Quat {
    Quat::from_vec4(Vec4::from_slice(value))
}

/// A quaternion of length 1, where it has a direction.
fn normalized(value: &[f32]) -> Option<Vec<f32>> {
    Some(Vec4::from_slice(value).try_normalize()?.to_array().to_vec())
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, PI};

    use super::*;

    fn sampler(between: Between, values: &[f32]) -> Sampler {
        Sampler::new(vec![1.0, 2.0, 4.0], values.to_vec(), 1, between, false).unwrap()
    }

    fn near(found: &[f32], expected: &[f32]) -> bool {
        found.len() == expected.len()
            && found.iter().zip(expected).all(|(f, e)| (f - e).abs() <= 1e-6 * e.abs().max(1.0))
    }

    #[test]
    fn values_at_between_and_outside_keys() {
        let times = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0];
        let at = |sampler: &Sampler| times.map(|t| sampler.at(t)[0]);
        assert!(near(&at(&sampler(Between::Step, &[5.0, 7.0, 3.0])), &[5.0, 5.0, 5.0, 7.0, 7.0, 3.0, 3.0]));
        assert!(near(&at(&sampler(Between::Linear, &[5.0, 7.0, 3.0])), &[5.0, 5.0, 6.0, 7.0, 5.0, 3.0, 3.0]));
        // Tangents of 0 ease in and out; that of the middle key leaves it at 2 per second.
        let keys = [0.0, 5.0, 0.0, 0.0, 7.0, 2.0, 0.0, 3.0, 0.0];
        let found = at(&sampler(Between::CubicSpline, &keys));
        // At half of an interval: the mean, and an eighth of its length times the difference of the tangents.
        assert!(near(&found, &[5.0, 5.0, 6.0, 7.0, 5.0 + 2.0 * 2.0 / 8.0, 3.0, 3.0]), "{found:?}");
    }

    #[test]
    fn a_spline_with_the_tangents_of_a_line_is_the_line() {
        let keys = [3.0, 5.0, 3.0, 3.0, 8.0, 3.0, 3.0, 14.0, 3.0];
        let spline = sampler(Between::CubicSpline, &keys);
        for t in [1.1, 1.7, 2.3, 3.9] {
            assert!(near(&spline.at(t), &[5.0 + 3.0 * (t - 1.0)]), "{t}: {:?}", spline.at(t));
        }
    }

    #[test]
    fn rotations_take_the_shorter_arc_at_an_even_pace() {
        let about_y = |angle: f32| Quat::from_rotation_y(angle);
        // The second key is the same rotation with the other sign.
        let values = [about_y(0.0).to_array(), (-about_y(FRAC_PI_2)).to_array()].concat();
        let turn = Sampler::new(vec![0.0, 1.0], values, 4, Between::Linear, true).unwrap();
        for t in [0.25, 0.5, 0.9] {
            let found = quaternion(&turn.at(t));
            assert!(found.dot(about_y(t * FRAC_PI_2)).abs() >= 1.0 - 1e-6, "{t}: {found}");
        }
        let half = about_y(PI / 2.0).to_array();
        let spline = [[0.0; 4], about_y(0.0).to_array(), [0.0; 4], [0.0; 4], half, [0.0; 4]].concat();
        let spline = Sampler::new(vec![0.0, 1.0], spline, 4, Between::CubicSpline, true).unwrap();
        let found = quaternion(&spline.at(0.5));
        assert!((found.length() - 1.0).abs() <= 1e-6 && found.dot(about_y(PI / 4.0)).abs() >= 1.0 - 1e-6, "{found}");
    }

    #[test]
    fn bad_keys_are_named() {
        let complaint = |times: &[f32], values: &[f32], width| {
            Sampler::new(times.to_vec(), values.to_vec(), width, Between::Linear, width == 4).unwrap_err()
        };
        assert!(complaint(&[0.0, 2.0, 1.0], &[0.0; 3], 1).contains("out of order"));
        assert!(complaint(&[0.0, 0.0], &[0.0; 2], 1).contains("out of order"));
        assert!(complaint(&[-1.0, 0.0], &[0.0; 2], 1).contains("out of order"));
        assert!(complaint(&[0.0, f32::NAN], &[0.0; 2], 1).contains("not finite"));
        assert!(complaint(&[0.0, 1.0], &[0.0, f32::INFINITY], 1).contains("not finite"));
        assert!(complaint(&[0.0, 1.0], &[0.0; 3], 1).contains("not as many"));
        assert!(complaint(&[], &[], 1).contains("without keys"));
        assert!(complaint(&[0.0], &[0.0; 4], 4).contains("rotation"));
    }
}
