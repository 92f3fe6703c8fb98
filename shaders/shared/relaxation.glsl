// A Jacobi step on the relaxation energy (2014, Eq. 3) within the tangent plane (Eq. 4), extrapolated by the second-order
// semi-iteration, at the vertex's pace. The including shader includes newton.glsl and declares ring_offsets, rings, ring_weights, goals,
// starts, befores and constants with the number of vertices before.
#ifndef DERMIS_RELAXATION
#define DERMIS_RELAXATION

// Share of a Jacobi step. Whole steps have an eigenvalue of -1 on meshes whose edges make a checkerboard, which the
// extrapolation lets grow.
const float WEIGHT = 0.9;
const float SLIDE = 0.3; // longest Jacobi step over the radius

// Where vertex v with its goal (w: pace) slides from its start, beside a normal that is 0 where there is no tangent plane.
vec3 relaxed(uint v, vec4 goal, vec3 normal, float freedom, float omega, float radius) {
    uint first = part(constants.vertices);
    vec3 x = fetch(starts, first + v).xyz, slide = goal.xyz - x;
    uint end = word(ring_offsets, v + 1u);
    for (uint k = word(ring_offsets, v); k < end; k++) {
        slide += number(ring_weights, k) * fetch(starts, first + word(rings, k)).xyz;
    }
    freedom = normal == vec3(0.0) ? 0.0 : freedom * goal.w;
    slide -= normal * dot(normal, slide);
    vec3 y = x + freedom * shorten(WEIGHT * slide, SLIDE * radius);
    vec3 leap = (omega - 1.0) * (y - fetch(befores, first + v).xyz);
    leap -= normal * dot(normal, leap);
    return y + freedom * shorten(leap, LEAP * radius);
}

#endif
