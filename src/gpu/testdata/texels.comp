// Doubles the texels of a buffer.
#version 460
layout(local_size_x = 8) in;
layout(set = 0, binding = 0) uniform samplerBuffer texels;
layout(std430, set = 0, binding = 1) writeonly buffer Doubled { vec4 doubled[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    doubled[i] = 2.0 * texelFetch(texels, int(i));
}
