//! Directions drawn in proportion to what an environment sends from them.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelExtend, ParallelIterator};
use rayon::slice::ParallelSlice;

use super::resample::Resampled;
use super::{Environment, image_point, row_cosine, texel_solid_angle};
use crate::color::luminance_f64 as luminance;

/// The most cells of a table, along and across the image.
const MOST_CELLS: [u32; 2] = [512, 256];
/// Share of the samples that do not follow the radiance, in each of the two steps: with it no direction is without
/// density, and steps of 32-bit sums stay far below what they sum.
const EVEN_SHARE: f64 = 0.02;

/// Piecewise constant density over all directions, in cells of equal azimuth and polar angle, with the sums that turn two
/// even numbers into a direction: first the row, then the cell in it. This warp can be inverted, and it keeps strata
/// together. Before [`super::turned`].
#[derive(Clone, Debug, PartialEq)]
pub struct SamplingTable {
    /// Cells in a row, and rows.
    pub size: [u32; 2],
    /// As shaders read it: sums of the rows' probabilities, from 0 to 1 (rows + 1 numbers); then for each row the sums of
    /// its cells' probabilities within the row, from 0 to 1 (cells + 1 numbers).
    pub sums: Vec<f32>,
}

/// A direction drawn from a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// Unit vector towards where the light comes from.
    pub direction: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
}

impl SamplingTable {
    /// The table of an environment's image; its suns are not in it.
    #[must_use]
    pub fn new(environment: &Environment) -> Self {
        let image = environment.size;
        let size = [image[0].min(MOST_CELLS[0]), image[1].min(MOST_CELLS[1])];
        let cells = cell_means(environment, size);
        let row_weight = |(row, cells): (u32, &[f64])| cells.iter().sum::<f64>() * texel_solid_angle(size, row);
        let rows: Vec<f64> = (0..).zip(cells.chunks_exact(size[0] as usize)).map(row_weight).collect();
        let sphere = 2.0 * std::f64::consts::TAU;
        let even = |row: u32| texel_solid_angle(size, row) * f64::from(size[0]) / sphere;
        let mut sums = running_sums(&rows, even);
        let within_rows = cells.par_chunks_exact(size[0] as usize);
        sums.par_extend(within_rows.flat_map_iter(|row| running_sums(row, |_| 1.0 / f64::from(size[0]))));
        Self { size, sums }
    }

    /// The direction of two numbers from 0 to below 1: u[0] along a row, u[1] down the rows.
    #[must_use]
    pub fn sample(&self, u: [f32; 2]) -> Visit {
        let (row, down) = find(self.row_sums(), u[1]);
        let (column, along) = find(self.cell_sums(row), u[0]);
        let [width, height] = self.size;
        let azimuth = TAU * ((column as f32 + along) / width as f32 - 0.5);
        let [top, bottom] = [row, row + 1].map(|row| row_cosine(height, row as u32) as f32);
        let y = top + (bottom - top) * down;
        let radius = (1.0 - y * y).max(0.0).sqrt();
        let direction = Vec3::new(radius * azimuth.cos(), y, radius * azimuth.sin());
        Visit { direction, pdf: self.cell_pdf(row, column) }
    }

    /// Density per solid angle of a unit direction.
    #[must_use]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let [row, column] = self.cell_of(direction);
        self.cell_pdf(row, column)
    }

    /// The numbers that [`Self::sample`] makes a direction of.
    #[must_use]
    pub fn numbers_of(&self, direction: Vec3) -> [f32; 2] {
        let [width, height] = self.size;
        let [row, column] = self.cell_of(direction);
        let along = (image_point(direction)[0] * width as f32 - column as f32).clamp(0.0, 1.0);
        let [top, bottom] = [row, row + 1].map(|row| row_cosine(height, row as u32) as f32);
        let down = ((top - direction.y) / (top - bottom)).clamp(0.0, 1.0);
        let within = |sums: &[f32], index: usize, at: f32| sums[index] + (sums[index + 1] - sums[index]) * at;
        [within(self.cell_sums(row), column, along), within(self.row_sums(), row, down)]
    }

    /// Row and column of the cell that a unit direction is in.
    fn cell_of(&self, direction: Vec3) -> [usize; 2] {
        let [u, v] = image_point(direction);
        let index = |at: f32, count: u32| ((at * count as f32) as usize).min(count as usize - 1);
        [index(v, self.size[1]), index(u, self.size[0])]
    }

    fn cell_pdf(&self, row: usize, column: usize) -> f32 {
        let (rows, cells) = (self.row_sums(), self.cell_sums(row));
        let probability = (rows[row + 1] - rows[row]) * (cells[column + 1] - cells[column]);
        probability / texel_solid_angle(self.size, row as u32) as f32
    }

    fn row_sums(&self) -> &[f32] {
        &self.sums[..self.size[1] as usize + 1]
    }

    fn cell_sums(&self, row: usize) -> &[f32] {
        let [width, height] = self.size.map(|count| count as usize);
        let start = height + 1 + row * (width + 1);
        &self.sums[start..=start + width]
    }
}

/// The step that a number falls into, and how far into it, 0 to 1.
fn find(sums: &[f32], number: f32) -> (usize, f32) {
    let step = sums.partition_point(|sum| *sum <= number).clamp(1, sums.len() - 1) - 1;
    let [start, end] = [sums[step], sums[step + 1]];
    (step, ((number - start) / (end - start)).clamp(0.0, 1.0))
}

/// Sums of probabilities in proportion to weights, from 0 to 1, with a share of `even` ones.
fn running_sums(weights: &[f64], even: impl Fn(u32) -> f64) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let probability = |(index, weight): (u32, &f64)| match total > 0.0 {
        true => (1.0 - EVEN_SHARE) * weight / total + EVEN_SHARE * even(index),
        false => even(index),
    };
    let steps = (0..).zip(weights).map(probability);
    let mut sums: Vec<f32> = std::iter::once(0.0)
        .chain(steps.scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum as f32)
        }))
        .collect();
    if let Some(last) = sums.last_mut() {
        *last = 1.0;
    }
    sums
}

/// Mean luminance of what shaders read within each cell: the image, bilinear between its texels.
fn cell_means(environment: &Environment, size: [u32; 2]) -> Vec<f64> {
    let [width, height] = environment.size.map(|count| count as usize);
    let texels: Vec<f64> = environment.radiance.par_iter().map(|texel| luminance(*texel)).collect();
    // The mean of bilinear interpolation over a texel has three quarters of the texel and an eighth of each neighbour,
    // along and across.
    let spread = |before: f64, own: f64, after: f64| 0.125 * before + 0.75 * own + 0.125 * after;
    let along_row =
        |row: &[f64]| (0..width).map(|x| spread(row[(x + width - 1) % width], row[x], row[(x + 1) % width])).collect();
    let along: Vec<Vec<f64>> = texels.par_chunks_exact(width).map(along_row).collect();
    let row = |y: usize| {
        let [above, own, below] = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| &along[y]);
        (0..width).map(move |x| spread(above[x], own[x], below[x]))
    };
    if size == environment.size {
        return (0..height).into_par_iter().flat_map_iter(row).collect();
    }
    let mut cells = Resampled::new(environment.size, size);
    for y in 0..height {
        row(y).enumerate().for_each(|(x, mean)| cells.add(x, y, mean));
    }
    cells.into_texels()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{image_direction, turned};
    use crate::random::{hash, unit_float};

    fn numbers(index: u32) -> [f32; 2] {
        [unit_float(hash(2 * index)), unit_float(hash(2 * index + 1))]
    }

    fn image(size: [u32; 2], texel: impl Fn(u32, u32) -> f32) -> Environment {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Environment { size, radiance: texels.map(|(x, y)| [texel(x, y); 3]).collect(), suns: Vec::new() }
    }

    fn one_bright(size: [u32; 2], at: [u32; 2]) -> Environment {
        image(size, |x, y| if [x, y] == at { 1e6 } else { 0.0 })
    }

    #[test]
    fn samples_have_the_density_that_is_said_and_lead_back_to_their_numbers() {
        let varied = image([13, 7], |x, y| (x * y) as f32 + 0.5);
        for environment in
            [Environment::uniform([1.0; 3]), image([5, 3], |_, _| 0.0), varied, one_bright([64, 32], [9, 2])]
        {
            let table = SamplingTable::new(&environment);
            for index in 0..2_000 {
                let u = numbers(index);
                let Visit { direction, pdf } = table.sample(u);
                assert!((direction.length() - 1.0).abs() < 1e-5 && pdf > 0.0);
                let again = table.pdf(direction);
                assert!((again / pdf - 1.0).abs() < 1e-4, "{again} is not {pdf} at {direction}");
                let back = table.numbers_of(direction);
                assert!(u.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-3), "{u:?} became {back:?}");
            }
        }
    }

    /// Chi-square of samples over cells of the sphere against a density, per degree of freedom.
    fn chi_square(samples: &[Vec3], size: [u32; 2], expected: impl Fn(u32, u32) -> f64) -> f64 {
        let mut counts = vec![0.0; (size[0] * size[1]) as usize];
        for direction in samples {
            let [u, v] = image_point(*direction);
            let index = |at: f32, count: u32| ((at * count as f32) as u32).min(count - 1);
            counts[(index(v, size[1]) * size[0] + index(u, size[0])) as usize] += 1.0;
        }
        let (mut sum, mut cells) = (0.0, 0.0_f64);
        for (y, row) in (0..).zip(counts.chunks_exact(size[0] as usize)) {
            for (x, count) in (0..).zip(row) {
                let wanted = expected(x, y) * samples.len() as f64;
                if wanted > 5.0 {
                    sum += (count - wanted) * (count - wanted) / wanted;
                    cells += 1.0;
                }
            }
        }
        sum / (cells - 1.0).max(1.0)
    }

    #[test]
    fn samples_fall_on_texels_by_their_share_of_the_power() {
        let size = [16, 8];
        let environment = image(size, |x, y| ((x * 5 + y * 3) % 7) as f32 + 0.1);
        let table = SamplingTable::new(&environment);
        let samples: Vec<Vec3> = (0..40_000).map(|index| table.sample(numbers(index)).direction).collect();
        let expected = |x: u32, y: u32| {
            let middle = image_direction([(x as f32 + 0.5) / 16.0, (y as f32 + 0.5) / 8.0]);
            f64::from(table.pdf(middle)) * texel_solid_angle(size, y)
        };
        let total: f64 = (0..8).flat_map(|y| (0..16).map(move |x| (x, y))).map(|(x, y)| expected(x, y)).sum();
        assert!((total - 1.0).abs() < 1e-4, "the density sums to {total}");
        // With 127 degrees of freedom chance keeps it within 0.6 and 1.5.
        let fit = chi_square(&samples, size, expected);
        assert!((0.6..1.5).contains(&fit), "{fit}");
        // Planted: rows the wrong way up, a turn by a texel, rows without their solid angle.
        let upside_down: Vec<Vec3> = samples.iter().map(|d| Vec3::new(d.x, -d.y, d.z)).collect();
        let aside: Vec<Vec3> = samples.iter().map(|d| turned(*d, 22.5)).collect();
        let flat = |x: u32, y: u32| expected(x, y) / texel_solid_angle(size, y) * texel_solid_angle(size, 3);
        for fault in [
            chi_square(&upside_down, size, expected),
            chi_square(&aside, size, expected),
            chi_square(&samples, size, flat),
        ] {
            assert!(fault > 3.0, "{fault}");
        }
    }

    #[test]
    fn means_of_samples_are_integrals() {
        let varied = image([13, 7], |x, y| (x * y) as f32 + 0.5);
        for environment in
            [Environment::uniform([2.0; 3]), varied, one_bright([32, 16], [9, 5]), one_bright([2, 1], [1, 0])]
        {
            let table = SamplingTable::new(&environment);
            let (edge, count) = (512, 512 * 512);
            let sum: f64 = (0..count)
                .map(|index| {
                    let grid = [index % edge, index / edge].map(|cell| (cell as f32 + 0.5) / edge as f32);
                    let Visit { direction, pdf } = table.sample(grid);
                    f64::from(environment.radiance(direction).x / pdf)
                })
                .sum();
            // What shaders read is bilinear, which near the poles is not quite what the texels' solid angles say.
            let even: f64 = (0..count)
                .map(|index| {
                    let point = [index % edge, index / edge].map(|cell| (cell as f32 + 0.5) / edge as f32);
                    let direction = image_direction(point);
                    f64::from(environment.radiance(direction).x) * texel_solid_angle([edge, edge], index / edge)
                })
                .sum();
            let found = sum / f64::from(count);
            assert!((found / even - 1.0).abs() < 0.01, "{found} is not {even} of {:?}", environment.size);
        }
    }

    #[test]
    fn one_bright_texel_gets_most_samples_and_no_direction_is_without_density() {
        let environment = one_bright([64, 32], [9, 2]);
        let table = SamplingTable::new(&environment);
        let bright = (0..10_000).filter(|index| environment.radiance(table.sample(numbers(*index)).direction).x > 0.0);
        // Shaders read some of the bright texel up to the middle of those around it, whose cells count whole: seven eighths
        // of the samples see it along each axis, but for the even share.
        let bright = bright.count();
        assert!((7_000..7_800).contains(&bright), "{bright}");
        for index in 0..10_000 {
            let [u, v] = numbers(index);
            let direction = image_direction([u, v]);
            assert!(table.pdf(direction) > 1e-6, "{direction}");
            // At a corner of the bright texel shaders read a quarter of it, and the cell beyond has a 64th of its weight.
            let weight = environment.radiance(direction).x / table.pdf(direction);
            assert!(weight < 20.0 * environment.scalar_irradiance().x, "{direction}: {weight}");
        }
    }

    #[test]
    fn large_images_have_a_table_of_their_means() {
        let size = [1200, 700];
        let environment = image(size, |x, y| if (x / 30 + y / 20) % 2 == 0 { 1.0 } else { 3.0 });
        let table = SamplingTable::new(&environment);
        assert_eq!((table.size, table.sums.len()), (MOST_CELLS, 257 + 256 * 513));
        let bright = image_direction([0.0375, 10.5 / 700.0]);
        let dark = image_direction([0.0125, 10.5 / 700.0]);
        let ratio = table.pdf(bright) / table.pdf(dark);
        assert!((2.7..3.05).contains(&ratio), "{ratio}");
    }
}
