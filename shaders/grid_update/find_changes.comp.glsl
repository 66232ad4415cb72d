// Lists the slots whose lights differ to the bit from those that S1 was last built of. The slots of the light paths are followed by
// one for each light of the scene. One thread per slot; the order of the list is left to chance.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"
#include "shared/BuiltGrid.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer SlotBits { uint slot_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer SlotRanks { uint slot_ranks[]; };
layout(set = 0, binding = 3, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 4, std430) readonly buffer LightFluxes { uvec4 light_fluxes[]; };
layout(set = 0, binding = 5, std430) readonly buffer LightCounts { uint light_counts[]; };
// The same of the last build.
layout(set = 0, binding = 6, std430) readonly buffer KeptSlotBits { uint kept_slot_bits[]; };
layout(set = 0, binding = 7, std430) readonly buffer KeptSlotRanks { uint kept_slot_ranks[]; };
layout(set = 0, binding = 8, std430) readonly buffer KeptPositions { uvec4 kept_positions[]; };
layout(set = 0, binding = 9, std430) readonly buffer KeptFluxes { uvec4 kept_fluxes[]; };
layout(set = 0, binding = 10, std430) readonly buffer KeptGrid { BuiltGrid kept_grid; };
layout(set = 0, binding = 11, std430) coherent buffer ChangeCount { uint change_count; };
// For each slot the light in it before and now, NO_LIGHT where there is none.
layout(set = 0, binding = 12, std430) writeonly buffer Changes { uvec2 changes[]; };
layout(push_constant) uniform Push { uint slot_count; };

// The light of a slot, in a list that begins with those of `vpl_count` slots.
uint light_of_bit(uint slot, uint word, uint rank, uint vpl_count) {
    uint bit = 1u << (slot % 32u);
    uint light = rank + uint(bitCount(word & (bit - 1u)));
    return (word & bit) != 0u && light < vpl_count ? light : NO_LIGHT;
}

// The light of the scene that has a slot behind those of the light paths.
uint scene_light(uint slot, uint vpl_count, uint light_count) {
    uint light = vpl_count + slot - slot_count;
    return light < light_count ? light : NO_LIGHT;
}

uint light_now(uint slot) {
    return slot < slot_count ? light_of_bit(slot, slot_bits[slot / 32u], slot_ranks[slot / 32u], light_counts[1])
                             : scene_light(slot, light_counts[1], light_counts[0]);
}

uint light_before(uint slot) {
    if (kept_grid.vertex_count == 0u) {
        return NO_LIGHT;
    }
    return slot < slot_count
        ? light_of_bit(slot, kept_slot_bits[slot / 32u], kept_slot_ranks[slot / 32u], kept_grid.vpl_count)
        : scene_light(slot, kept_grid.vpl_count, kept_grid.light_count);
}

bool differ(uint before, uint now) {
    if (before == NO_LIGHT || now == NO_LIGHT) {
        return before != now;
    }
    return kept_positions[before] != light_positions[now] || kept_fluxes[before] != light_fluxes[now];
}

void main() {
    uint slot = linear_thread();
    // Once the list is full S1 is built anew, however many more have changed.
    if (slot >= slot_count + frame.scene_lights || change_count >= uint(changes.length())) {
        return;
    }
    uvec2 lights = uvec2(light_before(slot), light_now(slot));
    if (differ(lights.x, lights.y)) {
        uint place = atomicAdd(change_count, 1u);
        if (place < uint(changes.length())) {
            changes[place] = lights;
        }
    }
}
