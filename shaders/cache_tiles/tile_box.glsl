// The tiles of pixels that a cache reaches. Needs frame.glsl and cache.glsl.

uvec2 tile_count() { return (image_size() + CACHE_TILE - 1u) / CACHE_TILE; }

// Lowest and highest tangent, in the plane of one axis of the picture and the view, of a sphere before the eye: `across`
// and `ahead` are its centre's coordinates.
vec2 sphere_slopes(float across, float ahead, float radius) {
    float divisor = ahead * ahead - radius * radius;
    float root = radius * sqrt(max(across * across + divisor, 0.0));
    return vec2(across * ahead - root, across * ahead + root) / divisor;
}

// First and last tile in x and y; false where the cache reaches none.
bool tiles_of(CachePlace place, out uvec2 first, out uvec2 last) {
    vec3 offset = place.position_ws - frame.eye_ws;
    float ahead = dot(offset, frame.forward_ws);
    first = uvec2(0u);
    last = tile_count() - 1u;
    if (place.reach <= 0.0) {
        return false;
    }
    if (ahead <= place.reach) {
        // About the eye, or behind it.
        return ahead > -place.reach;
    }
    vec2 tangents = vec2(length(frame.right_ws), length(frame.up_ws));
    vec2 x = sphere_slopes(dot(offset, frame.right_ws) / tangents.x, ahead, place.reach) / tangents.x;
    vec2 y = -sphere_slopes(dot(offset, frame.up_ws) / tangents.y, ahead, place.reach).yx / tangents.y;
    // A pixel more on each side, as pixels are sampled anywhere within them.
    vec2 low = (vec2(x.x, y.x) * 0.5 + 0.5) * vec2(image_size()) - 1.0;
    vec2 high = (vec2(x.y, y.y) * 0.5 + 0.5) * vec2(image_size()) + 1.0;
    if (any(lessThan(high, vec2(0.0))) || any(greaterThanEqual(low, vec2(image_size())))) {
        return false;
    }
    first = uvec2(clamp(low, vec2(0.0), vec2(image_size()) - 1.0)) / CACHE_TILE;
    last = uvec2(clamp(high, vec2(0.0), vec2(image_size()) - 1.0)) / CACHE_TILE;
    return true;
}
