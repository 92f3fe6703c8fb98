// Samples a volume half a texel towards +x, and outside it.
#version 460
layout(local_size_x = 8) in;
layout(set = 0, binding = 0) uniform sampler3D volume;
layout(std430, set = 0, binding = 1) writeonly buffer Samples { vec4 samples[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    vec3 p = (vec3(i, 1, 2) + vec3(1.0, 0.5, 0.5)) / vec3(textureSize(volume, 0));
    samples[i] = textureLod(volume, p, 0);
}
