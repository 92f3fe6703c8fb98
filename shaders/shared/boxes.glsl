// The boxes of the posed fields. The including shader defines FIRST_FIELD_BINDING: two bindings from there on are used here,
// once main has called find_fields.
#ifndef DERMIS_BOXES
#define DERMIS_BOXES
#include "shared/texels.glsl"
#include "shared/types.glsl"

layout(set = 0, binding = FIRST_FIELD_BINDING) uniform samplerBuffer field_poses; // head and poses in one buffer
layout(set = 0, binding = FIRST_FIELD_BINDING + 1) uniform usamplerBuffer field_words; // the same buffer

// The lines of this instance's head (types.glsl) that an evaluation reads, and where its parts of poses and index begin.
struct FieldsHead {
    vec4 grid_origin, grid_inverse, box_scale, turn;
};
FieldsHead fields;
uint field_first, index_first;

// Finds this instance's fields in parts with room for `count`.
void find_fields(uint count) {
    field_first = part(FIELD_HEAD + FIELD_TEXELS * count);
    fields.grid_origin = fetch(field_poses, field_first + GRID_ORIGIN);
    fields.grid_inverse = fetch(field_poses, field_first + GRID_INVERSE);
    fields.box_scale = fetch(field_poses, field_first + BOX_SCALE);
    fields.turn = fetch(field_poses, field_first + TURN);
    index_first = part(uint(fields.grid_origin.w) * uint(CELLS * CELLS * CELLS));
}

// One of the four words of field i.
uint field_word(uint i, uint k) {
    return word(field_words, 4u * (field_first + FIELD_HEAD + FIELD_TEXELS * i + 3u) + k);
}

// Model space → box coordinates of a field, in which its box is [0,1]³.
struct Box {
    vec4 row0, row1, row2;
};

Box field_box(uint i) {
    uint at = field_first + FIELD_HEAD + FIELD_TEXELS * i;
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
