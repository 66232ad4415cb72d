// Which primary points stood in the frame before where they stand now, and so see what they saw. One thread for each that
// there is room for.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/kept_slots.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 3, std430) buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
// Key and leaf of each, in ascending order; NOT_KEPT after the last.
layout(set = 0, binding = 6, std430) writeonly buffer Places { uvec2 point_places[]; };
layout(set = 0, binding = 7, std430) readonly buffer PreviousPlaces { uvec2 previous_point_places[]; };
layout(set = 0, binding = 8, std430) writeonly buffer KeptSlots { uint kept_slots[]; };
layout(push_constant) uniform Push { uint capacity; };

// Where a point was among those of the frame before.
uint previous_slot(uvec2 place) {
    uint first = 0u;
    uint count = capacity;
    while (count > 0u) {
        uint half_count = count / 2u;
        bool is_before = previous_point_places[first + half_count].x < place.x;
        first = is_before ? first + half_count + 1u : first;
        count = is_before ? count - half_count - 1u : half_count;
    }
    return first < capacity && previous_point_places[first] == place ? first : NOT_KEPT;
}

void main() {
    uint slot = linear_thread();
    if (slot >= capacity) {
        return;
    }
    uvec2 place = uvec2(NOT_KEPT);
    uint kept = NOT_KEPT;
    if (slot < point_counts.primary_count) {
        uint key = point_primaries[slot];
        uvec4 leaves = primary_leaves[slot];
        place = uvec2(key, leaf_key_of(min(min(leaves.x, leaves.y), min(leaves.z, leaves.w)), key));
        kept = frame.scene_stands != 0u ? previous_slot(place) : NOT_KEPT;
    }
    point_places[slot] = place;
    kept_slots[slot] = kept;
    if (kept != NOT_KEPT) {
        atomicAdd(point_counts.primaries_kept, 1u);
    }
}
