// Structs shared with Rust (src/layout): same names, same fields, same order.
#ifndef DERMIS_TYPES
#define DERMIS_TYPES

// A welded vertex at rest.
struct Vertex {
    vec3 position;
    float radius; // of its part; limits every displacement
    vec3 normal;
    uint part; // joint row
};

// A posed joint: rest → model space as a matrix and as stretch followed by a dual quaternion.
struct JointPose {
    vec4 row0, row1, row2;
    vec4 real, dual; // w is the scalar part
    vec4 stretch0; // symmetric stretch: xx xy xz, unused
    vec4 stretch1; // yy yz zz; of joint 0, w: any joint is not rigid
};

// A posed field: model space → box coordinates, its tile in the atlas, its link in the composition, its index cells.
struct FieldPose {
    vec4 row0, row1, row2;
    uint tile; // x | y << 8 | z << 16
    uint link; // parent field | operator volume << 16 | opening << 24
    uint first_cell, last_cell; // x | y << 8 | z << 16
};

uvec3 unpack(uint word) {
    return uvec3(word, word >> 8, word >> 16) & 0xffu;
}

const uint NO_FIELD = 0xffffu;
const uint UNION = 0u;

// The index: cells an axis, and the greatest number of fields that a uniform block of 16 KiB holds.
const int CELLS = 32;
const uint MAX_FIELDS = 255u;

// States of a vertex, as the output reports them; LIVE only while a frame runs.
const uint UNTOUCHED = 0u;
const uint ON_ISO = 1u;
const uint CONTACT = 2u;
const uint OUTSIDE = 3u;
const uint LIMIT = 4u;
const uint LIVE = 5u;

// A status word: state in bits 0–7, evaluations in 8–15, fetches in 16–30 (both saturate), strayed in 31.
const uint STRAYED = 0x80000000u;

uint state_of(uint status) {
    return status & 0xffu;
}

// A work list's head: workgroups for an indirect dispatch, and the number of items.
struct Dispatch {
    uint x, y, z, count;
};

#endif
