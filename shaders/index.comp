// Index of the posed field boxes: for every cell of a 32³ grid a bit mask of the fields whose box meets it.
// A workgroup of 4³ cells first culls the fields against itself, then each cell tests the survivors.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;

layout(set = 0, binding = 0) uniform Fields {
    vec4 grid_origin; // w: words of a cell
    vec4 grid_inverse; // cells a unit; w: fields
    vec4 box_scale;
    FieldPose field[MAX_FIELDS];
} fields;
layout(set = 0, binding = 1, std430) writeonly buffer Index { uint index[]; };

const uint WORDS = (MAX_FIELDS + 31u) / 32u;
const float MARGIN = 1e-4; // of a box: rounding must not lose a field
shared uint survivors[WORDS];

// The parallelepiped that the axis-aligned box (centre, half) becomes in box coordinates meets [0,1]³:
// tested by its extent along the three box axes, so a near miss may pass.
bool meets(uint i, vec3 centre, vec3 half_size) {
    vec4 row0 = fields.field[i].row0, row1 = fields.field[i].row1, row2 = fields.field[i].row2;
    vec3 at = vec3(dot(row0.xyz, centre) + row0.w, dot(row1.xyz, centre) + row1.w, dot(row2.xyz, centre) + row2.w);
    vec3 reach = vec3(dot(abs(row0.xyz), half_size), dot(abs(row1.xyz), half_size), dot(abs(row2.xyz), half_size)) + MARGIN;
    return all(greaterThanEqual(at + reach, vec3(0.0))) && all(lessThanEqual(at - reach, vec3(1.0)));
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < WORDS) {
        survivors[lane] = 0u;
    }
    barrier();
    vec3 cell = 1.0 / fields.grid_inverse.xyz;
    vec3 group = fields.grid_origin.xyz + (vec3(gl_WorkGroupID) * 4.0 + 2.0) * cell;
    uint count = uint(fields.grid_inverse.w);
    for (uint i = lane; i < count; i += 64u) {
        if (meets(i, group, 2.0 * cell)) {
            atomicOr(survivors[i >> 5], 1u << (i & 31u));
        }
    }
    barrier();
    vec3 centre = fields.grid_origin.xyz + (vec3(gl_GlobalInvocationID) + 0.5) * cell;
    uint words = uint(fields.grid_origin.w);
    uint at = ((gl_GlobalInvocationID.z * uint(CELLS) + gl_GlobalInvocationID.y) * uint(CELLS) + gl_GlobalInvocationID.x) * words;
    for (uint word = 0u; word < words; word++) {
        uint bits = survivors[word], kept = 0u;
        while (bits != 0u) {
            uint bit = uint(findLSB(bits));
            bits &= bits - 1u;
            if (meets(word * 32u + bit, centre, 0.5 * cell)) {
                kept |= 1u << bit;
            }
        }
        index[at + word] = kept;
    }
}
