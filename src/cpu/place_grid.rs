//! Twin of `bounds/place_grid`.

use super::reduce_bounds::float_from_ordered;
use crate::light_grid::anchor::GridAnchor;
use crate::shared::GridPlacement;

/// Placement of the grids from [`super::reduce_bounds::reduce_bounds`], and from the anchor where there is one.
#[must_use]
pub fn place_grid(bounds: &[u32; 7], light_count: u32, scene_radius: f32, anchor: Option<GridAnchor>) -> GridPlacement {
    let value = |index: usize| if light_count == 0 { 0.0 } else { float_from_ordered(bounds[index]) };
    let high = [value(0), value(1), value(2)];
    let low = [-value(3), -value(4), -value(5)];
    let extent = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    let edge = extent[0].max(extent[1].max(extent[2])) * 1.0001;
    let mut cube = GridAnchor { low_ws: low, edge: edge.max(1e-4 * scene_radius) };
    let mut flux_scale = if light_count == 0 { 1.0 } else { value(6).max(1e-30) };
    if let Some(anchor) = anchor {
        cube = if light_count == 0 { anchor } else { anchor.grown(low, high) };
        flux_scale = power_of_two_above(flux_scale);
    }
    GridPlacement {
        origin_ws: cube.low_ws,
        h_top: cube.edge,
        inverse_h_top: 1.0 / cube.edge,
        flux_scale,
        light_count,
        padding: 0,
    }
}

/// The least power of two that is no less than a value in the range of normal floats.
fn power_of_two_above(value: f32) -> f32 {
    let bits = value.to_bits();
    let exponent = (bits >> 23) + u32::from(bits & 0x7f_ffff != 0);
    f32::from_bits(exponent.min(254) << 23)
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
        let placement = place_grid(&reduce_bounds(&lights), 2, 10.0, None);
        assert_eq!(placement.origin_ws, [-1.0, -2.0, 3.0]);
        assert!((placement.h_top - 7.0007).abs() < 1e-5);
        assert_eq!(placement.flux_scale, 4.0);
        let empty = place_grid(&[0; 7], 0, 10.0, None);
        assert_eq!((empty.h_top, empty.flux_scale, empty.origin_ws), (1e-4 * 10.0, 1.0, [0.0; 3]));
    }

    #[test]
    fn an_anchor_does_not_follow_the_lights() {
        let anchor = Some(GridAnchor { low_ws: [-8.0; 3], edge: 16.0 });
        let placed = |position: [f32; 3], flux: f32| {
            let mut lights = LightList::default();
            lights.push(position, 0, [flux, 0.1, 0.1], false);
            place_grid(&reduce_bounds(&lights), 1, 10.0, anchor)
        };
        let placement = placed([1.0, -2.0, 3.0], 3.0);
        assert_eq!((placement.origin_ws, placement.h_top, placement.flux_scale), ([-8.0; 3], 16.0, 4.0));
        assert_eq!(placed([7.0, 7.5, -8.0], 4.0), placement);
        // A light outside is inside the doubled cube.
        let grown = placed([1.0, -9.0, 3.0], 3.0);
        assert_eq!((grown.origin_ws, grown.h_top), ([-8.0, -24.0, -8.0], 32.0));
        assert_eq!(place_grid(&[0; 7], 0, 10.0, anchor).origin_ws, [-8.0; 3]);
        assert_eq!(
            [1e-30, 1.0, 1.5, f32::MAX].map(power_of_two_above),
            [2.0_f32.powi(-99), 1.0, 2.0, 2.0_f32.powi(127)]
        );
    }
}
