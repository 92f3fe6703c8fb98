// The maps of a cross-section that keep volume, from the straight spine's to the bent one's (2013, Eqs. 8, 12, 16). Past its limit
// a map goes on with the ratio that it has there.
#ifndef DERMIS_FLESH_MAP
#define DERMIS_FLESH_MAP

const uint RADIAL = 0u;
const uint NORMAL = 1u;
const float SQRT_3 = 1.7320508;
const float BINORMAL_ROOM = 1.0 / 32.0; // the binormal map stretches without bound; its limit is where this much is left
const float FLAT_SLOPE = 1e-6; // least slope in a derivative
const float STRAIGHT = 1e-9; // curvature times offset of a straight spine

// Curvature times straight offset at the limit of a map (Eqs. 9, 13, 17).
float limit_of(uint map) {
    return map == RADIAL ? 1.0 / SQRT_3 : map == NORMAL ? 0.5 : 1.0 - BINORMAL_ROOM;
}

// Where a point of the cross-section goes, the derivative by its offset, and that along the spine, the offset kept.
struct Shift {
    vec2 offset;
    mat2 by_offset;
    vec2 along;
};

// Root of x³ - x - a that is 1 at a = 0, for a above that of the limit: in closed form, then by Newton's method, since a device's
// arc cosine may be off by 5e-4.
float radial_root(float a) {
    float t = 1.5 * SQRT_3 * a;
    float x = 2.0 / SQRT_3 * (t <= 1.0 ? cos(acos(clamp(t, -1.0, 1.0)) / 3.0) : cosh(acosh(max(t, 1.0)) / 3.0));
    for (int k = 0; k < 2; k++) {
        x = max(x - (x * x * x - x - a) / max(3.0 * x * x - 1.0, 0.01), 1.0 / SQRT_3);
    }
    return x;
}

// r = r* / x: the offset times a ratio that depends on its product with the curvature alone.
Shift bend_radial(vec2 offset, vec2 curvature, vec2 rate) {
    float a = dot(curvature, offset) / -1.5;
    if (1.5 * SQRT_3 * a <= -1.0) {
        return Shift(SQRT_3 * offset, mat2(SQRT_3), vec2(0.0));
    }
    float x = radial_root(a), ratio = 1.0 / x, slope = 1.0 / (1.5 * x * x * max(3.0 * x * x - 1.0, FLAT_SLOPE));
    return Shift(ratio * offset, mat2(ratio) + outerProduct(offset, slope * curvature), slope * dot(rate, offset) * offset);
}

// x = 2 x* / (1 + √(1 - 2 κ x*)) along the normal, or y = y* / (1 - κ x) along the binormal, as the offset is kept while both turn.
Shift bend_in_plane(bool along_normal, vec2 offset, vec2 curvature, vec2 rate) {
    float size = length(curvature);
    bool bent = size * (abs(offset.x) + abs(offset.y)) >= STRAIGHT;
    // Where the curvature passes through zero, its direction is that in which it changes.
    vec2 normal = bent ? curvature / size : length(rate) > 0.0 ? normalize(rate) : vec2(1.0, 0.0);
    vec2 binormal = vec2(-normal.y, normal.x);
    float x = dot(offset, normal), y = dot(offset, binormal), k = bent ? size : 0.0;
    float turn = bent ? dot(rate, binormal) / size : 0.0, tighten = dot(rate, normal);
    float value, by_x, by_y, by_k;
    if (along_normal) {
        float square = 1.0 - 2.0 * k * x, root = sqrt(max(square, 0.0));
        bool past = square <= 0.0;
        value = past ? 2.0 * x : 2.0 * x / (1.0 + root);
        by_x = past ? 2.0 : 1.0 / max(root, FLAT_SLOPE);
        by_y = 0.0;
        by_k = past ? 0.0 : 0.5 * value * value * by_x;
    } else {
        float room = 1.0 - k * x;
        bool past = room < BINORMAL_ROOM;
        room = max(room, BINORMAL_ROOM);
        float steep = past ? 0.0 : y / (room * room);
        value = y / room;
        by_x = k * steep;
        by_y = 1.0 / room;
        by_k = x * steep;
    }
    float xs = turn * y, ys = -turn * x, change = by_x * xs + by_y * ys + by_k * tighten;
    vec2 place = along_normal ? vec2(value, y) : vec2(x, value);
    vec2 rates = along_normal ? vec2(change, ys) : vec2(xs, change);
    mat2 inner = along_normal ? mat2(by_x, 0.0, by_y, 1.0) : mat2(1.0, by_x, 0.0, by_y);
    mat2 axes = mat2(normal, binormal);
    return Shift(axes * place, axes * inner * transpose(axes), axes * (rates + turn * vec2(-place.y, place.x)));
}

Shift bend(uint map, vec2 offset, vec2 curvature, vec2 rate) {
    return map == RADIAL ? bend_radial(offset, curvature, rate) : bend_in_plane(map == NORMAL, offset, curvature, rate);
}

#endif
