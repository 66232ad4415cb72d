// Exclusive prefix sum across one workgroup (Hillis and Steele); `total` is the sum of all lanes.
shared uint scan_scratch[WORKGROUP_SIZE];

uint workgroup_exclusive_scan(uint lane, uint value, out uint total) {
    barrier();
    scan_scratch[lane] = value;
    barrier();
    for (uint stride = 1u; stride < WORKGROUP_SIZE; stride *= 2u) {
        uint before = lane >= stride ? scan_scratch[lane - stride] : 0u;
        barrier();
        scan_scratch[lane] += before;
        barrier();
    }
    total = scan_scratch[WORKGROUP_SIZE - 1u];
    return scan_scratch[lane] - value;
}
