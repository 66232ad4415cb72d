// Sum of a colour over a workgroup of POINT_LANES, always in the same order.
shared float lane_sums[3u * POINT_LANES];

vec3 sum_over_lanes(uint lane, vec3 value) {
    for (uint c = 0u; c < 3u; ++c) {
        lane_sums[3u * lane + c] = value[c];
    }
    barrier();
    for (uint stride = POINT_LANES / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            for (uint c = 0u; c < 3u; ++c) {
                lane_sums[3u * lane + c] += lane_sums[3u * (lane + stride) + c];
            }
        }
        barrier();
    }
    return vec3(lane_sums[0], lane_sums[1], lane_sums[2]);
}
