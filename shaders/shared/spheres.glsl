// Constants of the pass that draws spheres and what is interpolated between them; 128 bytes.
layout(push_constant) uniform Constants {
    mat4 clip_from_model;
    vec4 eye;   // xyz: where the viewer stands; w: 1 where rays meet there, 0 where they are parallel
    vec4 right; // xyz: the picture's right in model space; w: half its width, at distance 1 where rays meet
    vec4 up;    // xyz: the picture's up in model space; w: half its height, likewise
    vec4 pixel; // xy: size of a pixel in clip space
} constants;
