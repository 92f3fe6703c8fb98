// Linearly filtered 3D samples at best: a workgroup stays within one tile of the atlas and its lanes lie close together,
// so that samples share texels. Measures the device's ceiling, nothing of a character.
#version 460

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform sampler3D atlas;
layout(std430, set = 0, binding = 1) writeonly buffer Sums { vec4 sums[]; };

layout(push_constant) uniform Constants {
    uint count;
};

const uint SAMPLES = 16;
const uint TILE = 32;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) {
        return;
    }
    uvec3 extent = uvec3(textureSize(atlas, 0));
    uvec3 tiles = extent / TILE;
    uint tile = (gl_WorkGroupID.x * 2654435761u >> 16) % (tiles.x * tiles.y * tiles.z);
    uvec3 corner = TILE * uvec3(tile % tiles.x, tile / tiles.x % tiles.y, tile / (tiles.x * tiles.y));
    uvec2 lane = uvec2(i % 8, i / 8 % 8);

    // Steps in quarters of a texel: every device computes them and their filter weights exactly.
    vec3 p = vec3(corner) + vec3(vec2(lane) * 1.25 + 8.75, 0.75);
    vec4 sum = vec4(0);
    for (uint k = 0; k < SAMPLES; ++k) {
        sum += textureLod(atlas, p / vec3(extent), 0);
        p += vec3(0.5, 0.25, 1.75);
    }
    sums[i] = sum;
}
