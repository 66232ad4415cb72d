//! Twin of `grid_scatter/resolve_moments`.

use glam::Vec3;

use super::count_lights::LevelTable;
use super::fixed_point::float_from_fixed;
use super::grid::Grid;
use super::scatter_lights::Moments;
use crate::settings::CenterWeight;
use crate::shared::GridLight;

/// Turns the moments of one level into grid lights; `vertex` and `level` are there already.
pub fn resolve_moments(lights: &mut [GridLight], moments: &[Moments], grid: &Grid, table: &LevelTable, level: u32) {
    let scale = grid.placement.flux_scale;
    let h = grid.cell_size(level);
    for record in table.range(level) {
        let moment = |index: usize| float_from_fixed(moments[record][index]);
        let moment3 = |index: usize| Vec3::new(moment(index), moment(index + 1), moment(index + 2));
        let wm = moment(1);
        let wp = if grid.center == CenterWeight::Uniform { moment(0) } else { wm };
        let mean = moment3(2) / wp;
        let variance = (moment3(5) / wp - mean * mean).max(Vec3::ZERO);
        let light = &mut lights[record];
        let vertex = grid.vertex_from_index(light.vertex, level).as_vec3();
        light.position_ws = (Vec3::from_array(grid.placement.origin_ws) + (vertex + mean) * h).to_array();
        light.luminance = wm * scale;
        light.variance = (variance * h * h).to_array();
        light.lobe = (moment3(8) / wm).to_array();
        light.weight = moment(0);
        light.flux = (moment3(11) * scale).to_array();
    }
}

#[cfg(test)]
mod tests {
    use super::super::count_lights::count_lights;
    use super::super::exclusive_scan::exclusive_scan;
    use super::super::lights::LightList;
    use super::super::list_vertices::list_vertices;
    use super::super::mark_lights::mark_lights;
    use super::super::scatter_lights::scatter_lights;
    use super::*;
    use crate::light_grid::Levels;
    use crate::scene::octahedral::pack_octahedral;
    use crate::shared::GridPlacement;

    /// The S1 of lights in a grid of cells of edge 1 with 5 vertices per axis and the origin at 10.
    fn s1(lights: &LightList) -> Vec<GridLight> {
        let placement = GridPlacement {
            origin_ws: [10.0; 3],
            h_top: 4.0,
            inverse_h_top: 0.25,
            flux_scale: 8.0,
            light_count: lights.len() as u32,
            padding: 0,
        };
        let grid = Grid { placement, levels: Levels::new(3), center: CenterWeight::Intensity };
        let mut occupancy = vec![0; grid.levels.total_words() as usize];
        mark_lights(&mut occupancy, &grid, lights, 1..=1);
        let ranks = exclusive_scan(&occupancy);
        let mut table = LevelTable::default();
        count_lights(&mut table, &ranks, grid.levels, 1..=1, 100);
        let mut grid_lights = vec![bytemuck::Zeroable::zeroed(); table.count(1)];
        list_vertices(&mut grid_lights, &occupancy, &ranks, &table, grid.levels, 1..=1);
        let mut moments = vec![[0; 14]; table.count(1)];
        scatter_lights(&mut moments, lights, &grid, &occupancy, &ranks, &table, 1);
        resolve_moments(&mut grid_lights, &moments, &grid, &table, 1);
        grid_lights
    }

    fn close(a: [f32; 3], b: [f32; 3], tolerance: f32) -> bool {
        (0..3).all(|axis| (a[axis] - b[axis]).abs() <= tolerance)
    }

    #[test]
    fn one_light_leaves_eight_weights_at_its_place() {
        let mut lights = LightList::default();
        lights.push([11.25, 12.5, 13.5], pack_octahedral(Vec3::Z), [8.0, 4.0, 0.0], false);
        let grid_lights = s1(&lights);
        assert_eq!(grid_lights.len(), 8);
        let weights: Vec<f32> = grid_lights.iter().map(|l| l.weight).collect();
        assert_eq!(weights, [0.1875, 0.0625, 0.1875, 0.0625, 0.1875, 0.0625, 0.1875, 0.0625]);
        // Vertex (1, 2, 3) of a grid with 5 vertices per axis.
        assert_eq!(grid_lights[0].vertex, (3 * 5 + 2) * 5 + 1);
        for light in &grid_lights {
            assert!(close(light.position_ws, [11.25, 12.5, 13.5], 1e-4), "{light:?}");
            assert!(close(light.variance, [0.0; 3], 1e-4) && close(light.lobe, [0.0, 0.0, 1.0], 1e-5), "{light:?}");
            let m = 0.2126 * 8.0 + 0.7152 * 4.0;
            assert!((light.luminance - light.weight * m).abs() < 1e-5, "{light:?}");
            assert!(close(light.flux, [8.0 * light.weight, 4.0 * light.weight, 0.0], 1e-6), "{light:?}");
        }
    }

    #[test]
    fn two_lights_meet_between_them() {
        let mut lights = LightList::default();
        lights.push([11.25, 12.0, 13.0], pack_octahedral(Vec3::Z), [2.0; 3], false);
        lights.push([10.5, 12.0, 13.0], 0, [2.0; 3], true);
        let grid_lights = s1(&lights);
        // Vertices x = 0, 1, 2. At x = 1 the weights are 3/4 and 1/2: centre 0.15 + 0.8, variance p (1 - p) 0.75^2.
        assert_eq!(grid_lights.len(), 3);
        let middle = &grid_lights[1];
        assert_eq!(middle.weight, 1.25);
        assert!(close(middle.position_ws, [10.95, 12.0, 13.0], 1e-5), "{middle:?}");
        assert!(close(middle.variance, [0.6 * 0.4 * 0.5625, 0.0, 0.0], 1e-5), "{middle:?}");
        assert!(close(middle.lobe, [0.0, 0.0, 0.6], 1e-5), "an isotropic light shortens the lobe: {middle:?}");
        assert!(close(middle.flux, [2.5; 3], 1e-6), "{middle:?}");
    }
}
