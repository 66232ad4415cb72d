// Which leaf stands for a point of a triangle. Needs the buffers `triangle_cells` (uvec2: first cell, cells along an edge)
// and `leaf_cells`. Rust: points::PointCloud::leaf_of_hit.
uint leaf_of_hit(uint triangle, vec2 barycentric) {
    uvec2 cells = triangle_cells[triangle];
    uint edge = cells.y;
    vec2 scaled = max(barycentric, vec2(0.0)) * float(edge);
    uint row = min(uint(scaled.x), edge - 1u);
    uint column = min(uint(scaled.y), edge - 1u - row);
    vec2 rest = scaled - vec2(row, column);
    bool points_down = rest.x + rest.y > 1.0 && row + column + 1u < edge;
    return leaf_cells[cells.x + row * (2u * edge - row) + 2u * column + (points_down ? 1u : 0u)];
}
