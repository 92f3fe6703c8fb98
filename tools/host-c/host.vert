#version 450
// The skin is in model space already: there are no joints here, just a camera.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

layout(push_constant) uniform Camera { mat4 clip_from_model; } camera;

layout(location = 0) out vec3 shading_normal;

void main() {
    shading_normal = normal;
    gl_Position = camera.clip_from_model * vec4(position, 1.0);
}
