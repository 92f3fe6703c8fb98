// From welded vertices to the file's rows: duplicates get the same position bit for bit; a row's own normal follows the
// blended rotation and then the turn from the rotated to the recomputed smooth normal, so that hard edges stay hard.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#include "shared/rotation.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Rows { uint vertex_of[]; };
layout(set = 0, binding = 1, std430) readonly buffer RowNormals { float row_normal[]; };
layout(set = 0, binding = 2, std430) readonly buffer Vertices { Vertex vertex[]; };
layout(set = 0, binding = 3, std430) readonly buffer Rotations { vec4 rotation[]; };
layout(set = 0, binding = 4, std430) readonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 5, std430) readonly buffer SmoothNormals { vec4 smooth_normal[]; };
layout(set = 0, binding = 6, std430) writeonly buffer SkinPositions { vec4 skin_position[]; };
layout(set = 0, binding = 7, std430) writeonly buffer SkinNormals { vec4 skin_normal[]; };
layout(push_constant) uniform Constants {
    uint rows;
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.rows) {
        return;
    }
    uint v = vertex_of[row];
    vec4 q = rotation[v];
    vec3 n = rotate(q, vec3(row_normal[row * 3u], row_normal[row * 3u + 1u], row_normal[row * 3u + 2u]));
    n = rotate_between(rotate(q, vertex[v].normal), smooth_normal[v].xyz, n);
    skin_position[row] = position[v];
    skin_normal[row] = vec4(n / max(length(n), 1e-20), 0.0);
}
