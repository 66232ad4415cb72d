//! Comparators. Each says where it failed, and each is itself tested with a planted fault.

use std::fmt::Debug;

use glam::Vec3;
use gridlight::cpu::count_lights::LevelTable;
use gridlight::cpu::grid::Grid;
use gridlight::cpu::lights::LightList;
use gridlight::shared::GridLight;

/// What a comparator found.
pub type Verdict = Result<(), String>;

/// Equality; names the first index that differs.
pub fn exact<T: PartialEq + Debug>(what: &str, gpu: &[T], twin: &[T]) -> Verdict {
    if gpu.len() != twin.len() {
        return Err(format!("{what}: {} entries on the GPU, {} in the twin", gpu.len(), twin.len()));
    }
    match (0..gpu.len()).find(|i| gpu[*i] != twin[*i]) {
        Some(i) => Err(format!("{what}[{i}]: {:?} on the GPU, {:?} in the twin", gpu[i], twin[i])),
        None => Ok(()),
    }
}

/// Grid lights: vertex and level equal, the rest within tolerance.
///
/// The sums are the same fixed-point numbers, or float sums in the same order; but a device may fuse a multiply
/// with an add and may be 2.5 ulp off in a division, and 1e-5 is some eighty such steps. Fixed-point terms resolve
/// 2^-40 of the largest flux, so what is divided by the luminance may err by that much.
/// Positions also round in world space. Lengths are in cells of the light's level.
pub fn grid_lights(gpu: &[GridLight], twin: &[GridLight], grid: &Grid, first: usize) -> Verdict {
    if gpu.len() != twin.len() {
        return Err(format!("{} grid lights on the GPU, {} in the twin", gpu.len(), twin.len()));
    }
    for (index, (a, b)) in gpu.iter().zip(twin).enumerate() {
        if let Some(field) = different_field(a, b, grid) {
            return Err(format!("grid light {}: {field}: {a:?} on the GPU, {b:?} in the twin", first + index));
        }
    }
    Ok(())
}

/// False for what is not a number, and where the tolerance is none.
pub fn within<T: Into<f64>>(difference: T, tolerance: T) -> bool {
    let tolerance = tolerance.into();
    tolerance.is_finite() && difference.into().abs() <= tolerance
}

/// [`within`] in every component. The largest component would not do: `max` drops what is not a number.
pub fn near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
    (a - b).to_array().iter().all(|difference| within(*difference, tolerance))
}

/// The first of `values` that is infinite or no number, as a complaint.
pub fn all_finite(what: &str, values: &[Vec3]) -> Verdict {
    match values.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(format!("{what}[{i}] is {}", values[i])),
        None => Ok(()),
    }
}

fn different_field(a: &GridLight, b: &GridLight, grid: &Grid) -> Option<&'static str> {
    if (a.vertex, a.level) != (b.vertex, b.level) {
        return Some("vertex or level");
    }
    let h = grid.cell_size(b.level);
    let unit = grid.placement.flux_scale * 2.0_f32.powi(-40);
    let mean = 1e-5 + unit / b.luminance;
    let far = |a: [f32; 3], b: [f32; 3], relative: f32, absolute: f32| {
        (0..3).any(|i| !within(a[i] - b[i], relative * b[i].abs() + absolute))
    };
    let checks = [
        ("position", far(a.position_ws, b.position_ws, 4.0 * f32::EPSILON, h * mean)),
        ("variance", far(a.variance, b.variance, 1e-4, h * h * mean)),
        ("lobe", far(a.lobe, b.lobe, 1e-5, mean)),
        ("flux", far(a.flux, b.flux, 1e-5, unit)),
        ("luminance", far([a.luminance; 3], [b.luminance; 3], 1e-5, unit)),
        ("weight", far([a.weight; 3], [b.weight; 3], 1e-5, 1e-7)),
    ];
    checks.iter().find(|(_, differs)| *differs).map(|(field, _)| *field)
}

/// The flux of every level is that of the lights, within `tolerance` of the total. Lights lose at most a weight of
/// 1e-6 per corner.
pub fn flux_is_kept(
    lights: &LightList,
    grid_lights: &[GridLight],
    table: &LevelTable,
    top: u32,
    tolerance: f64,
) -> Verdict {
    let wanted = total(lights.fluxes.iter().map(|f| [f[0], f[1], f[2]]));
    for level in 1..=top {
        let found = total(grid_lights[table.range(level)].iter().map(|l| l.flux));
        for channel in 0..3 {
            let (found, wanted) = (found[channel], wanted[channel]);
            if !within(found - wanted, tolerance * wanted) {
                return Err(format!("level {level}, channel {channel}: flux {found}, that of the lights is {wanted}"));
            }
        }
    }
    Ok(())
}

fn total(fluxes: impl Iterator<Item = [f32; 3]>) -> [f64; 3] {
    fluxes.fold([0.0; 3], |sum, flux| std::array::from_fn(|i| sum[i] + f64::from(flux[i])))
}

/// No grid light is empty, and each lies within a cell of its vertex. `resolution` is the error of one light's
/// fixed-point terms in units of the largest flux: it moves the centres of the dimmest lights.
pub fn none_is_empty_or_astray(lights: &[GridLight], grid: &Grid, resolution: f32) -> Verdict {
    let all_terms = grid.placement.light_count as f32 * resolution * grid.placement.flux_scale;
    for (index, light) in lights.iter().enumerate() {
        if !(light.luminance > 0.0 && light.weight > 0.0) {
            return Err(format!("grid light {index} is empty: {light:?}"));
        }
        let vertex = grid.vertex_from_index(light.vertex, light.level).as_vec3();
        let h = grid.cell_size(light.level);
        let largest = light.position_ws.iter().fold(0.0_f32, |m, p| m.max(p.abs()));
        for axis in 0..3 {
            let cells = (light.position_ws[axis] - grid.placement.origin_ws[axis]) / h - vertex[axis];
            // A thousandth of a cell for rounding, and the coordinates' own.
            let rounding = 1e-3 + 4.0 * f32::EPSILON * largest / h;
            if !within(cells, 1.0 + rounding + all_terms / light.luminance) {
                return Err(format!("grid light {index} is {cells} cells from its vertex: {light:?}"));
            }
        }
    }
    Ok(())
}

/// Chi-square of counts against expected frequencies.
pub fn chi_square(counts: &[u64], weights: &[f64]) -> f64 {
    let draws = counts.iter().sum::<u64>() as f64;
    let total: f64 = weights.iter().sum();
    counts.iter().zip(weights).map(|(n, w)| (*n as f64 - draws * w / total).powi(2) / (draws * w / total)).sum()
}
