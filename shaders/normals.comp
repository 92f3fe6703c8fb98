// Area-weighted normals of the welded mesh.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer corner_offsets;
layout(set = 0, binding = 1) uniform usamplerBuffer corners;
layout(set = 0, binding = 2) uniform samplerBuffer positions;
layout(set = 0, binding = 3, std430) writeonly buffer SmoothNormals { vec4 smooth_normal[]; };
layout(push_constant) uniform Constants {
    uint vertices;
} constants;

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v >= constants.vertices) {
        return;
    }
    uint first = part(constants.vertices);
    vec3 x = fetch(positions, first + v).xyz, n = vec3(0.0);
    uint begin = word(corner_offsets, v), end = word(corner_offsets, v + 1u);
    for (uint k = begin; k < end; k += 2u) {
        n += cross(fetch(positions, first + word(corners, k)).xyz - x, fetch(positions, first + word(corners, k + 1u)).xyz - x);
    }
    smooth_normal[first + v] = vec4(n / max(length(n), 1e-30), 0.0);
}
