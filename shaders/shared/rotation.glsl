// Quaternions as vec4, w the scalar part.
#ifndef DERMIS_ROTATION
#define DERMIS_ROTATION

vec3 rotate(vec4 q, vec3 v) {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

// The rotation half-way between two.
vec4 half_way(vec4 a, vec4 b) {
    vec4 sum = a + (dot(a, b) < 0.0 ? -b : b);
    return sum / length(sum); // no shorter than √2
}

// v turned by the least rotation that carries unit vector a to unit vector b; v itself where they are opposite.
vec3 rotate_between(vec3 a, vec3 b, vec3 v) {
    float c = dot(a, b);
    if (c < -0.9999) {
        return v;
    }
    vec3 k = cross(a, b);
    return v * c + cross(k, v) + k * (dot(k, v) / (1.0 + c));
}

#endif
