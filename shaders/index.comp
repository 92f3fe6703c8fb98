// Index of the posed field boxes: for every cell of a 32³ grid a bit mask of the fields whose box meets it.
// Each workgroup enters one field (x) into a share (y) of the cells around its box.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform Fields {
    vec4 grid_origin; // w: words of a cell
    vec4 grid_inverse; // cells a unit; w: fields
    vec4 box_scale;
    FieldPose field[MAX_FIELDS];
} fields;
layout(set = 0, binding = 1, std430) buffer Index { uint index[]; };

const float MARGIN = 1e-4; // of a box: rounding must not lose a field

// The parallelepiped that the axis-aligned box (centre, half) becomes in box coordinates meets [0,1]³:
// tested by its extent along the three box axes, so a near miss may pass.
bool meets(uint i, vec3 centre, vec3 half_size) {
    vec4 row0 = fields.field[i].row0, row1 = fields.field[i].row1, row2 = fields.field[i].row2;
    vec3 at = vec3(dot(row0.xyz, centre) + row0.w, dot(row1.xyz, centre) + row1.w, dot(row2.xyz, centre) + row2.w);
    vec3 reach = vec3(dot(abs(row0.xyz), half_size), dot(abs(row1.xyz), half_size), dot(abs(row2.xyz), half_size)) + MARGIN;
    return all(greaterThanEqual(at + reach, vec3(0.0))) && all(lessThanEqual(at - reach, vec3(1.0)));
}

void main() {
    uint i = gl_WorkGroupID.x;
    uint words = uint(index.length()) / uint(CELLS * CELLS * CELLS);
    uvec3 first = unpack(fields.field[i].first_cell);
    uvec3 size = unpack(fields.field[i].last_cell) - first + 1u;
    vec3 cell = 1.0 / fields.grid_inverse.xyz;
    uint count = float(i) < fields.grid_inverse.w ? size.x * size.y * size.z : 0u;
    uint k = gl_WorkGroupID.y * 64u + gl_LocalInvocationIndex;
    do {
        uvec3 id = first + uvec3(k % size.x, k / size.x % size.y, k / (size.x * size.y));
        vec3 centre = fields.grid_origin.xyz + (vec3(id) + 0.5) * cell;
        if (k < count && meets(i, centre, 0.5 * cell)) {
            uint at = ((id.z * uint(CELLS) + id.y) * uint(CELLS) + id.x) * words + (i >> 5);
            atomicOr(index[at], 1u << (i & 31u)); // bits of one word in any order
        }
        k += gl_NumWorkGroups.y * 64u;
    } while (k < count);
}
