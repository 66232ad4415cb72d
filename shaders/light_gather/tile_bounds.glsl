// What is known of the surfaces of one screen tile: one cluster, or two where the tile spans much depth, each with the
// bounds of its positions, of its normals n, and of n . p. Bounds of both n and n . p tell which lights lie behind every
// surface: exactly for a flat tile, however it is turned. Positions are relative to the eye.

struct Cluster {
    vec3 lowest;
    vec3 highest;
    vec3 lowest_normal;
    vec3 highest_normal;
    float lowest_plane;
};

const uint CLUSTERS = 2u;
// Where a cluster's words lie.
const uint LOWEST = 0u;
const uint HIGHEST = 3u;
const uint LOWEST_NORMAL = 6u;
const uint HIGHEST_NORMAL = 9u;
const uint LOWEST_PLANE = 12u;
const uint CLUSTER_WORDS = 13u;

shared uint tile_distances[2];
shared uint tile_clusters[CLUSTERS * CLUSTER_WORDS];

// Floats as unsigned numbers in the same order: integer atomics find their bounds whatever the order.
uint ordered(float value) {
    uint bits = floatBitsToUint(value);
    return bits ^ ((bits >> 31u) != 0u ? 0xffffffffu : 0x80000000u);
}

float from_ordered(uint bits) { return uintBitsToFloat(bits ^ ((bits >> 31u) != 0u ? 0x80000000u : 0xffffffffu)); }

vec3 bound_at(uint word) {
    return vec3(from_ordered(tile_clusters[word]), from_ordered(tile_clusters[word + 1u]),
                from_ordered(tile_clusters[word + 2u]));
}

Cluster cluster(uint index) {
    uint base = index * CLUSTER_WORDS;
    return Cluster(bound_at(base + LOWEST), bound_at(base + HIGHEST), bound_at(base + LOWEST_NORMAL),
                   bound_at(base + HIGHEST_NORMAL), from_ordered(tile_clusters[base + LOWEST_PLANE]));
}

bool is_cluster_empty(uint index) { return tile_clusters[index * CLUSTER_WORDS + HIGHEST] == 0u; }

void clear_bounds() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < CLUSTERS * CLUSTER_WORDS) {
        uint word = lane % CLUSTER_WORDS;
        bool upper = (word >= HIGHEST && word < LOWEST_NORMAL) || (word >= HIGHEST_NORMAL && word < LOWEST_PLANE);
        tile_clusters[lane] = upper ? 0u : 0xffffffffu;
    }
    if (lane < 2u) {
        tile_distances[lane] = lane == 0u ? 0xffffffffu : 0u;
    }
}

void widen(uint base, vec3 position, vec3 normal) {
    for (uint axis = 0u; axis < 3u; ++axis) {
        atomicMin(tile_clusters[base + LOWEST + axis], ordered(position[axis]));
        atomicMax(tile_clusters[base + HIGHEST + axis], ordered(position[axis]));
        atomicMin(tile_clusters[base + LOWEST_NORMAL + axis], ordered(normal[axis]));
        atomicMax(tile_clusters[base + HIGHEST_NORMAL + axis], ordered(normal[axis]));
    }
    atomicMin(tile_clusters[base + LOWEST_PLANE], ordered(dot(normal, position)));
}

// Finds the bounds of the tile's surfaces, at `distance` along the viewing direction; all threads must call. A tile that
// spans more than `split_distance` is split halfway.
void bound_tile(bool found, vec3 position, vec3 normal, float distance, float split_distance) {
    clear_bounds();
    barrier();
    if (found) {
        atomicMin(tile_distances[0], floatBitsToUint(distance));
        atomicMax(tile_distances[1], floatBitsToUint(distance));
    }
    barrier();
    if (found) {
        float nearest = uintBitsToFloat(tile_distances[0]);
        float farthest = uintBitsToFloat(tile_distances[1]);
        bool is_split = farthest - nearest > split_distance;
        widen(is_split && distance > 0.5 * (nearest + farthest) ? CLUSTER_WORDS : 0u, position, normal);
    }
    barrier();
}
