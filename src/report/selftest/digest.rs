//! A file of a dump in a few numbers.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::report::dump::diff::{Column, columns, number};
use crate::report::dump::manifest::FileEntry;

/// Resources and fields that devices may leave as they like; without a field all of the resource.
const LEFT_OUT: [(&str, Option<&str>); 4] = [
    // Follows from a limit of the device.
    ("frame_data", Some("rasteriser_step")),
    // Behind the last light there is what was there before. `merged_lights` has the same.
    ("merged_light_texels", None),
    // So there is in the rows of levels that there are not.
    ("sub_images", None),
    // So there is at points that are not lit. What the others have is in `cache_lobes`.
    ("point_irradiance", None),
];

/// One field of an array, or channel of an image.
///
/// Devices round differently, and where a choice hangs on the last bit they choose differently: single numbers say little.
/// Means over all of them stay. Their cube roots are summed, lest the brightest ones be all that counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Digest {
    /// Name of the field or channel.
    pub name: String,
    /// Numbers.
    pub count: u64,
    /// Of these, infinite and not numbers.
    pub not_finite: u64,
    /// Mean of the cube roots; of sets that of the bits set.
    pub mean: f32,
    /// Root of the mean of their squares.
    pub rms: f32,
}

/// What a pass left in a resource.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileDigest {
    /// The pass; `scene` for what the frame is given.
    pub pass: String,
    /// The resource.
    pub resource: String,
    /// Its fields or channels.
    pub columns: Vec<Digest>,
}

impl FileDigest {
    /// Of a file in the folder of a dump.
    ///
    /// # Errors
    /// [`crate::Error::File`] when it cannot be read.
    pub fn of(folder: &Path, file: &FileEntry) -> Result<Self> {
        let scale = |column: &Column| file.scale.get(&column.name).copied().unwrap_or(1.0);
        let mut columns = columns(&folder.join(&file.file), file)?;
        for (_, field) in LEFT_OUT.iter().filter(|(resource, _)| *resource == file.resource) {
            columns.retain(|column| field.is_some_and(|field| column.name != field));
        }
        // Sets, a bit for each member.
        let are_bits = file.resource.ends_with("_bits");
        Ok(Self {
            pass: file.pass.clone(),
            resource: file.resource.clone(),
            columns: columns.iter().map(|column| Digest::of(column, scale(column), are_bits)).collect(),
        })
    }
}

impl Digest {
    fn of(column: &Column, scale: f64, are_bits: bool) -> Self {
        let value = |bytes: &[u8]| {
            let (bits, value) = number(column.scalar, bytes, scale);
            if are_bits { f64::from(bits.count_ones()) } else { value.cbrt() }
        };
        let values = || column.bytes.chunks_exact(column.scalar.bytes()).map(value);
        let finite = || values().filter(|value| value.is_finite());
        let count = values().count();
        let finite_count = finite().count();
        let mean = |sum: f64| (sum / finite_count.max(1) as f64) as f32;
        Self {
            name: column.name.clone(),
            count: count as u64,
            not_finite: (count - finite_count) as u64,
            mean: mean(finite().sum()),
            rms: mean(finite().map(|value| value * value).sum()).sqrt(),
        }
    }

    /// How far another one is from this: the larger of the deviations of mean, spread and count, as a part of the spread and
    /// of the count. Infinite where only the other one has numbers that are not finite.
    #[must_use]
    pub fn deviation(&self, other: &Self) -> f64 {
        if other.not_finite > 0 && self.not_finite == 0 {
            return f64::INFINITY;
        }
        let spread = f64::from(self.rms.max(other.rms)).max(1e-30);
        let of_values = |a: f32, b: f32| (f64::from(a) - f64::from(b)).abs() / spread;
        // A list of few is not another one for having one more.
        let more = self.count.abs_diff(other.count).saturating_sub(2);
        let of_counts = more as f64 / self.count.max(other.count).max(1) as f64;
        let all = [of_values(self.mean, other.mean), of_values(self.rms, other.rms), of_counts];
        if all.iter().any(|deviation| deviation.is_nan()) { f64::INFINITY } else { all.into_iter().fold(0.0, f64::max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dump::Scalar;

    fn floats(values: &[f32]) -> Digest {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Digest::of(&Column { name: "x".to_owned(), scalar: Scalar::F32, bytes }, 1.0, false)
    }

    #[test]
    fn numbers_are_told_by_their_cube_roots() {
        let digest = floats(&[8.0, -8.0, 0.0, f32::NAN]);
        assert_eq!((digest.count, digest.not_finite, digest.mean.to_bits()), (4, 1, 0.0_f32.to_bits()));
        assert!((digest.rms - (8.0_f32 / 3.0).sqrt()).abs() < 1e-6, "{digest:?}");
    }

    #[test]
    fn what_is_another_deviates() {
        let values: Vec<f32> = (0..100).map(|i| (i * i) as f32).collect();
        let digest = floats(&values);
        assert!(digest.deviation(&digest) <= 0.0);
        let rounded: Vec<f32> = values.iter().map(|value| value * 1.000_01).collect();
        assert!(digest.deviation(&floats(&rounded)) < 1e-4);
        let faults: [Vec<f32>; 4] = [
            values.iter().map(|value| 1.2 * value).collect(),
            values.iter().map(|value| -value).collect(),
            values.iter().copied().take(90).chain([0.0; 10]).collect(),
            values.iter().copied().take(99).chain([f32::NAN]).collect(),
        ];
        for fault in faults {
            let deviation = digest.deviation(&floats(&fault));
            assert!(deviation > 0.02, "{deviation}");
        }
        assert!(digest.deviation(&floats(&values[..80])) > 0.02);
    }
}
