// Matrices of the palette. The including shader declares palette before.
#ifndef DERMIS_CARRY
#define DERMIS_CARRY

// A point (w = 1) or a direction (w = 0) carried by three rows of a matrix.
vec3 carry(uint texel, vec4 x) {
    return vec3(dot(fetch(palette, texel), x), dot(fetch(palette, texel + 1u), x), dot(fetch(palette, texel + 2u), x));
}

#endif
