// Exclusive prefix sum across one workgroup (Hillis and Steele); `total` is the sum of all lanes.
#ifndef SCAN_LANES
#define SCAN_LANES WORKGROUP_SIZE
#endif
shared uint scan_scratch[SCAN_LANES];

uint workgroup_exclusive_scan(uint lane, uint value, out uint total) {
    barrier();
    scan_scratch[lane] = value;
    barrier();
    for (uint stride = 1u; stride < SCAN_LANES; stride *= 2u) {
        uint before = lane >= stride ? scan_scratch[lane - stride] : 0u;
        barrier();
        scan_scratch[lane] += before;
        barrier();
    }
    total = scan_scratch[SCAN_LANES - 1u];
    return scan_scratch[lane] - value;
}
