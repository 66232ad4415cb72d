//! Twin of `bounds/reduce_bounds`.

use super::lights::LightList;

/// Maps floats to integers of the same order.
#[must_use]
pub fn ordered_from_float(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits & 0x8000_0000 != 0 { !bits } else { bits | 0x8000_0000 }
}

/// Undoes [`ordered_from_float`].
#[must_use]
pub fn float_from_ordered(ordered: u32) -> f32 {
    f32::from_bits(if ordered & 0x8000_0000 != 0 { ordered & 0x7fff_ffff } else { !ordered })
}

/// `[0..3]` maxima, `[3..6]` maxima of the negated coordinates, `[6]` largest flux component; all ordered.
#[must_use]
pub fn reduce_bounds(lights: &LightList) -> [u32; 7] {
    let mut bounds = [0; 7];
    for light in 0..lights.len() {
        let position = lights.position(light);
        for axis in 0..3 {
            bounds[axis] = bounds[axis].max(ordered_from_float(position[axis]));
            bounds[axis + 3] = bounds[axis + 3].max(ordered_from_float(-position[axis]));
        }
        bounds[6] = bounds[6].max(ordered_from_float(lights.flux(light).max_element()));
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_kept() {
        let values = [f32::MIN, -2.0, -1e-30, 0.0, 1e-30, 2.0, f32::MAX];
        for pair in values.windows(2) {
            assert!(ordered_from_float(pair[0]) < ordered_from_float(pair[1]), "{pair:?}");
        }
        for value in values {
            assert_eq!(float_from_ordered(ordered_from_float(value)), value);
        }
    }

    #[test]
    fn two_lights() {
        let mut lights = LightList::default();
        lights.push([1.0, -2.0, 3.0], 0, [0.5, 4.0, 1.0], false);
        lights.push([-1.0, 5.0, 3.0], 0, [0.5, 0.1, 1.0], true);
        let bounds = reduce_bounds(&lights).map(float_from_ordered);
        assert_eq!(bounds, [1.0, 5.0, 3.0, 1.0, 2.0, -3.0, 4.0]);
    }
}
