// Constants of the pass that draws skin; 128 bytes, the least that every device grants.
layout(push_constant) uniform Constants {
    mat4 clip_from_model;
    vec4 eye;   // xyz: where the viewer stands (w = 1) or the direction towards it (w = 0)
    vec4 right; // xyz: the picture's right in model space; w: width of edges in pixels, 0 for none
    vec4 up;    // xyz: the picture's up in model space
    vec4 edge;  // rgb: linear colour of edges; a: their opacity
} constants;
