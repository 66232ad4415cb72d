// One vertex of a level above S1 gathers the S1 lights within one cell of it (section 3.1). Trilinear weights nest: that
// of a light at a coarse vertex is the sum of its weights at the S1 vertices, each times the coarse weight of that S1
// vertex. So S1 lights are weighted by where their vertices are, not their centres, and every moment is what scattering
// all lights would give. One workgroup per occupied vertex; its threads share the rows of the S1 grid.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = GATHER_SIZE) in;

#include "grid_gather/moments.glsl"

shared vec4 shared_flux_weight[GATHER_SIZE];
shared vec4 shared_position_luminance[GATHER_SIZE];
shared vec4 shared_square[GATHER_SIZE];
shared vec4 shared_lobe[GATHER_SIZE];

// Adds the S1 lights of one row whose x lies in [low, high].
void add_row(inout Moments sums, uint row, uint low, uint high, vec3 vertex, float h) {
    for (uint column = low / 32u; column <= high / 32u; ++column) {
        uint word = first_word(1u) + row * words_per_row(1u) + column;
        uint base = column * 32u;
        uint keep = low > base ? ~0u << (low - base) : ~0u;
        keep &= high - base < 31u ? (2u << (high - base)) - 1u : ~0u;
        uint all = occupancy[word];
        for (uint bits = all & keep; bits != 0u; bits &= bits - 1u) {
            uint lowest = bits & (~bits + 1u);
            uint rank = ranks[word] + uint(bitCount(all & (lowest - 1u)));
            if (rank < level_count(1u)) {
                uint n = vertices_per_axis(1u);
                uvec3 s1_vertex = uvec3(base + uint(findLSB(lowest)), row % n, row / n);
                vec3 hat = max(1.0 - abs(s1_vertex_in_cells(s1_vertex, level) - vertex), vec3(0.0));
                add_light(sums, grid_lights[level_first(1u) + rank], hat.x * hat.y * hat.z, vertex, h);
            }
        }
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    bool inside = linear_group() < level_count(level);
    uint record = level_first(level) + min(linear_group(), max(level_count(level), 1u) - 1u);
    uvec3 vertex = vertex_from_index(grid_lights[record].vertex, level);
    float h = cell_size(grid.h_top, level);
    uint scale = 1u << (level - 1u);
    uvec3 middle = vertex * scale;
    uvec3 low = middle - min(middle, uvec3(scale - 1u));
    uvec3 high = min(middle + scale - 1u, uvec3(vertices_per_axis(1u) - 1u));
    uvec3 extent = high - low + 1u;
    Moments sums = no_moments();
    for (uint i = lane; inside && i < extent.y * extent.z; i += GATHER_SIZE) {
        uint row = (low.z + i / extent.y) * vertices_per_axis(1u) + low.y + i % extent.y;
        add_row(sums, row, low.x, high.x, vec3(vertex), h);
    }
    shared_flux_weight[lane] = sums.flux_weight;
    shared_position_luminance[lane] = sums.position_luminance;
    shared_square[lane] = vec4(sums.square, 0.0);
    shared_lobe[lane] = vec4(sums.lobe, 0.0);
    barrier();
    for (uint stride = GATHER_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            shared_flux_weight[lane] += shared_flux_weight[lane + stride];
            shared_position_luminance[lane] += shared_position_luminance[lane + stride];
            shared_square[lane] += shared_square[lane + stride];
            shared_lobe[lane] += shared_lobe[lane + stride];
        }
        barrier();
    }
    if (lane == 0u && inside) {
        Moments total = Moments(shared_flux_weight[0], shared_position_luminance[0], shared_square[0].xyz, shared_lobe[0].xyz);
        store_light(record, total, vec3(vertex), h);
    }
}
