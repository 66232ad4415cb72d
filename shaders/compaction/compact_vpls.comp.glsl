// Packs the VPLs of some path slots into the list of lights S0, in slot order; those of the last slots are followed by the
// scene's own point lights when they take part. One thread per slot and per scene light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer SlotPositions { uvec4 slot_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer SlotFluxes { vec4 slot_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer SlotBits { uint slot_bits[]; };
layout(set = 0, binding = 4, std430) readonly buffer SlotRanks { uint slot_ranks[]; };
// S0: position (as bits, since a packed normal may look like a NaN) and octahedral normal; flux and 1 for VPLs, 0 for lights that shine in all directions.
layout(set = 0, binding = 5, std430) writeonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 6, std430) writeonly buffer LightFluxes { vec4 light_fluxes[]; };
// light_counts: [0] lights in S0, [1] VPLs among them, [2] VPLs that did not fit.
layout(set = 0, binding = 7, std430) buffer LightCounts { uint light_counts[]; };
// Slots from `first_slot` to `end_slot`, those in memory, of `slot_count`; later ones have no VPLs yet.
layout(push_constant) uniform Push { uint first_slot; uint end_slot; uint slot_count; };

void main() {
    uint index = first_slot + linear_thread();
    uint vpl_count = min(slot_ranks[(slot_count + 31u) / 32u], frame.vpl_capacity);
    uint scene_light_count = frame.scene_lights;
    if (index == first_slot) {
        light_counts[0] = vpl_count + scene_light_count;
        light_counts[1] = vpl_count;
        light_counts[2] = slot_ranks[(slot_count + 31u) / 32u] - vpl_count;
    }
    if (index < end_slot) {
        uint word = slot_bits[index / 32u];
        uint bit = 1u << (index % 32u);
        uint target = slot_ranks[index / 32u] + uint(bitCount(word & (bit - 1u)));
        if ((word & bit) != 0u && target < frame.vpl_capacity) {
            light_positions[target] = slot_positions[index - first_slot];
            light_fluxes[target] = slot_fluxes[index - first_slot];
        }
    } else if (end_slot == slot_count && index - slot_count < scene_light_count) {
        PunctualLight light = punctual_lights[frame.first_point_light + index - slot_count];
        uint target = vpl_count + index - slot_count;
        light_positions[target] = uvec4(floatBitsToUint(light.position_ws), pack_octahedral(vec3(0.0, 1.0, 0.0)));
        light_fluxes[target] = vec4(light.intensity * 4.0 * PI, 0.0);
    }
}
