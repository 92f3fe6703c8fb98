// Adds a constant to every element; on any number of workgroups, the element count bounds it.
#version 460
layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) readonly buffer Source { uint source[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Target { uint target[]; };
layout(push_constant) uniform Constants { uint count; uint addend; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) target[i] = source[i] + addend;
}
