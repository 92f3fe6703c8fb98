#version 460
// One triangle that covers the picture, behind everything.

layout(location = 0) out float height;

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4 - 1;
    height = 0.5 - 0.5 * corner.y;
    gl_Position = vec4(corner, 1, 1);
}
