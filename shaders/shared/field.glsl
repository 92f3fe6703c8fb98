// The composed field f and its gradient at a point of model space: index cell → fields → operators → maximum (2013, Eq. 3),
// or a walk over the composition tree's leaves (2014, section 4.1).
// The including shader defines FIRST_FIELD_BINDING: six bindings from there on are used here.
//
// Software rasterisers run both sides of a branch and a loop's body at least once; so loops test at their end.
#ifndef DERMIS_FIELD
#define DERMIS_FIELD
#include "shared/around.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING + 3) uniform sampler3D atlas;
layout(set = 0, binding = FIRST_FIELD_BINDING + 4) uniform sampler3D operators;
layout(set = 0, binding = FIRST_FIELD_BINDING + 5) uniform usamplerBuffer opening;

layout(constant_id = 0) const uint COMPOSITION = UNIONS;
layout(constant_id = 1) const bool EXACT_FILTER = true; // the device's filter weighs texels in single precision

const float NULL_GRADIENT = 1e-6; // shorter gradients have no direction
const float OPENING_ROWS = 128.0;
const float FAINT = 1e-5; // lesser fields leave others as they are

uint fetches = 0u;

// The trilinear sample at normalised coordinates.
vec4 filtered(sampler3D image, vec3 at) {
    if (EXACT_FILTER) {
        return textureLod(image, at, 0.0);
    }
    ivec3 last = textureSize(image, 0) - 1;
    vec3 texel = at * vec3(last + 1) - 0.5;
    vec3 part = fract(texel);
    ivec3 low = clamp(ivec3(floor(texel)), ivec3(0), last), high = clamp(ivec3(floor(texel)) + 1, ivec3(0), last);
    vec4 near_low = mix(texelFetch(image, low, 0), texelFetch(image, ivec3(high.x, low.yz), 0), part.x);
    vec4 near_high = mix(texelFetch(image, ivec3(low.x, high.y, low.z), 0), texelFetch(image, ivec3(high.xy, low.z), 0), part.x);
    vec4 far_low = mix(texelFetch(image, ivec3(low.xy, high.z), 0), texelFetch(image, ivec3(high.x, low.y, high.z), 0), part.x);
    vec4 far_high = mix(texelFetch(image, ivec3(low.x, high.yz), 0), texelFetch(image, high, 0), part.x);
    return mix(mix(near_low, near_high, part.y), mix(far_low, far_high, part.y), part.z);
}

// How far the last walk's place lay in a contact sheet: depth of the contact, times the lesser field over the greater.
float sheet = 0.0;
const float IN_CONTACT = 0.5; // how far in a sheet a place is in contact

// f and ∂f/∂x of field i at a point in its box.
vec4 sample_field(uint i, Box box, vec3 x) {
    // Texel i of a tile of 32 lies at box coordinate i / 31.
    vec3 tile = (vec3(unpack(field_word(i, TILE))) * 32.0 + 0.5) / 31.0;
    vec4 t = filtered(atlas, (tile + clamp(in_box(box, x), 0.0, 1.0)) * fields.box_scale.xyz);
    return vec4(t.x, t.y * box.row0.xyz + t.z * box.row1.xyz + t.w * box.row2.xyz);
}

// A curve's table over the cosine of the angle between two gradients: tan θ of an opening (2013, section 4.2), depth d of a
// controller (2014, figure 4).
float on_curve(uint curve, float cosine) {
    float at = clamp(cosine * 0.5 + 0.5, 0.0, 1.0) * (OPENING_ROWS - 1.0);
    uint row = min(uint(at), uint(OPENING_ROWS) - 2u);
    uint base = curve * uint(OPENING_ROWS) + row;
    return mix(number(opening, base), number(opening, base + 1u), at - float(row));
}

// Operator number `kind` (from 1) at two values and a third coordinate. The volumes of 128³ lie above each other in z.
vec3 operate(uint kind, float a, float b, float third) {
    vec3 at = clamp(vec3(a, b, third), 0.0, 1.0) * 127.0 + 0.5;
    at.z += 128.0 * float(kind - 1u);
    fetches++;
    return filtered(operators, at / vec3(textureSize(operators, 0))).xyz;
}

// Operator number `kind` (from 1) on two samples; their maximum where the angle is undefined.
vec4 combine(uint kind, uint curve, vec4 a, vec4 b) {
    float la = length(a.yzw), lb = length(b.yzw);
    if (min(la, lb) < NULL_GRADIENT) {
        return a.x >= b.x ? a : b;
    }
    vec3 g = operate(kind, a.x, b.x, on_curve(curve, dot(a.yzw, b.yzw) / (la * lb)));
    return vec4(g.x, g.y * a.yzw + g.z * b.yzw);
}

// Field i at a point in its box, combined with its parent where their joint has an operator other than the union.
vec4 sample_joint(uint i, vec3 x) {
    vec4 s = sample_field(i, field_box(i), x);
    fetches++;
    if (COMPOSITION != UNIONS) {
        uint link = field_word(i, LINK);
        uint kind = (link >> 16) & 0xffu;
        if (kind != UNION && s.x > 0.0) {
            Box box = field_box(link & 0xffffu);
            bool held = holds(box, x);
            vec4 parent = held ? sample_field(link & 0xffffu, box, x) : vec4(0.0);
            fetches += held ? 1u : 0u;
            if (parent.x > 0.0) {
                s = combine(kind, link >> 24, s, parent);
            }
        }
    }
    return s;
}

// The greatest field; zero in empty cells and outside the index.
vec4 greatest(vec3 x) {
    vec4 best = vec4(0.0);
    uint pairs = cell_pairs(), pair = 0u;
    do {
        uvec2 bits = cell_pair(x, pair, pairs);
        bits = holding(bits, pair * 64u, x) & bits;
        do {
            bool any_left = (bits.x | bits.y) != 0u;
            uint i = pair * 64u + take_bit(bits);
            if (any_left) {
                vec4 s = sample_joint(i, x);
                best = s.x > best.x ? s : best;
            }
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return best;
}

// Contact of two samples to a depth that a controller gives. Towards (1, 1) the depths' slices jump: no contact there.
vec4 meet(uint kind, uint curve, vec4 a, vec4 b) {
    float lengths = sqrt(dot(a.yzw, a.yzw) * dot(b.yzw, b.yzw));
    float cosine = lengths > NULL_GRADIENT * NULL_GRADIENT ? dot(a.yzw, b.yzw) / lengths : 1.0;
    float inside = clamp(10.0 * (0.9 - min(a.x, b.x)), 0.0, 1.0);
    float depth = inside * on_curve(curve, cosine);
    sheet = max(sheet, depth * min(a.x, b.x) / max(max(a.x, b.x), FAINT));
    vec3 g = operate(kind, a.x, b.x, depth);
    vec4 met = vec4(g.x, g.y * a.yzw + g.z * b.yzw);
    return b.x < FAINT ? a : a.x < FAINT ? b : met;
}

// The walk over the leaves whose boxes hold x, in their order; a leaf's group goes into the total when the next group begins.
vec4 fold(vec3 x) {
    vec4 total = vec4(0.0), group = vec4(0.0);
    sheet = 0.0;
    uint of = 0xffu, depth = 0u; // the group's number, and its controller against the total
    uint pairs = cell_pairs(), pair = 0u;
    do {
        uvec2 bits = cell_pair(x, pair, pairs);
        bits = holding(bits, pair * 64u, x) & bits;
        do {
            bool any_left = (bits.x | bits.y) != 0u;
            uint i = pair * 64u + take_bit(bits);
            if (any_left) {
                vec4 s = sample_field(i, field_box(i), x);
                fetches++;
                uint link = field_word(i, LINK);
                if (COMPOSITION == CONTACTS) {
                    total = meet(1u, (link >> 8) & 0xffu, total, s);
                } else {
                    bool same = (link & 0xffu) == of;
                    vec4 met = meet(same ? (link >> 16) & 0xffu : 1u, same ? link >> 24 : depth, same ? group : total, same ? s : group);
                    group = same ? met : s;
                    total = same ? total : met;
                    of = link & 0xffu;
                    depth = (link >> 8) & 0xffu;
                }
            }
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return COMPOSITION == CONTACTS ? total : meet(1u, depth, total, group);
}

// f and its gradient.
vec4 evaluate(vec3 x) {
    return COMPOSITION >= CONTACTS ? fold(x) : greatest(x);
}

#endif
