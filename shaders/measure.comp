// The composed field at every vertex: iso-values at rest, and the field that the output reports.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_FIELD_BINDING 2
#include "shared/field.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Positions { vec4 position[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Values { float value[]; };
layout(push_constant) uniform Constants {
    uint vertices;
} constants;

void main() {
    uint v = gl_GlobalInvocationID.x;
    if (v < constants.vertices) {
        value[v] = evaluate(position[v].xyz).x;
    }
}
