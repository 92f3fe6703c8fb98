// From the skin to the host's vertex buffer: positions as three floats at the beginning of every vertex, normals where and how the
// host wants them. Everything else in the buffer stays as it is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/texels.glsl"
layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform samplerBuffer skin_positions;
layout(set = 0, binding = 1) uniform samplerBuffer skin_normals;
layout(set = 0, binding = 2, std430) writeonly buffer HostVertices { uint host_vertices[]; };
layout(push_constant) uniform Constants {
    uint rows;
    uint offset; // words of 32 bits, as all that follow
    uint stride;
    uint normal_offset;
    uint instance; // from instance to instance
    uint normals; // NO_NORMALS, FLOAT_NORMALS or BYTE_NORMALS
} constants;

const uint NO_NORMALS = 0u;
const uint FLOAT_NORMALS = 1u;

void store(uint at, vec3 x) {
    host_vertices[at] = floatBitsToUint(x.x);
    host_vertices[at + 1u] = floatBitsToUint(x.y);
    host_vertices[at + 2u] = floatBitsToUint(x.z);
}

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.rows) {
        return;
    }
    uint at = constants.offset + part(constants.instance) + row * constants.stride, from = part(constants.rows) + row;
    vec3 n = fetch(skin_normals, from).xyz;
    store(at, fetch(skin_positions, from).xyz);
    if (constants.normals == FLOAT_NORMALS) {
        store(at + constants.normal_offset, n);
    } else if (constants.normals != NO_NORMALS) {
        host_vertices[at + constants.normal_offset] = packSnorm4x8(vec4(n, 0.0));
    }
}
