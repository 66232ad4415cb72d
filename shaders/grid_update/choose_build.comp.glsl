// Whether S1 can go on from what it was last built of, and pays to: the dispatches of either way, and what the next frame is to know
// of this one. One thread.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "shared/BuiltGrid.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 1, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 2, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(set = 0, binding = 3, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 4, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 5, std430) readonly buffer KeptGrid { BuiltGrid kept_grid; };
layout(set = 0, binding = 6, std430) readonly buffer ChangeCount { uint change_count; };
layout(set = 0, binding = 7, std430) writeonly buffer Built { BuiltGrid built_grid; };
// Workgroups over the vertices of S1 where all lights are summed, and where S1 goes on; over the changes; of the passes that list
// the lights.
layout(set = 0, binding = 8, std430) writeonly buffer Dispatches { uint dispatches[]; };
// [0] lights that have changed, of which the list has room for `most_changes`, [1] those that S1 was updated by, [2] words that differ,
// of all frames.
layout(set = 0, binding = 9, std430) buffer UpdateCounts { uint update_counts[]; };
// S1 goes on where at most one of so many lights has changed.
layout(push_constant) uniform Push {
    uint lights_per_change;
    uint most_changes;
    uint lists_all;
    uint sums_all;
    uint groups_over_lights;
    uint groups_over_cells;
    uint groups_over_counts;
};

#include "common/indirect.glsl"
#include "common/level_table.glsl"

bool stands() {
    return kept_grid.vertex_count > 0u && kept_grid.origin_ws == grid.origin_ws && kept_grid.h_top == grid.h_top
        && kept_grid.flux_scale == grid.flux_scale;
}

uint workgroups(uint threads) { return (threads + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE; }

void main() {
    bool goes_on = stands() && change_count <= grid.light_count / lights_per_change;
    uint vertex_count = level_count(1u);
    bool has_all = vertex_count == ranks[end_word(1u)] - ranks[first_word(1u)];
    bool lists = !goes_on || lists_all != 0u;
    write_dispatch(0u, goes_on && sums_all == 0u ? 0u : workgroups(vertex_count));
    write_dispatch(1u, goes_on ? workgroups(vertex_count) : 0u);
    write_dispatch(2u, goes_on ? workgroups(change_count) : 0u);
    write_dispatch(3u, lists ? groups_over_lights : 0u);
    write_dispatch(4u, lists ? groups_over_cells : 0u);
    write_dispatch(5u, lists ? groups_over_counts : 0u);
    built_grid = BuiltGrid(grid.origin_ws, grid.h_top, grid.flux_scale, grid.light_count, light_counts[1],
                           has_all ? vertex_count : 0u);
    update_counts[0] = min(change_count, most_changes);
    update_counts[1] = goes_on ? change_count : 0u;
}
