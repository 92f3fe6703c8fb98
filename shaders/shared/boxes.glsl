// The boxes of the posed fields. The including shader defines FIRST_FIELD_BINDING: three bindings from there on are used here.
#ifndef DERMIS_BOXES
#define DERMIS_BOXES
#include "shared/texels.glsl"
#include "shared/types.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING) uniform Head {
    vec4 grid_origin; // w: words of a cell
    vec4 grid_inverse; // cells a unit; w: fields
    vec4 box_scale; // texture coordinates a box coordinate; w: model units a rest unit
    vec4 turn; // w: the furthest that any joint turns in the frame, degrees
} fields;
layout(set = 0, binding = FIRST_FIELD_BINDING + 1) uniform samplerBuffer field_poses; // head and poses in one buffer
layout(set = 0, binding = FIRST_FIELD_BINDING + 2) uniform usamplerBuffer field_words; // the same buffer

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

#endif
