//! Separable filters with clamped borders.

/// A plane of values, row by row.
#[derive(Clone, Copy)]
pub struct Plane<'a> {
    pub values: &'a [f32],
    pub width: usize,
}

/// Filters with `row` along x and `column` along y; both have odd lengths. The border's values go on beyond it.
pub fn convolve(plane: Plane, row: &[f32], column: &[f32]) -> Vec<f32> {
    along_columns(&along_rows(plane, row), plane.width, column)
}

fn along_rows(plane: Plane, kernel: &[f32]) -> Vec<f32> {
    let (width, radius) = (plane.width, kernel.len() / 2);
    let mut filtered = vec![0.0; plane.values.len()];
    let mut padded = vec![0.0; width + 2 * radius];
    for (source, target) in plane.values.chunks(width).zip(filtered.chunks_mut(width)) {
        padded[..radius].fill(source[0]);
        padded[radius..radius + width].copy_from_slice(source);
        padded[radius + width..].fill(source[width - 1]);
        for (tap, weight) in kernel.iter().enumerate() {
            add_scaled(target, &padded[tap..tap + width], *weight);
        }
    }
    filtered
}

fn along_columns(values: &[f32], width: usize, kernel: &[f32]) -> Vec<f32> {
    let (height, radius) = (values.len() / width, kernel.len() / 2);
    let mut filtered = vec![0.0; values.len()];
    for (y, target) in filtered.chunks_mut(width).enumerate() {
        for (tap, weight) in kernel.iter().enumerate() {
            let source = (y + tap).saturating_sub(radius).min(height - 1);
            add_scaled(target, &values[source * width..(source + 1) * width], *weight);
        }
    }
    filtered
}

fn add_scaled(target: &mut [f32], source: &[f32], weight: f32) {
    for (sum, value) in target.iter_mut().zip(source) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_by_hand_with_its_border() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        let plane = Plane { values: &values, width: 3 };
        // Along x the weights 1, 10, 100 meet the left neighbour, the pixel, the right neighbour.
        assert_eq!(convolve(plane, &[1.0, 10.0, 100.0], &[1.0]), [211.0, 421.0, 442.0, 1688.0, 3368.0, 3536.0]);
        assert_eq!(convolve(plane, &[1.0], &[1.0, 10.0, 100.0]), [811.0, 1622.0, 3244.0, 881.0, 1762.0, 3524.0]);
    }

    #[test]
    fn filters_wider_than_the_plane() {
        let plane = Plane { values: &[3.0], width: 1 };
        assert_eq!(convolve(plane, &[0.2; 5], &[0.2; 5]).len(), 1);
        assert!((convolve(plane, &[0.2; 5], &[0.2; 5])[0] - 3.0).abs() < 1e-6);
    }
}
