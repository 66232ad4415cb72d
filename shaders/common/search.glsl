// Defines NAME(first, count, at): the number of the interval that holds `at`, of `count` that come one after the other;
// interval i begins at START_OF(first + i), an ascending function.
#define DEFINE_INTERVAL_SEARCH(NAME, START_OF) \
uint NAME(uint first, uint count, float at) { \
    uint low = 0u; \
    uint high = count - 1u; \
    while (low < high) { \
        uint middle = (low + high + 1u) / 2u; \
        if (START_OF(first + middle) <= at) { \
            low = middle; \
        } else { \
            high = middle - 1u; \
        } \
    } \
    return low; \
}
