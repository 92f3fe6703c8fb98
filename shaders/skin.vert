#version 460
#extension GL_GOOGLE_include_directive : require
// A corner of a triangle, pulled from the file's own rows. The draw is not indexed, so that gl_VertexIndex % 3 gives
// each corner its barycentric coordinate and the fragment shader can draw edges.

#include "shared/skin.glsl"

layout(std430, set = 0, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, set = 0, binding = 1) readonly buffer Normals { float normals[]; };
layout(std430, set = 0, binding = 2) readonly buffer Colours { float colours[]; };
layout(std430, set = 0, binding = 3) readonly buffer Corners { uint corners[]; };

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec3 colour;
layout(location = 3) out vec3 barycentric;

void main() {
    uint row = 3 * corners[gl_VertexIndex];
    position = vec3(positions[row], positions[row + 1], positions[row + 2]);
    normal = vec3(normals[row], normals[row + 1], normals[row + 2]);
    colour = vec3(colours[row], colours[row + 1], colours[row + 2]);
    int corner = gl_VertexIndex % 3;
    barycentric = vec3(corner == 0, corner == 1, corner == 2);
    gl_Position = constants.clip_from_model * vec4(position, 1);
}
