// With which probability a light of S0 is a pixel's sample, on whatever way. A light is part of the eight grid lights
// around it on every level, and each of them that may be chosen leads down to it in proportion to its share. Needs
// samples.glsl up to its bindings.

// Share of the samples that start elsewhere than at the light of a reservoir: on a level chosen at random, at a grid light
// beside the receiver, or on the top level at any. So every light has some probability, those nearby more than others, also
// where the grid lights that stand for it are out of reach or behind the surface.
const float ELSEWHERE_SHARE = 0.125;

// The sum of f, on average over the n x n pixels that have the sub-images' lights between them. All of these pixels weigh
// ways by it, whatever their own lights are: if those that have the bright ones thought more of a way than the others, their
// samples would not add up.
float mean_total(uvec2 pixel) {
    uvec2 first = pixel - pixel % interleave();
    float sum = 0.0;
    float pixels = 0.0;
    for (uint i = 0u; i < interleave() * interleave(); ++i) {
        uvec2 p = first + uvec2(i % interleave(), i / interleave());
        if (all(lessThan(p, image_size())) && texelFetch(depth_image, ivec2(p), 0).x > 0.0) {
            sum += texelFetch(lighting_image, ivec2(interleaved_from_pixel(p)), 0).a;
            pixels += 1.0;
        }
    }
    return sum / max(pixels, 1.0);
}

// Of the light that all lights would send if they and the receiver faced each other, what estimates are at least taken
// relative to.
const float LEAST_EXPECTED = 1.0 / 16.0;

// What estimates are filtered per unit of: the sum of f, so that the filter keeps what the hierarchy knows of light and dark.
// Where the hierarchy has lost nearly all light, that is no measure: next to such pixels, whose estimates per unit are huge,
// others would come out far too bright. The lights of the top level, as far away as their centre and spread say, bound it.
float filter_unit(Receiver receiver) {
    float expected = 0.0;
    for (uint i = 0u; i < level_count(top_level()); ++i) {
        GridLight light = grid_lights[level_first(top_level()) + i];
        vec3 offset = light.position_ws - receiver.position_ws;
        vec3 spread = max(light.variance, vec3(0.0));
        float distance_squared = dot(offset, offset) + spread.x + spread.y + spread.z;
        expected += light.luminance / max(distance_squared, max(clamp_squared(), 1e-30));
    }
    return max(receiver.mean_total + LEAST_EXPECTED * expected / (PI * PI), 1e-30);
}

// What estimates are written per unit of: that, or for the ratio, which needs none, what samples were chosen by.
float written_unit(Receiver receiver) { return ESTIMATE == ESTIMATE_RATIO ? receiver.unit : filter_unit(receiver); }

// Luminance of all lights.
float luminance_of_all() {
    float sum = 0.0;
    for (uint i = 0u; i < level_count(top_level()); ++i) {
        sum += grid_lights[level_first(top_level()) + i].luminance;
    }
    return sum;
}

// A grid light and its level, where a sample starts.
struct Start {
    uint light;
    uint level;
};

// A light of the top level, chosen by luminance.
uint top_light(float all, float random_number) {
    float target = random_number * all;
    uint light = level_first(top_level());
    uint last = light + level_count(top_level()) - 1u;
    for (; light < last && target >= grid_lights[light].luminance; ++light) {
        target -= grid_lights[light].luminance;
    }
    return light;
}

// Where a sample starts that has nothing to do with reservoirs. NO_LIGHT where the vertex beside the receiver, chosen by its
// trilinear weight, has none.
Start start_elsewhere(Receiver receiver, inout uint random_state) {
    uint level = 1u + min(uint(random(random_state) * float(top_level())), top_level() - 1u);
    vec3 numbers = vec3(random(random_state), random(random_state), random(random_state));
    if (level == top_level()) {
        return Start(level_count(level) == 0u ? NO_LIGHT : top_light(receiver.luminance_of_all, numbers.x), level);
    }
    vec3 cells = grid_position(receiver.position_ws, grid, level);
    uvec3 vertex = min(uvec3(cells + numbers), uvec3(vertices_per_axis(level) - 1u));
    return Start(grid_light_at(vertex, level), level);
}

// What is the same for all lights of a level.
struct DealtLevel {
    uint level;
    // Number of lights before they are dealt.
    uint count;
    // Whether reservoirs may hold them.
    bool is_chosen_from;
};

DealtLevel dealt_level(uint level, uint count) {
    return DealtLevel(level, count, level >= max(first_level(), first_shadow_level()));
}

// A light of a level as samples know it.
struct WayLight {
    // What it sends to the receiver per unit of luminance, as reservoirs choose it: on average over the sub-images, one of
    // which has it n^2 times as bright, or all as it is. A pixel's own sub-image alone would leave most lights to samples from
    // elsewhere; as it is, estimates are right on average over n x n pixels, which are blurred together.
    float response;
    // Before lights are dealt.
    float luminance;
};

WayLight way_light(uint index, DealtLevel dealt, Receiver receiver) {
    // A power of two.
    uint sub_image_count = interleave() * interleave();
    bool has_all = dealt.count < sub_image_count;
    uint sub_image = has_all ? 0u : index & (sub_image_count - 1u);
    uint place = has_all ? index : index >> findMSB(sub_image_count);
    uint merged = sub_images[SUB_IMAGE_STRIDE * sub_image + dealt.level] + place;
    vec4 position_radius = texelFetch(light_texels, light_texel(merged, 0u), 0);
    vec4 lobe_luminance = texelFetch(light_texels, light_texel(merged, 1u), 0);
    vec3 offset = position_radius.xyz - receiver.position_ws;
    float distance = length(offset);
    float weight = blend_weight(distance, position_radius.w, dealt.level, first_level(), top_level());
    float luminance = has_all ? lobe_luminance.w : lobe_luminance.w / float(sub_image_count);
    float response = weight * light_response(offset, distance, receiver.normal, lobe_luminance.xyz, dealt.level, luminance);
    return WayLight(dealt.is_chosen_from ? response : 0.0, luminance);
}

uvec3 corner_of(uint i) { return uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u); }

// What a sum or product over the axes has of the low and of the high side of a cell.
struct Sides {
    vec3 low;
    vec3 high;
};

vec3 of_corner(Sides sides, uint i) { return mix(sides.low, sides.high, equal(corner_of(i), uvec3(1u))); }

float sum_of(vec3 v) { return v.x + v.y + v.z; }
float product_of(vec3 v) { return v.x * v.y * v.z; }

// Trilinear weights, axis by axis, of the sides of a cell for a position `from` its lowest vertex, in cells.
Sides hats(vec3 from) { return Sides(max(1.0 - abs(from), vec3(0.0)), max(1.0 - abs(from - 1.0), vec3(0.0))); }

// Corners of a cell that may lead to its lights, as bits: whose grid light, which lies within a cell of its vertex, may be in
// reach and before the surface, or which are beside the receiver. Asked first, because most corners end here, and devices
// that run pixels in lockstep pay for whatever follows in a loop as often as the worst of them. `from` leads from the
// receiver to the cell's lowest vertex, in cells.
uint leading_corners(vec3 from, Sides beside, uint level, Receiver receiver) {
    Sides nearest = Sides(max(abs(from) - 1.0, vec3(0.0)), max(abs(from + 1.0) - 1.0, vec3(0.0)));
    Sides farthest = Sides(abs(from) + 1.0, abs(from + 1.0) + 1.0);
    Sides before = Sides(receiver.normal * from, receiver.normal * (from + 1.0));
    nearest = Sides(nearest.low * nearest.low, nearest.high * nearest.high);
    farthest = Sides(farthest.low * farthest.low, farthest.high * farthest.high);
    float behind = -1.001 * sum_of(abs(receiver.normal));
    float reach = level == top_level() ? 3e38 : 4.001 * alpha() * alpha();
    float least = level == first_level() ? -1.0 : 0.249 * alpha() * alpha();
    uint bits = 0u;
    for (uint i = 0u; i < 8u; ++i) {
        bool in_reach = sum_of(of_corner(nearest, i)) < reach && sum_of(of_corner(farthest, i)) > least;
        bool leads = in_reach && sum_of(of_corner(before, i)) > behind;
        bits |= uint(leads || product_of(of_corner(beside, i)) > 0.0) << i;
    }
    return bits;
}

// What a light of S0 is chosen for, all ways together, per unit of its luminance: from the reservoirs (over the sum of all
// weights f it is the probability), and from elsewhere.
struct ChosenFor {
    float response;
    float elsewhere;
};

void add_level(inout ChosenFor sum, vec3 position_ws, uint level, Receiver receiver) {
    vec3 cells = grid_position(position_ws, grid, level);
    uvec3 cell = cell_of(cells, level);
    Sides shares = hats(cells - vec3(cell));
    Sides beside = hats(grid_position(receiver.position_ws, grid, level) - vec3(cell));
    if (level == top_level()) {
        beside = Sides(vec3(0.0), vec3(0.0));
    }
    vec3 from = vec3(cell) - (receiver.position_ws - grid.origin_ws) / cell_size(grid.h_top, level);
    DealtLevel dealt = dealt_level(level, level_count(level));
    uint first_rank = ranks[first_word(level)];
    for (uint bits = leading_corners(from, beside, level, receiver); bits != 0u; bits &= bits - 1u) {
        uint corner = uint(findLSB(bits));
        uvec3 vertex = cell + corner_of(corner);
        uint word = occupancy_word(vertex, level);
        uint bit = 1u << (vertex.x % 32u);
        uint occupied = occupancy[word];
        uint rank = ranks[word] - first_rank + uint(bitCount(occupied & (bit - 1u)));
        if ((occupied & bit) != 0u && rank < dealt.count) {
            float share = product_of(of_corner(shares, corner));
            WayLight light = way_light(rank, dealt, receiver);
            sum.response += share * light.response;
            sum.elsewhere += share * product_of(of_corner(beside, corner)) / max(light.luminance, 1e-37);
        }
    }
}

ChosenFor chosen_for(uint light, vec3 position_ws, Receiver receiver) {
    ChosenFor sum = ChosenFor(0.0, 1.0 / receiver.luminance_of_all);
    for (uint level = 1u; level <= top_level(); ++level) {
        add_level(sum, position_ws, level, receiver);
    }
    if (first_level() == 0u) {
        sum.response += way_light(light, dealt_level(0u, grid.light_count), receiver).response;
    }
    sum.elsewhere /= float(top_level());
    return sum;
}

// What a light is chosen for on all ways, each as often as it is taken, and per unit of its luminance like a response: over
// the receiver's unit it is the probability.
float expected_on_all_ways(ChosenFor chosen_for, Receiver receiver) {
    float chosen = receiver.mean_total > 0.0 ? (1.0 - ELSEWHERE_SHARE) * chosen_for.response : 0.0;
    return ELSEWHERE_SHARE * receiver.unit * chosen_for.elsewhere + chosen;
}
