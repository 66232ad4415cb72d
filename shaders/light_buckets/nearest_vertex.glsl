// Rank of the vertex of S1 that lies nearest to a light, which is always occupied; NO_LIGHT where its grid light did not
// fit. Needs what grid_light_at needs.
uint nearest_vertex(vec3 position_ws) {
    uint light = grid_light_at(uvec3(round(grid_position(position_ws, grid, 1u))), 1u);
    return light == NO_LIGHT ? NO_LIGHT : light - level_first(1u);
}
