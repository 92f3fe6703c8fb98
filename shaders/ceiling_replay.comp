// The samples of a projection and nothing else: same places, same order, same atlas. Measures what the device can do at
// best where samples share few texels, unlike the even walk of ceiling_fetch.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer places; // texture coordinates
layout(set = 0, binding = 1) uniform sampler3D atlas;
layout(set = 0, binding = 2, std430) writeonly buffer Sums { vec4 sums[]; };
layout(push_constant) uniform Constants {
    uint count; // invocations, SAMPLES places each
    uint repeats; // samples a place
} constants;

const uint SAMPLES = 4u;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= constants.count) {
        return;
    }
    vec4 sum = vec4(0.0);
    for (uint r = 0u; r < constants.repeats; r++) {
        for (uint k = 0u; k < SAMPLES; k++) {
            // Each place hangs on the sample before, so that no sample is left out; by less than rounding.
            sum += textureLod(atlas, fetch(places, SAMPLES * i + k).xyz + 1e-12 * sum.xyz, 0.0);
        }
    }
    sums[i] = sum;
}
