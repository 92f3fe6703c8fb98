// Paints a volume with its own texel coordinates.
#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(set = 0, binding = 0, rgba16f) uniform writeonly image3D volume;
void main() {
    ivec3 p = ivec3(gl_GlobalInvocationID);
    if (all(lessThan(p, imageSize(volume)))) imageStore(volume, p, vec4(p, 1));
}
