// Area-weighted normals of the welded mesh.
#version 460
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer CornerOffsets { uint corner_offset[]; };
layout(set = 0, binding = 1, std430) readonly buffer Corners { uint corner[]; };
layout(set = 0, binding = 2, std430) readonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 3, std430) writeonly buffer SmoothNormals { vec4 smooth_normal[]; };
layout(push_constant) uniform Constants {
    uint vertices;
} constants;

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v >= constants.vertices) {
        return;
    }
    vec3 x = position[v].xyz, n = vec3(0.0);
    for (uint k = corner_offset[v]; k < corner_offset[v + 1u]; k += 2u) {
        n += cross(position[corner[k]].xyz - x, position[corner[k + 1u]].xyz - x);
    }
    smooth_normal[v] = vec4(n / max(length(n), 1e-30), 0.0);
}
