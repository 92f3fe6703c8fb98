// From welded vertices to the file's rows: duplicates get the same position bit for bit; a row's own normal follows the
// blended rotation and then the turn from the rotated to the recomputed smooth normal, so that hard edges stay hard.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
#include "shared/rotation.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer rows;
layout(set = 0, binding = 1) uniform samplerBuffer row_normals;
layout(set = 0, binding = 2) uniform samplerBuffer vertices;
layout(set = 0, binding = 3) uniform samplerBuffer rotations;
layout(set = 0, binding = 4) uniform samplerBuffer positions;
layout(set = 0, binding = 5) uniform samplerBuffer smooth_normals;
layout(set = 0, binding = 6, std430) writeonly buffer SkinPositions { vec4 skin_position[]; };
layout(set = 0, binding = 7, std430) writeonly buffer SkinNormals { vec4 skin_normal[]; };
layout(push_constant) uniform Constants {
    uint rows;
    uint vertices; // welded
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.rows) {
        return;
    }
    uint v = word(rows, row);
    uint first = part(constants.vertices), at = part(constants.rows) + row;
    vec4 q = fetch(rotations, first + v);
    vec3 n = rotate(q, fetch(row_normals, row).xyz);
    n = rotate_between(rotate(q, fetch(vertices, 2u * v + 1u).xyz), fetch(smooth_normals, first + v).xyz, n);
    skin_position[at] = fetch(positions, first + v);
    skin_normal[at] = vec4(n / max(length(n), 1e-20), 0.0);
}
