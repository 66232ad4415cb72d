//! CPU twins of the compute stages: same names, same arithmetic, compared stage by stage in the tests.

pub mod compact_vpls;
pub mod count_lights;
pub mod deal_lights;
pub mod exclusive_scan;
pub mod exposure;
pub mod fixed_point;
pub mod gather_below;
pub mod gather_vertex;
pub mod grid;
pub mod lights;
pub mod list_vertices;
pub mod mark_grid_lights;
pub mod mark_lights;
pub mod merge_lights;
pub mod place_grid;
pub mod reduce_bounds;
pub mod reservoir;
pub mod resolve_moments;
pub mod scatter_lights;
pub mod tone_map;
