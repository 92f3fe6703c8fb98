// Writes the workgroup counts of an indirect dispatch from a uniform buffer.
#version 460
layout(local_size_x = 1) in;
layout(std140, set = 0, binding = 0) uniform Wanted { uint groups; };
layout(std430, set = 0, binding = 1) writeonly buffer Counts { uint counts[3]; };
void main() {
    counts[0] = groups;
    counts[1] = 1;
    counts[2] = 1;
}
