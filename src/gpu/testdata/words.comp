// Doubles the words of a buffer.
#version 460
layout(local_size_x = 8) in;
layout(set = 0, binding = 0) uniform usamplerBuffer words;
layout(std430, set = 0, binding = 1) writeonly buffer Doubled { uint doubled[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    doubled[i] = 2u * texelFetch(words, int(i)).x;
}
