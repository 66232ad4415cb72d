// Automatic exposure from the histogram: half way, in stops, between the one that shows the average of the middle part
// as middle grey and the one that shows the brightest parts as white. One workgroup, each thread some neighbouring bins;
// the result goes to exposure[0]. It is never more than the frame allows, so that stray light in the dark stays dark.
#include "common/frame.glsl"
#include "tone_map/exposure_bins.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Histogram { uint histogram[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Exposure { float exposure[]; };

const uint BINS_PER_THREAD = EXPOSURE_BINS / WORKGROUP_SIZE;
const float MIDDLE_GREY = 0.18;
// The middle part of the picture begins and ends here, and its highlights begin here, in parts of all that counts.
const float MIDDLE_FROM = 0.1;
const float MIDDLE_TO = 0.9;
const float HIGHLIGHTS_FROM = 0.98;
// What is behind the surfaces counts for no more than this part of them, and this part of everything.
const float BACKGROUND_OF_SURFACES = 0.25;
const float BACKGROUND_OF_ALL = 0.01;

shared uvec2 totals[WORKGROUP_SIZE];
shared float ends[WORKGROUP_SIZE];
// Stops in the middle part, times what counts there; what counts there; where the highlights begin, in bins.
shared vec3 parts[WORKGROUP_SIZE];

// Surfaces and background in the histogram. All threads call it.
uvec2 count_all(uint lane) {
    uvec2 sum = uvec2(0u);
    for (uint i = 0u; i < BINS_PER_THREAD; ++i) {
        uint bin = lane * BINS_PER_THREAD + i;
        sum += uvec2(histogram[bin], histogram[EXPOSURE_BINS + bin]);
    }
    totals[lane] = sum;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            totals[lane] += totals[lane + stride];
        }
        barrier();
    }
    return totals[0];
}

// What a pixel of the background counts, where one of a surface counts 1.
float background_weight(uvec2 total) {
    float most = BACKGROUND_OF_SURFACES * float(total.x) + BACKGROUND_OF_ALL * float(total.x + total.y);
    return total.y > 0u ? min(most / float(total.y), 1.0) : 0.0;
}

// Sum of `value` over the threads up to this one. All threads call it.
float inclusive_sum(uint lane, float value) {
    ends[lane] = value;
    barrier();
    for (uint stride = 1u; stride < WORKGROUP_SIZE; stride *= 2u) {
        float before = lane >= stride ? ends[lane - stride] : 0.0;
        barrier();
        ends[lane] += before;
        barrier();
    }
    return ends[lane];
}

// The parts of all threads together. All threads call it.
vec3 join_parts(uint lane, vec3 own) {
    parts[lane] = own;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            vec3 other = parts[lane + stride];
            parts[lane] = vec3(parts[lane].xy + other.xy, max(parts[lane].z, other.z));
        }
        barrier();
    }
    return parts[0];
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    float weight = background_weight(count_all(lane));
    float counts[BINS_PER_THREAD];
    float own = 0.0;
    for (uint i = 0u; i < BINS_PER_THREAD; ++i) {
        uint bin = lane * BINS_PER_THREAD + i;
        counts[i] = float(histogram[bin]) + weight * float(histogram[EXPOSURE_BINS + bin]);
        own += counts[i];
    }
    float start = inclusive_sum(lane, own) - own;
    float total = ends[WORKGROUP_SIZE - 1u];
    vec3 part = vec3(0.0);
    for (uint i = 0u; i < BINS_PER_THREAD; ++i) {
        float bin = float(lane * BINS_PER_THREAD + i);
        float end = start + counts[i];
        float middle = max(min(end, MIDDLE_TO * total) - max(start, MIDDLE_FROM * total), 0.0);
        part.xy += middle * vec2(stops_at(bin + 0.5), 1.0);
        if (counts[i] > 0.0 && start < HIGHLIGHTS_FROM * total) {
            part.z = bin + min((HIGHLIGHTS_FROM * total - start) / counts[i], 1.0);
        }
        start = end;
    }
    part = join_parts(lane, part);
    if (lane == 0u) {
        float for_grey = log2(MIDDLE_GREY) - part.x / part.y;
        float for_white = -stops_at(part.z);
        float automatic = part.y > 0.0 ? exp2(0.5 * (for_grey + for_white)) : 1.0;
        if (frame.exposure < 0.0) {
            automatic = min(automatic, -frame.exposure);
        }
        exposure[0] = frame.exposure_compensation * (frame.exposure > 0.0 ? frame.exposure : automatic);
    }
}
