#version 460
#extension GL_GOOGLE_include_directive : require
// The skin is in model space already: there are no joints here, just a camera. The fragment shader is that of
// `dermis render`, so that the pictures can be compared.

#include "shared/skin.glsl"

layout(location = 0) in vec3 skin_position;
layout(location = 1) in vec3 skin_normal;

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec3 colour;
layout(location = 3) out vec3 barycentric;

// Clay, OKLCH (0.80, 0.042, 58°).
const vec3 CLAY = vec3(0.65306, 0.47753, 0.36998);

void main() {
    position = skin_position;
    normal = skin_normal;
    colour = CLAY;
    barycentric = vec3(0); // edges are not drawn
    gl_Position = constants.clip_from_model * vec4(position, 1);
}
