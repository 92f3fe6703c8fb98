#version 450
// One lamp from above, in front and to the left, and a sky that is brighter than the ground.

layout(location = 0) in vec3 shading_normal;

layout(location = 0) out vec4 colour;

void main() {
    vec3 normal = normalize(shading_normal);
    float lamp = max(dot(normal, normalize(vec3(-0.5, 0.8, 0.9))), 0.0);
    float sky = 0.5 + 0.5 * normal.y;
    colour = vec4(vec3(0.80, 0.58, 0.47) * (0.08 + 0.14 * sky + 0.75 * lamp), 1.0);
}
