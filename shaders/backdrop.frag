#version 460
// A vertical gradient between two sRGB colours.

layout(push_constant) uniform Constants {
    vec4 top;
    vec4 bottom;
} constants;

layout(location = 0) in float height;
layout(location = 0) out vec4 pixel;

void main() {
    pixel = mix(constants.bottom, constants.top, height);
}
