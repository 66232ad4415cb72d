// Turns the ranks of levels first..last into the level table and into indirect arguments. One thread.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 1, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 2, std430) buffer LevelTable { uint level_table[]; };
// dispatches[l] for level l: workgroups of WORKGROUP_SIZE over its lights for l = 1, one per light above;
// dispatches[0]: workgroups over all grid lights; dispatches[MAX_LEVEL + 1 + l]: workgroups over level l.
layout(set = 0, binding = 3, std430) writeonly buffer Dispatches { uint dispatches[]; };
layout(push_constant) uniform Push { uint first_counted; uint last_counted; uint capacity; };

#include "common/indirect.glsl"

void main() {
    uint first = first_counted == 1u ? 0u : level_table[2u * (first_counted - 1u)] + level_table[2u * first_counted - 1u];
    for (uint level = first_counted; level <= last_counted; ++level) {
        uint count = ranks[end_word(level)] - ranks[first_word(level)];
        // Never past the capacity; what is lost shows in the overflow count.
        uint kept = min(count, capacity - min(first, capacity));
        level_table[2u * level] = first;
        level_table[2u * level + 1u] = kept;
        if (kept < count) {
            level_table[2u * (MAX_LEVEL + 2u)] += count - kept;
        }
        first += kept;
        write_dispatch(level, level == 1u ? (kept + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE : kept);
        write_dispatch(MAX_LEVEL + 1u + level, (kept + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE);
    }
    level_table[2u * (last_counted + 1u)] = first;
    write_dispatch(0u, (first + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE);
}
