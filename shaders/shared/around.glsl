// The fields around a point of model space, by the index: which boxes hold it. Uses three bindings from FIRST_FIELD_BINDING on.
//
// Software rasterisers run a loop's body at least once; so loops test at their end.
#ifndef DERMIS_AROUND
#define DERMIS_AROUND
#include "shared/boxes.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING + 2) uniform usamplerBuffer index;

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
    uint i = index_first + 2u * (((c.z * uint(CELLS) + c.y) * uint(CELLS) + c.x) * pairs + pair);
    return inside ? uvec2(word(index, i), word(index, i + 1u)) : uvec2(0u);
}

// Pairs of words of an index cell.
uint cell_pairs() {
    return uint(fields.grid_origin.w) >> 1;
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

// The same where all of them have this motion, which stands in the top byte of their word `of`: TILE since the pose before,
// FIRST_CELL since rest; 0 where one has another.
uint fields_moving_as(uint motion, uint of, vec3 x) {
    uint pairs = cell_pairs(), pair = 0u, around = 0u;
    bool as_one = motion != NO_MOTION;
    do {
        uvec2 bits = as_one ? cell_pair(x, pair, pairs) : uvec2(0u);
        do {
            bool any_left = (bits.x | bits.y) != 0u;
            uint i = pair * 64u + take_bit(bits);
            bool held = any_left && holds(field_box(i), x);
            around += held ? 1u : 0u;
            as_one = as_one && !(held && field_word(i, of) >> 24 != motion);
            bits = as_one ? bits : uvec2(0u);
        } while ((bits.x | bits.y) != 0u);
        pair++;
    } while (pair < pairs);
    return as_one ? around : 0u;
}

#endif
