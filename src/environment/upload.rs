//! What the GPU needs of an environment, as plain data. The upload itself is in `gpu::SceneSet`.

use half::f16;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::{Environment, SamplingTable};
use crate::color::luminance_f64 as luminance;

/// The largest number that is stored, half of what half floats end at.
const LARGEST_STORED: f32 = 32_768.0;

/// An environment in the layouts that shaders read.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedEnvironment {
    /// Width and height of the image.
    pub size_px: [u32; 2],
    /// Four half floats a texel, of which the last is 0.
    pub texels: Vec<[u16; 4]>,
    /// Radiance over what is stored, a power of two.
    pub scale: f32,
    /// Integral of the image's radiance (luminance) over all directions.
    pub scalar_irradiance: f64,
    /// Cells in a row of the table, and rows; 0 where nothing comes from the environment.
    pub cells: [u32; 2],
    /// [`SamplingTable::sums`].
    pub table: Vec<f32>,
}

impl PreparedEnvironment {
    /// Prepares an environment for upload; a black texel stands in for none.
    #[must_use]
    pub fn new(environment: Option<&Environment>) -> Self {
        let lit = environment.filter(|found| found.radiance.iter().flatten().any(|value| *value > 0.0));
        lit.map_or_else(Self::nothing, Self::whole)
    }

    fn nothing() -> Self {
        Self {
            size_px: [1; 2],
            texels: vec![[0; 4]],
            scale: 0.0,
            scalar_irradiance: 0.0,
            cells: [0; 2],
            table: vec![0.0],
        }
    }

    /// Prepares one that is replaced while frames run: all of it, even where it is black.
    #[must_use]
    pub fn whole(environment: &Environment) -> Self {
        let largest = environment.radiance.iter().flatten().fold(0.0_f32, |largest, value| largest.max(*value));
        // Small numbers keep their digits too, so that only the largest decides.
        let scale = (largest / LARGEST_STORED).log2().ceil().clamp(-100.0, 126.0).exp2();
        let stored = |value: f32| f16::from_f32(value / scale).to_bits();
        let texels = environment.radiance.par_iter().map(|[r, g, b]| [stored(*r), stored(*g), stored(*b), 0]).collect();
        let SamplingTable { size: cells, sums: table } = SamplingTable::new(environment);
        let scalar_irradiance = luminance(environment.image_irradiance().to_array());
        Self { size_px: environment.size, texels, scale, scalar_irradiance, cells, table }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(radiance: Vec<[f32; 3]>) -> Environment {
        Environment { size: [radiance.len() as u32, 1], radiance, suns: Vec::new() }
    }

    #[test]
    fn what_is_stored_neither_overflows_nor_vanishes() {
        for factor in [1e-20, 1.0, 1e20, 1e33] {
            let values = [[1.0, 0.5, 1e-6], [1e5, 0.0, 3.0]].map(|texel| texel.map(|value| value * factor));
            let prepared = PreparedEnvironment::new(Some(&image(values.to_vec())));
            for (value, stored) in values.iter().flatten().zip(prepared.texels.iter().flat_map(|texel| &texel[..3])) {
                let found = f16::from_bits(*stored).to_f32() * prepared.scale;
                // The least is at the end of the range, and has few digits.
                let off = if *value < 1e-3 * factor { 0.1 } else { 1e-3 };
                assert!((found - value).abs() <= off * value, "{found} for {value}");
            }
        }
    }

    #[test]
    fn a_black_sky_has_the_cells_of_a_bright_one() {
        let [black, bright] = [0.0, 1.0].map(|value| PreparedEnvironment::whole(&image(vec![[value; 3]; 8])));
        assert_eq!((black.cells, black.size_px, black.table.len()), (bright.cells, bright.size_px, bright.table.len()));
        assert!(black.texels.iter().all(|texel| *texel == [0; 4]) && black.scalar_irradiance == 0.0);
        assert!(black.scale > 0.0 && black.table.iter().all(|sum| sum.is_finite()));
    }

    #[test]
    fn no_light_has_no_cells() {
        let black = PreparedEnvironment::new(Some(&image(vec![[0.0; 3]; 8])));
        assert_eq!(black, PreparedEnvironment::new(None));
        assert_eq!((black.cells, black.size_px), ([0; 2], [1; 2]));
        assert_ne!(PreparedEnvironment::new(Some(&Environment::uniform([0.0, 0.1, 0.0]))).cells, [0; 2]);
    }
}
