// Lists the keys of a set in ascending order, and tells how many there are; those that have no room leave the set. One thread
// per word of bits.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "shared/PointCounts.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) buffer Bits { uint bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 4, std430) buffer Counts { PointCounts counts; };
layout(set = 0, binding = 5, std430) buffer Dispatches { uint dispatches[]; };
layout(push_constant) uniform Push { uint word_count; uint capacity; uint list; };

#include "common/indirect.glsl"

void count_keys() {
    uint total = ranks[word_count];
    uint kept = min(total, capacity);
    if (list == POINT_LIST_PRIMARIES) {
        counts.primary_count = kept;
        counts.primaries_lost = total - kept;
    } else {
        counts.needed_count = kept;
        counts.needed_lost = total - kept;
    }
    uint slot = POINT_DISPATCHES * list;
    write_dispatch(slot + POINT_DISPATCH_GROUP_EACH, kept);
    write_dispatch(slot + POINT_DISPATCH_THREAD_EACH, (kept + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE);
    write_dispatch(slot + POINT_DISPATCH_GROUP_OF_FOUR, (kept + 3u) / 4u);
}

void main() {
    uint word = linear_thread();
    if (word >= word_count) {
        return;
    }
    uint place = ranks[word];
    uint left = bits[word];
    for (; left != 0u && place < capacity; left &= left - 1u) {
        keys[place++] = 32u * word + uint(findLSB(left));
    }
    if (left != 0u) {
        bits[word] &= ~left;
    }
    if (word == 0u) {
        count_keys();
    }
}
