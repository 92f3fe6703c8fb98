#version 460
#extension GL_GOOGLE_include_directive : require
// Skin, lit on both sides; the back has a colour of its own, so that inverted skin is seen at a glance.

#include "shared/light.glsl"
#include "shared/skin.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
layout(location = 3) in vec3 barycentric;

layout(location = 0) out vec4 pixel;

const vec3 BACK = vec3(0.85, 0.03, 0.60);

// How the surface bends along the picture, in normals turned per pixel: above 0 convex, below 0 concave.
float bend(vec3 n) {
    vec3 x = dFdx(position), y = dFdy(position);
    float curvature = dot(dFdx(n), x) / dot(x, x) + dot(dFdy(n), y) / dot(y, y);
    return curvature * length(fwidth(position));
}

// Coverage of the nearest edge: barycentric distance over its screen-space slope is the distance in pixels.
float edge_cover(float width) {
    vec3 pixels = barycentric / max(fwidth(barycentric), vec3(1e-8));
    float nearest = min(pixels.x, min(pixels.y, pixels.z));
    return 1 - smoothstep(0.5 * width - 0.5, 0.5 * width + 0.5, nearest);
}

void main() {
    vec3 view = normalize(constants.eye.xyz - constants.eye.w * position);
    vec3 flat_normal = cross(dFdx(position), dFdy(position));
    vec3 n_model = dot(normal, normal) > 1e-12 ? normalize(normal) : normalize(flat_normal);
    n_model = gl_FrontFacing ? n_model : -n_model;
    mat3 axes = mat3(constants.right.xyz, constants.up.xyz, cross(constants.right.xyz, constants.up.xyz));
    vec3 albedo = gl_FrontFacing ? colour : BACK;
    // Less light gets into creases and a little more onto ridges; the former are what one looks for in skin.
    float ridge = clamp(6 * bend(n_model), -1, 1);
    albedo *= 1 + (ridge < 0 ? 0.35 : 0.07) * ridge;
    vec3 shaded = lit(albedo, n_model * axes, view * axes, n_model);
    if (constants.right.w > 0) {
        shaded = mix(shaded, constants.edge.rgb, constants.edge.a * edge_cover(constants.right.w));
    }
    pixel = vec4(to_srgb(shaded), 1);
}
