// The composed field f and its gradient at a point of model space: index cell → fields → operators → maximum (Eq. 3).
// The including shader defines FIRST_FIELD_BINDING: seven bindings from there on are used here.
//
// Fields and index are read as texels: software rasterisers load buffers word by word and lane by lane, texels at once.
// Software rasterisers run both sides of a branch and a loop's body at least once; so loops test at their end.
#ifndef DERMIS_FIELD
#define DERMIS_FIELD
#include "shared/texels.glsl"
#include "shared/types.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING) uniform Head {
    vec4 grid_origin; // w: words of a cell
    vec4 grid_inverse; // cells a unit; w: fields
    vec4 box_scale; // texture coordinates a box coordinate; w: model units a rest unit
} fields;
layout(set = 0, binding = FIRST_FIELD_BINDING + 1) uniform samplerBuffer field_poses; // head and poses in one buffer
layout(set = 0, binding = FIRST_FIELD_BINDING + 2) uniform usamplerBuffer field_words; // the same buffer
layout(set = 0, binding = FIRST_FIELD_BINDING + 3) uniform usamplerBuffer index;
layout(set = 0, binding = FIRST_FIELD_BINDING + 4) uniform sampler3D atlas;
layout(set = 0, binding = FIRST_FIELD_BINDING + 5) uniform sampler3D operators;
layout(set = 0, binding = FIRST_FIELD_BINDING + 6) uniform usamplerBuffer opening;

layout(constant_id = 0) const uint OPERATORS = 0u; // 0: every joint is a union

const float NULL_GRADIENT = 1e-6; // shorter gradients have no direction
const float OPENING_ROWS = 128.0;

uint fetches = 0u;

// One of the four words of field i.
uint field_word(uint i, uint k) {
    return word(field_words, 4u * (FIELD_HEAD + FIELD_TEXELS * i + 3u) + k);
}

// Model space → box coordinates of a field, in which its box is [0,1]³.
struct Box {
    vec4 row0, row1, row2;
};

Box field_box(uint i) {
    uint at = FIELD_HEAD + FIELD_TEXELS * i;
    return Box(fetch(field_poses, at), fetch(field_poses, at + 1u), fetch(field_poses, at + 2u));
}

vec3 in_box(Box box, vec3 x) {
    return vec3(dot(box.row0.xyz, x) + box.row0.w, dot(box.row1.xyz, x) + box.row1.w, dot(box.row2.xyz, x) + box.row2.w);
}

bool holds(Box box, vec3 x) {
    vec3 at = in_box(box, x);
    return all(equal(at, clamp(at, 0.0, 1.0)));
}

// f and ∂f/∂x of field i at a point in its box.
vec4 sample_field(uint i, Box box, vec3 x) {
    // Texel i of a tile of 32 lies at box coordinate i / 31.
    vec3 tile = (vec3(unpack(field_word(i, TILE))) * 32.0 + 0.5) / 31.0;
    vec4 t = textureLod(atlas, (tile + clamp(in_box(box, x), 0.0, 1.0)) * fields.box_scale.xyz, 0.0);
    return vec4(t.x, t.y * box.row0.xyz + t.z * box.row1.xyz + t.w * box.row2.xyz);
}

// tan θ of an opening curve for the angle between two gradients (section 4.2), from its table over cos α.
float tan_opening(uint curve, float cosine) {
    float at = clamp(cosine * 0.5 + 0.5, 0.0, 1.0) * (OPENING_ROWS - 1.0);
    uint row = min(uint(at), uint(OPENING_ROWS) - 2u);
    uint base = curve * uint(OPENING_ROWS) + row;
    return mix(number(opening, base), number(opening, base + 1u), at - float(row));
}

// Operator number `kind` (from 1) on two samples. The operators' volumes of 128³ lie above each other in z.
vec4 combine(uint kind, uint curve, vec4 a, vec4 b) {
    float la = length(a.yzw), lb = length(b.yzw);
    if (min(la, lb) < NULL_GRADIENT) {
        return a.x >= b.x ? a : b;
    }
    float angle = tan_opening(curve, dot(a.yzw, b.yzw) / (la * lb));
    vec3 at = clamp(vec3(a.x, b.x, angle), 0.0, 1.0) * 127.0 + 0.5;
    at.z += 128.0 * float(kind - 1u);
    fetches++;
    vec4 g = textureLod(operators, at / vec3(textureSize(operators, 0)), 0.0);
    return vec4(g.x, g.y * a.yzw + g.z * b.yzw);
}

// Field i at a point in its box, combined with its parent where their joint has an operator other than the union.
vec4 sample_joint(uint i, vec3 x) {
    vec4 s = sample_field(i, field_box(i), x);
    fetches++;
    if (OPERATORS != 0u) {
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

// Takes the lowest bit out of a pair of words; its number, or 0 where there is none.
uint take_bit(inout uvec2 bits) {
    bool low = bits.x != 0u;
    uint mask = low ? bits.x : bits.y;
    bits = low ? uvec2(bits.x & (bits.x - 1u), bits.y) : uvec2(0u, bits.y & (bits.y - 1u));
    return uint(max(findLSB(mask), 0)) + (low ? 0u : 32u);
}

// Those of 64 fields from `first` on whose boxes hold x. Half of a cell's fields are elsewhere in the cell, and the test
// costs far less than a sample.
uvec2 holding(uvec2 bits, uint first, vec3 x) {
    uvec2 held = uvec2(0u);
    do {
        uint bit = take_bit(bits);
        uint one = holds(field_box(first + bit), x) ? 1u << (bit & 31u) : 0u;
        held |= bit < 32u ? uvec2(one, 0u) : uvec2(0u, one);
    } while ((bits.x | bits.y) != 0u);
    return held;
}

// Words of the pair of 64 fields in the index cell that holds x; zero outside the index.
uvec2 cell_pair(vec3 x, uint pair, uint pairs) {
    vec3 at = (x - fields.grid_origin.xyz) * fields.grid_inverse.xyz;
    bool inside = all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(CELLS)));
    uvec3 c = uvec3(clamp(at, vec3(0.0), vec3(CELLS - 1)));
    uint i = 2u * (((c.z * uint(CELLS) + c.y) * uint(CELLS) + c.x) * pairs + pair);
    return inside ? uvec2(word(index, i), word(index, i + 1u)) : uvec2(0u);
}

// Pairs of words of an index cell. Not from the uniform block: a loop limit from there makes lavapipe compile the shader at
// every dispatch.
uint cell_pairs() {
    return uint(textureSize(index)) / uint(2 * CELLS * CELLS * CELLS);
}

// Number of the fields whose boxes hold x.
uint fields_around(vec3 x) {
    uint pairs = cell_pairs(), pair = 0u, around = 0u;
    do {
        uvec2 bits = cell_pair(x, pair, pairs);
        bits = holding(bits, pair * 64u, x) & bits;
        around += uint(bitCount(bits.x) + bitCount(bits.y));
        pair++;
    } while (pair < pairs);
    return around;
}

// The same where all of them have this motion; 0 where one has another.
uint fields_moving_as(uint motion, vec3 x) {
    uint pairs = cell_pairs(), pair = 0u, around = 0u;
    bool as_one = motion != NO_MOTION;
    do {
        uvec2 bits = as_one ? cell_pair(x, pair, pairs) : uvec2(0u);
        do {
            bool any_left = (bits.x | bits.y) != 0u;
            uint i = pair * 64u + take_bit(bits);
            bool held = any_left && holds(field_box(i), x);
            around += held ? 1u : 0u;
            as_one = as_one && !(held && field_word(i, TILE) >> 24 != motion);
            bits = as_one ? bits : uvec2(0u);
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return as_one ? around : 0u;
}

// f and its gradient; zero in empty cells and outside the index.
vec4 evaluate(vec3 x) {
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

#endif
