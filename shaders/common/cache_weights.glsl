// How much each cache counts at a surface (Ward et al. 1988), clamped by angle. Needs frame.glsl and cache.glsl.

struct Receiver {
    vec3 position;
    vec3 geometric;
    vec3 normal;
};

// How far before or behind its plane a cache still lights.
const float WIDEST_STEP = 0.25;

// Of how far a cache reaches, how near counts as being there: less would show single caches as dots.
const float NEAREST = 0.25;

// How far from a cache a receiver is, by place and by angle; 1 is too far.
float cache_distance(CachePlace place, Receiver receiver) {
    vec3 offset = receiver.position - place.position_ws;
    float turned = max(1.0 - dot(receiver.geometric, place.normal_ws), 0.0);
    return length(offset) / place.reach + sqrt(turned / max(1.0 - frame.cache_cone_cos, 1e-6));
}

// How far a receiver lies before or behind the plane of a cache, over its reach.
float plane_distance(CachePlace place, Receiver receiver) {
    vec3 offset = receiver.position - place.position_ws;
    return 0.5 * abs(dot(offset, receiver.geometric + place.normal_ws)) / place.reach;
}

// Weight of a cache at this distance, 0 where it does not light; its reach is so many times its own.
float cache_weight(CachePlace place, Receiver receiver, float distance, float stretch) {
    if (distance >= stretch || plane_distance(place, receiver) > WIDEST_STEP * stretch) {
        return 0.0;
    }
    return 1.0 / max(distance / stretch, NEAREST) - 1.0;
}
