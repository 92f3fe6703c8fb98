// Sets of seeds, entered in any order and listed in the order of the seeds: for every 1024 seeds 32 words of bits, and the
// number of those that are set.
//
// No barrier and no shared memory: lavapipe runs workgroups with barriers as coroutines, at several times the cost.
#ifndef DERMIS_SET
#define DERMIS_SET
#include "shared/instance.glsl"

const uint SET_BLOCK = 33u; // words of 1024 seeds
const uint NO_SEED = 0xffffffffu;

// Blocks of 1024 seeds that a mesh may have.
uint set_blocks(uint vertices) {
    return (vertices + 1023u) >> 10;
}

// Where this instance's set begins.
uint set_part(uint vertices) {
    return part(SET_BLOCK * set_blocks(vertices));
}

uint set_word(uint seed) {
    return SET_BLOCK * (seed >> 10) + ((seed >> 5) & 31u);
}

// Enters a seed into this instance's set in a storage buffer of words, once however often it is entered. The including shader's
// constants have the number of vertices.
#define ENTER(words, seed) \
    if ((atomicOr(words[set_part(constants.vertices) + set_word(seed)], 1u << ((seed) & 31u)) & (1u << ((seed) & 31u))) == 0u) \
        atomicAdd(words[set_part(constants.vertices) + SET_BLOCK * ((seed) >> 10) + 32u], 1u)

#endif
