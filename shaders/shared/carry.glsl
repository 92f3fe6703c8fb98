// Matrices of the palette. The including shader declares palette before, and constants with the number of joints.
#ifndef DERMIS_CARRY
#define DERMIS_CARRY

// A point (w = 1) or a direction (w = 0) carried by three rows of a matrix.
vec3 carry(uint texel, vec4 x) {
    uint at = part(JOINT_TEXELS * constants.joints) + texel;
    return vec3(dot(fetch(palette, at), x), dot(fetch(palette, at + 1u), x), dot(fetch(palette, at + 2u), x));
}

#endif
