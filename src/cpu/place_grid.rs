//! Twin of `bounds/place_grid`.

use super::reduce_bounds::float_from_ordered;
use crate::shared::GridPlacement;

/// Placement of the grids from [`super::reduce_bounds::reduce_bounds`].
#[must_use]
pub fn place_grid(bounds: &[u32; 7], light_count: u32, scene_radius: f32) -> GridPlacement {
    let value = |index: usize| if light_count == 0 { 0.0 } else { float_from_ordered(bounds[index]) };
    let high = [value(0), value(1), value(2)];
    let low = [-value(3), -value(4), -value(5)];
    let extent = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    let edge = extent[0].max(extent[1].max(extent[2])) * 1.0001;
    let edge = edge.max(1e-4 * scene_radius);
    GridPlacement {
        origin_ws: low,
        h_top: edge,
        inverse_h_top: 1.0 / edge,
        flux_scale: if light_count == 0 { 1.0 } else { value(6).max(1e-30) },
        light_count,
        padding: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::lights::LightList;
    use super::super::reduce_bounds::reduce_bounds;
    use super::*;

    #[test]
    fn two_lights_and_none() {
        let mut lights = LightList::default();
        lights.push([1.0, -2.0, 3.0], 0, [0.5, 4.0, 1.0], false);
        lights.push([-1.0, 5.0, 3.0], 0, [0.5, 0.1, 1.0], true);
        let placement = place_grid(&reduce_bounds(&lights), 2, 10.0);
        assert_eq!(placement.origin_ws, [-1.0, -2.0, 3.0]);
        assert!((placement.h_top - 7.0007).abs() < 1e-5);
        assert_eq!(placement.flux_scale, 4.0);
        let empty = place_grid(&[0; 7], 0, 10.0);
        assert_eq!((empty.h_top, empty.flux_scale, empty.origin_ws), (1e-4 * 10.0, 1.0, [0.0; 3]));
    }
}
