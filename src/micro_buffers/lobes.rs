//! Lobes that a micro-buffer is convolved with: cosines about the directions of a 5x5 paraboloid.

use glam::{DVec2, DVec3};

use super::disc_point;
use crate::shared::LOBE_EDGE;

/// Number of lobes.
pub const LOBES: u32 = LOBE_EDGE * LOBE_EDGE;

/// Axes of the lobes, row by row; those of the corners lie below the horizon.
#[must_use]
pub fn lobe_directions() -> Vec<DVec3> {
    let place = |i: u32| (f64::from(i) + 0.5) * 2.0 / f64::from(LOBE_EDGE) - 1.0;
    let direction = |i: u32| {
        let point = DVec2::new(place(i % LOBE_EDGE), place(i / LOBE_EDGE));
        let s = point.length_squared();
        DVec3::new(2.0 * point.x, 2.0 * point.y, 1.0 - s) / (1.0 + s)
    };
    (0..LOBES).map(direction).collect()
}

/// Where among the lobes a normal lies: column and row, 0 at the middle of the first.
#[must_use]
pub fn lobe_place(normal: DVec3) -> DVec2 {
    let edge = f64::from(LOBE_EDGE);
    ((disc_point(normal) + 1.0) * (0.5 * edge) - 0.5).clamp(DVec2::ZERO, DVec2::splat(edge - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_lie_where_their_axes_do() {
        for (i, direction) in (0_u32..).zip(lobe_directions()) {
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let place = DVec2::new((i % LOBE_EDGE).into(), (i / LOBE_EDGE).into());
            assert!(lobe_place(direction).distance(place) < 1e-9, "lobe {i}: {direction}");
        }
        assert!(lobe_directions()[12].distance(DVec3::Z) < 1e-12);
        assert!(lobe_directions()[0].z < 0.0 && lobe_directions()[1].z > 0.0);
    }
}
