// Copies one vec4 an invocation. Measures the device's memory, nothing of a character.
#version 460

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer Source { vec4 source[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Target { vec4 target[]; };

layout(push_constant) uniform Constants {
    uint count;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        target[i] = source[i];
    }
}
