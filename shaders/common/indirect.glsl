// Arguments of indirect dispatches. Needs constants.glsl and the buffer `dispatches`, three words a slot.
void write_dispatch(uint slot, uint groups) {
    uint x = clamp(groups, 1u, DISPATCH_WIDTH);
    dispatches[3u * slot] = x;
    dispatches[3u * slot + 1u] = groups == 0u ? 0u : (groups + x - 1u) / x;
    dispatches[3u * slot + 2u] = 1u;
}
