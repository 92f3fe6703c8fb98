// What shaders share with Rust (src/layout).
#ifndef DERMIS_TYPES
#define DERMIS_TYPES

// A welded vertex at rest (Vertex) is two texels: position, and radius of its part, which limits every displacement;
// normal, and joint row of its part.

// A posed joint (JointPose) is ten texels: three rows of rest → model space; a dual quaternion, w the scalar part; the
// symmetric stretch before it, xx xy xz and the numbers of its motions (MOTIONS), yy yz zz, where w of joint 0 says that any joint is
// not rigid; three rows of the change since the pose before, model → model space.
const uint JOINT_TEXELS = 10u;
const uint REAL = 3u;
const uint DUAL = 4u;
const uint STRETCH = 5u;
const uint CHANGE = 7u;

// A posed field (FieldPose) is four texels behind the four of the head (FieldsHead): three rows of model space → box
// coordinates, and four words: tile in the atlas, link in the composition, first and last index cell of its box.
const uint FIELD_HEAD = 4u;
const uint FIELD_TEXELS = 4u;
const uint TILE = 0u; // x | y << 8 | z << 16 | motion since the pose before << 24
// parent field | operator volume << 16 | opening << 24;
// in tracking: group | controller against the groups before << 8 | operator volume in the group << 16 | its controller << 24
const uint LINK = 1u;
const uint FIRST_CELL = 2u; // x | y << 8 | z << 16 | motion since rest << 24
const uint LAST_CELL = 3u; // x | y << 5 | z << 10 | joint << 16

// Joints and fields with the same number move as one; no field moves with those of NO_MOTION. A joint's two numbers are one:
// that of its motion since the pose before, and MOTIONS times that since rest.
const uint NO_MOTION = 255u;
const uint MOTIONS = 256u;

// Texels of the head's lines.
const uint GRID_ORIGIN = 0u; // w: words of a cell
const uint GRID_INVERSE = 1u; // cells a unit; w: fields
const uint BOX_SCALE = 2u; // texture coordinates a box coordinate; w: model units a rest unit
// Last round of iterations; 1 where the skin is carried on; 1 where faults have it done again in halves; w: degrees that any joint
// turns in the frame at most.
const uint TURN = 3u;

uvec3 unpack(uint word) {
    return uvec3(word, word >> 8, word >> 16) & 0xffu;
}

// The cell of LAST_CELL.
uvec3 unpack_cell(uint word) {
    return uvec3(word, word >> 5, word >> 10) & 0x1fu;
}

// A row that follows a spine (FleshRow) is seven texels; the last has words.
const uint FLESH_TEXELS = 7u;

// The joint of LAST_CELL.
uint joint_of(uint word) {
    return word >> 16;
}

const uint NO_FIELD = 0xffffu;
const uint UNION = 0u;

// How a shader composes fields (COMPOSITION): every joint is a union; operators at joints, then the greatest of all; contacts
// from leaf to leaf; the same with groups of bulges below.
const uint UNIONS = 0u;
const uint OPERATORS = 1u;
const uint CONTACTS = 2u;
const uint GROUPS = 3u;

// Cells of the index along an axis.
const int CELLS = 32;

// States of a vertex, as the output reports them; LIVE only while a frame runs.
const uint UNTOUCHED = 0u;
const uint ON_ISO = 1u;
const uint CONTACT = 2u;
const uint OUTSIDE = 3u;
const uint LIMIT = 4u;
const uint PAST_LIMIT = 5u;
const uint LIVE = 6u;

// A status word: state in bits 0–7, evaluations in 8–15, fetches in 16–30 (both saturate), strayed in 31.
const uint STRAYED = 0x80000000u;

uint state_of(uint status) {
    return status & 0xffu;
}

#endif
