// Index of the posed field boxes: for every cell of a 32³ grid a bit mask of the fields whose box meets it.
// SLICES workgroups enter one field, each into a share of the cells around its box.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 0
#include "shared/boxes.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 2, std430) buffer Index { uint index[]; };
layout(push_constant) uniform Constants {
    uint fields; // that a part has room for
} constants;

const uint SLICES = 4u;
const float MARGIN = 1e-4; // of a box: rounding must not lose a field

// The parallelepiped that the axis-aligned box (centre, half) becomes in box coordinates meets [0,1]³:
// tested by its extent along the three box axes, so a near miss may pass.
bool meets(Box box, vec3 centre, vec3 half_size) {
    vec3 at = in_box(box, centre);
    vec3 reach = vec3(dot(abs(box.row0.xyz), half_size), dot(abs(box.row1.xyz), half_size), dot(abs(box.row2.xyz), half_size)) + MARGIN;
    return all(greaterThanEqual(at + reach, vec3(0.0))) && all(lessThanEqual(at - reach, vec3(1.0)));
}

void main() {
    find_fields(constants.fields);
    uint i = gl_WorkGroupID.x / SLICES, slice = gl_WorkGroupID.x % SLICES;
    uint words = uint(fields.grid_origin.w);
    Box box = field_box(i);
    uvec3 first = unpack(field_word(i, FIRST_CELL));
    uvec3 size = unpack_cell(field_word(i, LAST_CELL)) - first + 1u;
    vec3 cell = 1.0 / fields.grid_inverse.xyz;
    uint count = float(i) < fields.grid_inverse.w ? size.x * size.y * size.z : 0u;
    // Division of integers is slow on software rasterisers; these quotients are exact, being below 2^15 and half a cell off.
    float row = 1.0 / float(size.x), layer = 1.0 / float(size.x * size.y);
    uint k = slice * 64u + gl_LocalInvocationIndex;
    do {
        uint z = uint((float(k) + 0.5) * layer), in_layer = k - z * size.x * size.y;
        uint y = uint((float(in_layer) + 0.5) * row);
        uvec3 id = first + uvec3(in_layer - y * size.x, y, z);
        vec3 centre = fields.grid_origin.xyz + (vec3(id) + 0.5) * cell;
        if (k < count && meets(box, centre, 0.5 * cell)) {
            uint at = index_first + ((id.z * uint(CELLS) + id.y) * uint(CELLS) + id.x) * words + (i >> 5);
            atomicOr(index[at], 1u << (i & 31u)); // bits of one word in any order
        }
        k += SLICES * 64u;
    } while (k < count);
}
