// Steps towards an iso-value.
#ifndef DERMIS_NEWTON
#define DERMIS_NEWTON

vec3 shorten(vec3 d, float limit) {
    float l = length(d);
    return l > limit ? d * (limit / l) : d;
}

const float LEAP = 0.1; // longest step over the radius
const float FLAT = 1e-3; // |∇f| r below which there is no direction to go
const float PIT = 1e-5; // growth of |f − iso| that rounding explains

// Curvature of a field across a contact sheet, over its squared radius.
const float VALLEY = 10.0;
// Least |∇f| r that is divided by.
const float GENTLE = 0.05;

// A step from a sample towards the iso-value: σ (iso − f) ∇f / |∇f|², not longer than `limit` radii.
//
// A contact sheet is the floor of a valley, and iso-values below its floor are never reached. Newton's method on the squared
// distance (f − iso)² has f − iso times the curvature in its denominator, which ends such a step on the floor.
vec3 newton(float iso, vec4 sampled, float sigma, float radius, float limit) {
    float inverse = 1.0 / (radius * radius);
    float steep = dot(sampled.yzw, sampled.yzw) + VALLEY * max(sampled.x - iso, 0.0) * inverse;
    float factor = sigma * (iso - sampled.x) / max(steep, GENTLE * GENTLE * inverse);
    return shorten(factor * sampled.yzw, limit * radius);
}

#endif
