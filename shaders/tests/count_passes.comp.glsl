// Two loops after each other that count their passes: a device that ends loops early counts fewer. One thread. A test's
// shader.
layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std430) writeonly buffer Counts { uint counts[]; };
layout(push_constant) uniform Push { uint first; uint second; };

void main() {
    uint count = 0u;
    uint state = first;
    // What a pass does depends on the one before, so that the loop cannot be replaced by its result.
    for (uint i = 0u; i < first; ++i) {
        state = state * 747796405u + 2891336453u;
        count += (state >> 31u) | 1u;
    }
    counts[0] = count;
    count = 0u;
    for (uint i = 0u; i < second; ++i) {
        state = state * 747796405u + 2891336453u;
        count += (state >> 31u) | 1u;
    }
    counts[1] = count;
}
