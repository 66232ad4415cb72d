// Finding the lights that may reach a tile. A level's occupied vertices around the tile lead to its lights: along a row
// of vertices they follow each other in the merged list, so that a row is a range of lights. Needs tile_bounds.glsl; the
// includer declares the buffers.

const uint LANES = TILE_SIZE * TILE_SIZE;
// Lights that a thread keeps in one round; what is more is found in another round.
const uint FOUND_PER_LANE = 32u;

// A candidate: merged index, and the level above LEVEL_SHIFT.
const uint LEVEL_SHIFT = 28u;
const uint LIGHT_MASK = (1u << LEVEL_SHIFT) - 1u;

// What each thread has found, in a column of its own, and then all of it in one list, in the order of the threads: the
// same in every run.
shared uint candidates[FOUND_PER_LANE * LANES];
shared uint found_counts[LANES];
shared uint most_found;

// The vertices whose lights may reach a cluster, for level 0 the lowest vertices of cells of S1.
struct Reach {
    uint level;
    VertexRows rows;
    // Of the level: its first light in the merged list, and their number before they are dealt to the sub-images.
    uint first;
    uint count;
};

Reach reach_of(Cluster bounds, uint level, uint sub_image) {
    uint grid_level = max(level, 1u);
    float per_cell = 1.0 / cell_size(grid.h_top, grid_level);
    // A grid light lies within a cell of its vertex, a light of level 0 within the cell that begins there.
    float reach = (level == 0u ? 1.0 : 2.0) * alpha() + 0.001;
    float above = level == 0u ? 0.0 : 1.0;
    vec3 origin = grid.origin_ws - frame.eye_ws;
    vec3 last = vec3(float(vertices_per_axis(grid_level) - 1u));
    vec3 low = clamp(ceil((bounds.lowest - origin) * per_cell - reach - 1.0), vec3(0.0), last + 1.0);
    vec3 high = clamp(floor((bounds.highest - origin) * per_cell + reach + above), vec3(-1.0), last);
    if (level == top_level()) {
        low = vec3(0.0);
        high = last;
    }
    uvec3 extent = uvec3(max(high - low + 1.0, vec3(0.0)));
    uint count = level == 0u ? grid.light_count : level_count(level);
    return Reach(level, vertex_rows(grid_level, uvec3(low), extent), sub_images[SUB_IMAGE_STRIDE * sub_image + level], count);
}

// Whether a light may send anything to a cluster. Errs on the side of yes by more than rounding.
bool may_reach(Cluster bounds, vec3 light, uint level, float radius) {
    vec3 nearest = clamp(light, bounds.lowest, bounds.highest) - light;
    if (level != top_level() && dot(nearest, nearest) >= 4.0004 * radius * radius) {
        return false;
    }
    vec3 farthest = max(light - bounds.lowest, bounds.highest - light);
    if (level != first_level() && dot(farthest, farthest) <= 0.24997 * radius * radius) {
        return false;
    }
    vec3 most = max(bounds.lowest_normal * light, bounds.highest_normal * light);
    vec3 scale = abs(light) + max(abs(bounds.lowest), abs(bounds.highest));
    return most.x + most.y + most.z > bounds.lowest_plane - 1e-5 * (scale.x + scale.y + scale.z);
}

// Where light `index` of a level, or the first one after it, lies among those dealt to a sub-image.
uint dealt_index(uint index, Reach reach, uint sub_image) {
    return dealt_before(index, reach.count, sub_image, interleave() * interleave());
}

// The lights of a row of vertices: merged lights of the level, counted from its first. With the lights themselves as first
// level, those of level 0 are ranges of the list by cell.
uvec2 lights_of_row(Reach reach, uint row, uint sub_image) {
#ifdef FIRST_LEVEL_0
    if (reach.level == 0u) {
        VertexRows rows = reach.rows;
        uvec2 yz = rows.low.yz + uvec2(row % rows.extent.y, row / rows.extent.y);
        uvec2 cells = cells_of_row(yz, rows.low.x, rows.low.x + rows.extent.x - 1u);
        return uvec2(bucket_starts[cells.x], bucket_starts[cells.y]);
    }
#endif
    uvec2 range = ranks_of_row(reach.rows, row);
    return uvec2(dealt_index(range.x, reach, sub_image), dealt_index(range.y, reach, sub_image));
}

// Light `i` of such a range in the merged list, NO_LIGHT when it is dealt to another sub-image.
uint merged_light(Reach reach, uint i, uint sub_image) {
#ifdef FIRST_LEVEL_0
    if (reach.level == 0u) {
        uint light = bucket_lights[i];
        uint dealt = dealt_index(light, reach, sub_image);
        return dealt_index(light + 1u, reach, sub_image) > dealt ? reach.first + dealt : NO_LIGHT;
    }
#endif
    return reach.first + i;
}

// Finds the lights of one level in this thread's rows, and keeps those whose number, counted from `count`, is at least
// `first`. `before` is a cluster whose lights have been found already. Returns the new count.
uint find_in_level(Reach reach, Cluster own, Cluster before, bool has_before, uint sub_image, uint first, uint count) {
    uint lane = gl_LocalInvocationIndex;
    uint rows = row_count(reach.rows);
    float radius = alpha() * cell_size(grid.h_top, reach.level);
    for (uint r = lane; r < rows; r += LANES) {
        uvec2 range = lights_of_row(reach, r, sub_image);
        for (uint i = range.x; i < range.y; ++i) {
            uint light = merged_light(reach, i, sub_image);
            uint read = light == NO_LIGHT ? 0u : light;
            vec3 position = texelFetch(light_texels, light_texel(read, 0u), 0).xyz - frame.eye_ws;
            bool reaches = light != NO_LIGHT && may_reach(own, position, reach.level, radius);
            if (reaches && !(has_before && may_reach(before, position, reach.level, radius))) {
                if (count >= first && count - first < FOUND_PER_LANE) {
                    candidates[(count - first) * LANES + lane] = light | reach.level << LEVEL_SHIFT;
                }
                ++count;
            }
        }
    }
    return count;
}

uint find_in_all(uint sub_image, uint first) {
    uint count = 0u;
    for (uint c = 0u; c < CLUSTERS; ++c) {
        if (!is_cluster_empty(c)) {
            Cluster own = cluster(c);
            Cluster before = cluster(0u);
            for (uint level = first_level(); level <= top_level(); ++level) {
                count = find_in_level(reach_of(own, level, sub_image), own, before, c > 0u, sub_image, first, count);
            }
        }
    }
    return count;
}

// Lists the lights that may reach the tile, of each thread's at most FOUND_PER_LANE from number `first` on; all threads
// must call. Returns how many are listed; `most` is the number of lights of the thread that has found most.
uint list_candidates(uint sub_image, uint first, out uint most) {
    uint lane = gl_LocalInvocationIndex;
    most_found = 0u;
    barrier();
    uint count = find_in_all(sub_image, first);
    atomicMax(most_found, count);
    uint kept = min(count - min(first, count), FOUND_PER_LANE);
    found_counts[lane] = kept;
    uint own[FOUND_PER_LANE];
    for (uint i = 0u; i < FOUND_PER_LANE; ++i) {
        own[i] = i < kept ? candidates[i * LANES + lane] : 0u;
    }
    barrier();
    uint before = 0u;
    uint total = 0u;
    for (uint i = 0u; i < LANES; ++i) {
        uint n = found_counts[i];
        before += i < lane ? n : 0u;
        total += n;
    }
    for (uint i = 0u; i < FOUND_PER_LANE; ++i) {
        if (i < kept) {
            candidates[before + i] = own[i];
        }
    }
    most = most_found;
    barrier();
    return total;
}
