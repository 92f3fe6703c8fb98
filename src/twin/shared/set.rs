//! Twin of `shaders/shared/set.glsl`: sets of seeds, 32 words of bits and their number for every 1024.

use crate::layout::{SET_BLOCK, SET_SEEDS};

/// Enters a seed, once however often it is entered.
pub fn enter(words: &mut [u32], seed: u32) {
    let block = seed as usize / SET_SEEDS * SET_BLOCK;
    let bit = 1 << (seed & 31);
    let word = &mut words[block + (seed as usize >> 5) % 32];
    if *word & bit == 0 {
        *word |= bit;
        words[block + SET_BLOCK - 1] += 1;
    }
}

/// The seeds in a set, ascending.
pub fn members(words: &[u32]) -> impl Iterator<Item = u32> {
    let bits = words.chunks_exact(SET_BLOCK).flat_map(|block| &block[..32]);
    bits.enumerate().flat_map(|(word, bits)| {
        let bits = *bits;
        (0..32)
            .filter(move |bit| bits >> bit & 1 != 0)
            .map(move |bit| word as u32 * 32 + bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_lists_what_was_entered_in_order_and_once() {
        let mut words = vec![0; 2 * SET_BLOCK];
        let seeds = [1500, 31, 32, 0, 1023, 1024, 31];
        seeds.into_iter().for_each(|seed| enter(&mut words, seed));
        let listed: Vec<u32> = members(&words).collect();
        assert_eq!(listed, [0, 31, 32, 1023, 1024, 1500]);
        assert_eq!([words[32], words[65]], [4, 2]);
    }
}
