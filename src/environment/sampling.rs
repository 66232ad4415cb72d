//! Directions drawn in proportion to what an environment sends from them.

use std::f32::consts::TAU;

use glam::Vec3;

use super::{Environment, image_point, luminance, row_cosine, texel_solid_angle};

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
        for row in cells.chunks_exact(size[0] as usize) {
            sums.extend(running_sums(row, |_| 1.0 / f64::from(size[0])));
        }
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
    let texel = |x: usize, y: usize| luminance(environment.radiance[y * width + x]);
    // The mean of bilinear interpolation over a texel has three quarters of the texel and an eighth of each neighbour,
    // along and across.
    let spread = |before: f64, own: f64, after: f64| 0.125 * before + 0.75 * own + 0.125 * after;
    let along = |x: usize, y: usize| spread(texel((x + width - 1) % width, y), texel(x, y), texel((x + 1) % width, y));
    let mut sums = vec![0.0; (size[0] * size[1]) as usize];
    let (columns, rows) = (overlaps(width, size[0] as usize), overlaps(height, size[1] as usize));
    let lines: Vec<f64> = (0..height).flat_map(|y| (0..width).map(move |x| along(x, y))).collect();
    for y in 0..height {
        let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
        for x in 0..width {
            let mean = spread(lines[above * width + x], lines[y * width + x], lines[below * width + x]);
            for (row, high) in &rows[y] {
                for (column, wide) in &columns[x] {
                    sums[row * size[0] as usize + column] += mean * high * wide;
                }
            }
        }
    }
    sums
}

/// For each of `texels` parts of an edge, which of `cells` parts it lies in, and its share of each.
fn overlaps(texels: usize, cells: usize) -> Vec<Vec<(usize, f64)>> {
    let scale = cells as f64 / texels as f64;
    let parts = |texel: usize| {
        let (start, end) = (texel as f64 * scale, (texel + 1) as f64 * scale);
        let share = move |cell: usize| (end.min((cell + 1) as f64) - start.max(cell as f64)).max(0.0);
        (start as usize..cells).take_while(move |cell| (*cell as f64) < end).map(move |cell| (cell, share(cell)))
    };
    (0..texels).map(|texel| parts(texel).filter(|(_, share)| *share > 0.0).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
