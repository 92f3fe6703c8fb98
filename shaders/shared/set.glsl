// Sets of seeds, entered in any order and listed in the order of the seeds: for every 1024 seeds 32 words of bits, and the
// number of those that are set.
//
// No barrier and no shared memory: lavapipe runs workgroups with barriers as coroutines, at several times the cost.
#ifndef DERMIS_SET
#define DERMIS_SET

const uint SET_BLOCK = 33u; // words of 1024 seeds
const uint NO_SEED = 0xffffffffu;

uint set_word(uint seed) {
    return SET_BLOCK * (seed >> 10) + ((seed >> 5) & 31u);
}

// Enters a seed into a storage buffer of words, once however often it is entered.
#define ENTER(words, seed) \
    if ((atomicOr(words[set_word(seed)], 1u << ((seed) & 31u)) & (1u << ((seed) & 31u))) == 0u) \
        atomicAdd(words[SET_BLOCK * ((seed) >> 10) + 32u], 1u)

#endif
