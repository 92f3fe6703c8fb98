// Numbers of the motions of a vertex. The including shader declares influence_joints, influence_weights and palette before,
// and constants with the number of joints.
#ifndef DERMIS_MOTION
#define DERMIS_MOTION

// The motions that all joints of a vertex have, since the pose before and since rest; NO_MOTION where they differ.
uvec2 motions_of(uint v, uint width) {
    uvec2 first = uvec2(0u);
    bvec2 as_one = bvec2(true);
    uint k = 0u;
    do {
        uint at = v * width + k;
        uint joint = (word(influence_joints, at >> 1) >> ((at & 1u) * 16u)) & 0xffffu;
        uint both = uint(fetch(palette, part(JOINT_TEXELS * constants.joints) + joint * JOINT_TEXELS + STRETCH).w);
        uvec2 motions = uvec2(both % MOTIONS, both / MOTIONS);
        bool counts = number(influence_weights, at) != 0.0;
        first = k == 0u ? motions : first;
        as_one.x = as_one.x && (motions.x == first.x || !counts);
        as_one.y = as_one.y && (motions.y == first.y || !counts);
        k++;
    } while (k < width);
    return uvec2(as_one.x ? first.x : NO_MOTION, as_one.y ? first.y : NO_MOTION);
}

#endif
