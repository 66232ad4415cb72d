// A micro-buffer of MICRO_EDGE texels along an edge, filled by a workgroup of POINT_LANES from the points' tree (Ritschel et
// al. 2009): nodes smaller than a texel are splatted, larger leaves are hit by rays. Needs frame.glsl, random.glsl and
// micro_buffer.glsl, and the constant BINARY_COVERAGE.

const uint MICRO_TEXELS = MICRO_EDGE * MICRO_EDGE;
// Subtrees are dealt to the lanes at this node of the tree's first row of so many.
const uint FIRST_SUBTREE = 1024u;
// Discs of leaves that are hit by rays are larger than their share of the surface, so that they leave no gap.
const float COVER_RADIUS = 1.75;
// Coverage 1 as it is summed.
const float COVERAGE_ONE = 1048576.0;
// With binary coverage a texel is covered when this share of it is.
const float LEAST_BINARY_SHARE = 0.5;
// Nothing below this share of a leaf's radius above the tangent plane is seen.
const float LEAST_HEIGHT = 1e-3;

// What fronts cover of each texel, and what backs do: of a surface that is all but closed both are seen, one behind the other.
shared uint texel_coverage[2u * MICRO_TEXELS];
#ifdef MICRO_KEYS
// The nearest of what is seen in each texel: its depth above its key.
shared uint texel_nearest[MICRO_TEXELS];
#endif

// Who looks.
struct MicroEye {
    vec3 position_ws;
    // Tangents and normal.
    mat3 to_world;
};

// Solid angle of a texel in a direction of this height.
float texel_solid_angle(float z) {
    float plus = 2.0 / (1.0 + max(z, -0.999));
    return 16.0 / (float(MICRO_TEXELS) * plus * plus);
}

vec2 disc_point(vec3 local) { return local.xy / max(1.0 + local.z, 1e-6); }

bool is_texel(ivec2 at) {
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(MICRO_EDGE)));
    return inside && is_used(micro_table[uint(at.y) * MICRO_EDGE + uint(at.x)]);
}

uint texel_index(ivec2 at) { return uint(at.y) * MICRO_EDGE + uint(at.x); }

// Notes what is seen in a texel, if it is the nearest so far.
void see(uint texel, float distance, uint key) {
#ifdef MICRO_KEYS
    uint key_bits = uint(findMSB(frame.point_leaf_count)) + 2u;
    uint most = (1u << (32u - key_bits)) - 2u;
    float nearest = POINT_OFFSET * frame.point_leaf_radius;
    float depth = log2(max(distance / nearest, 1.0)) / max(log2(2.0 * scene_radius() / nearest), 1e-3);
    atomicMin(texel_nearest[texel], uint(clamp(depth, 0.0, 1.0) * float(most)) << key_bits | key);
#endif
}

// `side` is 0 for fronts, 1 for backs.
void cover(uint texel, uint side, float share) {
    atomicAdd(texel_coverage[2u * texel + side], uint(round(min(share, 4.0) * COVERAGE_ONE)));
}

// What of a sphere of directions a node hides, times the squared distance: right for a flat patch and for a ball.
float hidden_area(PointNode node, float facing) {
    float r = node.normal_length;
    float flat_and_ball = node.is_solid ? r * max(-facing, 0.0) + 0.25 * (1.0 - r) : r * abs(facing) + 0.5 * (1.0 - r);
    return node.area * flat_and_ball;
}

// Whether all of a node is the inside of something closed, which its outside hides.
bool is_inside(PointNode node, float facing) {
    float cone_cos = max(node.cone_cos, 0.0);
    return node.is_solid && facing > 0.0 && facing * facing >= 1.0 - cone_cos * cone_cos;
}

// The side that is seen from a direction: of what is closed the outer one, as long as any of it may show.
uint shown_side(PointNode node, float facing) { return node.is_solid || facing < 0.0 ? 0u : 1u; }

// Shares what a node hides, its solid angle times the cosine, among the four texels around a place. Shares of texels that
// there are not stay in its own. As much of the cosine is covered as is hidden: near the horizon texels reach higher than
// most of what is seen in them.
void share_out(vec2 at, ivec2 own, uint side, float hidden) {
    ivec2 low = ivec2(floor(at - 0.5));
    vec2 part = at - 0.5 - vec2(low);
    uint texels[4];
    float shares[4];
    float weight = 0.0;
    for (uint corner = 0u; corner < 4u; ++corner) {
        ivec2 step = ivec2(corner & 1u, corner >> 1u);
        vec2 along = mix(1.0 - part, part, vec2(step));
        texels[corner] = texel_index(is_texel(low + step) ? low + step : own);
        shares[corner] = along.x * along.y;
        weight += shares[corner] * micro_table[texels[corner]].cosine_weight;
    }
    for (uint corner = 0u; corner < 4u; ++corner) {
        cover(texels[corner], side, hidden * shares[corner] / max(weight, 1e-30));
    }
}

// A node smaller than a texel, in a direction above the horizon.
void splat(uint index, PointNode node, vec3 direction, vec3 local, float distance) {
    float facing = dot(node.normal, direction);
    vec2 at = (disc_point(local) * 0.5 + 0.5) * float(MICRO_EDGE);
    ivec2 own = clamp(ivec2(at), ivec2(0), ivec2(MICRO_EDGE - 1u));
    if (!is_texel(own)) {
        return;
    }
    uint side = shown_side(node, facing);
    share_out(at, own, side, hidden_area(node, facing) * local.z / (distance * distance));
    see(texel_index(own), distance, 2u * index + side);
}

// First and last texel that a sphere may be seen in: directions on the disc are circles again.
void sphere_bounds(vec3 local, float distance, float radius, out ivec2 first, out ivec2 last) {
    first = ivec2(0);
    last = ivec2(MICRO_EDGE - 1u);
    float polar = acos(clamp(local.z, -1.0, 1.0));
    float half_angle = asin(min(radius / distance, 1.0));
    if (distance <= radius || polar + half_angle > 2.8) {
        return;
    }
    float near = tan(0.5 * (polar - half_angle));
    float far = tan(0.5 * (polar + half_angle));
    vec2 centre = 0.5 * (near + far) * local.xy / max(length(local.xy), 1e-12);
    vec2 low = (centre - 0.5 * (far - near)) * 0.5 + 0.5;
    vec2 high = (centre + 0.5 * (far - near)) * 0.5 + 0.5;
    first = clamp(ivec2(low * float(MICRO_EDGE)), first, last);
    last = clamp(ivec2(high * float(MICRO_EDGE)), first, last);
}

// Four directions in each texel of a leaf's bounds that meet its disc.
void cast_leaf(uint index, PointNode leaf, MicroEye eye, vec3 local, float distance) {
    float radius = COVER_RADIUS * frame.point_leaf_radius;
    vec3 offset = leaf.centroid_ws - eye.position_ws;
    uint side = shown_side(leaf, dot(leaf.normal, offset));
    ivec2 first, last;
    sphere_bounds(local, distance, radius, first, last);
    uint columns = uint(last.x - first.x) + 1u;
    uint count = columns * (uint(last.y - first.y) + 1u);
    for (uint i = 0u; i < 4u * count; ++i) {
        ivec2 texel = first + ivec2((i >> 2u) % columns, (i >> 2u) / columns);
        vec2 at = (vec2(texel) + 0.25 + 0.5 * vec2(i & 1u, (i >> 1u) & 1u)) * (2.0 / float(MICRO_EDGE)) - 1.0;
        float s = dot(at, at);
        float height = (1.0 - s) / (1.0 + s);
        vec3 direction = eye.to_world * vec3(2.0 * at / (1.0 + s), height);
        float t = dot(offset, leaf.normal) / dot(direction, leaf.normal);
        vec3 beside = t * direction - offset;
        if (s < 1.0 && t > 0.0 && dot(beside, beside) <= radius * radius && is_texel(texel)) {
            float weight = micro_table[texel_index(texel)].cosine_weight;
            cover(texel_index(texel), side, 0.25 * texel_solid_angle(height) * height / weight);
            see(texel_index(texel), t, 2u * index + side);
        }
    }
}

// Draws a node, or part of it; gives the node to go on with.
uint visit(uint index, MicroEye eye) {
    PointNode node = point_node(index);
    vec3 normal = eye.to_world[2];
    vec3 offset = node.centroid_ws - eye.position_ws;
    float along = dot(node.normal, normal);
    float reach = node.half_thickness * abs(along) + node.radius * sqrt(max(1.0 - along * along, 0.0));
    if (dot(offset, normal) + reach <= LEAST_HEIGHT * frame.point_leaf_radius) {
        return after_subtree(index);
    }
    float distance = max(length(offset), 1e-20);
    vec3 direction = offset / distance;
    vec3 local = direction * eye.to_world;
    float solid_angle = texel_solid_angle(local.z);
    bool is_small = node.radius * node.radius < distance * distance * (solid_angle / PI) * (1.0 - solid_angle / (4.0 * PI));
    // What faces several ways has no one light, nor one area that it hides.
    bool is_flat = node.cone_cos >= frame.hit_cone_cos;
    if (!(is_small && is_flat) && !is_leaf(index)) {
        return 2u * index;
    }
    // Discs reach over the edges of a convex surface, whose other discs have their centres below the horizon.
    if (local.z > 0.0 && !is_inside(node, dot(node.normal, direction))) {
        if (is_small) {
            splat(index, node, direction, local, distance);
        } else {
            cast_leaf(index, node, eye, local, distance);
        }
    }
    return after_subtree(index);
}

// Fills the micro-buffer; all lanes come here together.
void fill_micro_buffer(MicroEye eye, uint lane) {
    for (uint i = lane; i < MICRO_TEXELS; i += POINT_LANES) {
        texel_coverage[2u * i] = 0u;
        texel_coverage[2u * i + 1u] = 0u;
#ifdef MICRO_KEYS
        texel_nearest[i] = 0xffffffffu;
#endif
    }
    barrier();
    uint root = FIRST_SUBTREE + lane;
    uint node = root;
    while (root < 2u * FIRST_SUBTREE) {
        node = visit(node, eye);
        if (node == after_subtree(root)) {
            root += POINT_LANES;
            node = root;
        }
    }
    barrier();
}

// How much of a texel is covered.
float micro_coverage(uint texel) {
    uint covered = max(texel_coverage[2u * texel], texel_coverage[2u * texel + 1u]);
    float share = min(float(covered) / COVERAGE_ONE, 1.0);
    if (BINARY_COVERAGE == 0u) {
        return share;
    }
    return share < LEAST_BINARY_SHARE ? 0.0 : 1.0;
}

#ifdef MICRO_KEYS
// The key that is seen in a texel: its own, else the nearest of its neighbours'; 0 for none.
uint micro_key(uint texel) {
    uint own = texel_nearest[texel];
    uint nearest = own;
    ivec2 centre = ivec2(texel % MICRO_EDGE, texel / MICRO_EDGE);
    for (uint i = 0u; i < 9u && own == 0xffffffffu; ++i) {
        ivec2 at = centre + ivec2(i % 3u, i / 3u) - 1;
        nearest = is_texel(at) ? min(nearest, texel_nearest[texel_index(at)]) : nearest;
    }
    uint key_bits = uint(findMSB(frame.point_leaf_count)) + 2u;
    return nearest == 0xffffffffu ? 0u : nearest & ((1u << key_bits) - 1u);
}
#endif
