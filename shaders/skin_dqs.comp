// Dual-quaternion skinning (Kavan et al. 2008) of positions and normals, after blending the joints' stretches.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
#include "shared/types.glsl"
#include "shared/rotation.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer rows;
layout(set = 0, binding = 1) uniform samplerBuffer row_normals;
layout(set = 0, binding = 2) uniform samplerBuffer vertices;
layout(set = 0, binding = 3) uniform usamplerBuffer influence_joints;
layout(set = 0, binding = 4) uniform usamplerBuffer influence_weights;
layout(set = 0, binding = 5) uniform samplerBuffer palette;
layout(set = 0, binding = 6, std430) writeonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Normals { vec4 normal[]; };
layout(set = 0, binding = 8, std430) writeonly buffer Rotations { vec4 rotation[]; };
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
    bool stretched = fetch(palette, joints + STRETCH + 1u).w != 0.0;
    vec4 real = vec4(0.0), dual = vec4(0.0), pivot = vec4(0.0);
    vec3 diagonal = vec3(0.0), off = vec3(0.0);
    for (uint k = 0u; k < constants.width; k++) {
        uint influence = v * constants.width + k;
        float w = number(influence_weights, influence);
        if (w == 0.0) {
            break;
        }
        uint j = joints + ((word(influence_joints, influence >> 1) >> ((influence & 1u) * 16u)) & 0xffffu) * JOINT_TEXELS;
        vec4 q = fetch(palette, j + REAL);
        if (k == 0u) {
            pivot = q;
        }
        // q and −q are the same rotation: blend on the side of the heaviest joint.
        float s = dot(q, pivot) < 0.0 ? -w : w;
        real += s * q;
        dual += s * fetch(palette, j + DUAL);
        if (stretched) {
            vec4 a = fetch(palette, j + STRETCH), b = fetch(palette, j + STRETCH + 1u);
            diagonal += w * vec3(a.x, b.x, b.z);
            off += w * vec3(a.y, a.z, b.y);
        }
    }
    vec3 p = fetch(vertices, 2u * v).xyz;
    vec3 n = fetch(row_normals, row).xyz;
    if (stretched) {
        vec3 c0 = vec3(diagonal.x, off.x, off.y), c1 = vec3(off.x, diagonal.y, off.z), c2 = vec3(off.y, off.z, diagonal.z);
        p = c0 * p.x + c1 * p.y + c2 * p.z;
        n = cross(c1, c2) * n.x + cross(c2, c0) * n.y + cross(c0, c1) * n.z;
    }
    float l = length(real);
    real /= l;
    dual /= l;
    p = rotate(real, p) + 2.0 * (real.w * dual.xyz - dual.w * real.xyz + cross(real.xyz, dual.xyz));
    n = rotate(real, n);
    position[at] = vec4(p, 0.0);
    normal[at] = vec4(n / max(length(n), 1e-20), 0.0);
    rotation[at] = real;
}
