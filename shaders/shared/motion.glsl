// Number of the motion of a vertex. The including shader declares influence_joints, influence_weights and palette before.
#ifndef DERMIS_MOTION
#define DERMIS_MOTION

// The motion that all joints of a vertex have; NO_MOTION where they differ.
uint motion_of(uint v, uint width) {
    uint first = 0u, k = 0u;
    bool as_one = true;
    do {
        uint at = v * width + k;
        uint joint = (word(influence_joints, at >> 1) >> ((at & 1u) * 16u)) & 0xffffu;
        uint motion = uint(fetch(palette, joint * JOINT_TEXELS + STRETCH).w);
        first = k == 0u ? motion : first;
        as_one = as_one && (motion == first || number(influence_weights, at) == 0.0);
        k++;
    } while (k < width);
    return as_one ? first : NO_MOTION;
}

#endif
