// Linear blend skinning of positions; normals by the cofactors of the blended matrix.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer rows;
layout(set = 0, binding = 1) uniform samplerBuffer row_normals;
layout(set = 0, binding = 2) uniform samplerBuffer vertices;
layout(set = 0, binding = 3) uniform usamplerBuffer influence_joints;
layout(set = 0, binding = 4) uniform usamplerBuffer influence_weights;
layout(set = 0, binding = 5) uniform samplerBuffer palette;
layout(set = 0, binding = 6, std430) writeonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Normals { vec4 normal[]; };
layout(push_constant) uniform Constants {
    uint rows;
    uint width; // influences a vertex
    uint joints;
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.rows) {
        return;
    }
    uint v = word(rows, row), at = part(constants.rows) + row, joints = part(JOINT_TEXELS * constants.joints);
    vec4 row0 = vec4(0.0), row1 = vec4(0.0), row2 = vec4(0.0);
    for (uint k = 0u; k < constants.width; k++) {
        uint influence = v * constants.width + k;
        float w = number(influence_weights, influence);
        if (w == 0.0) {
            break;
        }
        uint j = joints + ((word(influence_joints, influence >> 1) >> ((influence & 1u) * 16u)) & 0xffffu) * JOINT_TEXELS;
        row0 += w * fetch(palette, j);
        row1 += w * fetch(palette, j + 1u);
        row2 += w * fetch(palette, j + 2u);
    }
    vec3 p = fetch(vertices, 2u * v).xyz;
    vec3 n = fetch(row_normals, row).xyz;
    p = vec3(dot(row0.xyz, p) + row0.w, dot(row1.xyz, p) + row1.w, dot(row2.xyz, p) + row2.w);
    // Rows of the cofactor matrix, which carries normals through any invertible map up to length.
    n = vec3(dot(cross(row1.xyz, row2.xyz), n), dot(cross(row2.xyz, row0.xyz), n), dot(cross(row0.xyz, row1.xyz), n));
    position[at] = vec4(p, 0.0);
    normal[at] = vec4(n / max(length(n), 1e-20), 0.0);
}
