//! Where the grids of all fields lie in the one atlas image.

use super::GRID;
use crate::{Error, Result};

/// Bytes of one tile: 32³ texels of four half floats.
pub const TILE_BYTES: u64 = (GRID as u64).pow(3) * 8;

/// Tiles of [`GRID`]³ texels, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasLayout {
    /// Tiles along each axis; their product is at least the number of fields.
    pub tiles: [u32; 3],
}

impl AtlasLayout {
    /// Tile of field `i`.
    pub fn tile(&self, i: u32) -> [u32; 3] {
        let [x, y, _] = self.tiles;
        [i % x, i / x % y, i / (x * y)]
    }

    /// Extent of the image in texels.
    pub fn extent(&self) -> [u32; 3] {
        self.tiles.map(|n| n * GRID)
    }
}

/// The layout of `count` fields with fewest tiles, then with the most along y, in an image of at most `max_dim` texels an edge.
///
/// # Errors
/// [`Error::Argument`] where that many fields do not fit.
pub fn atlas_layout(count: usize, max_dim: u32) -> Result<AtlasLayout> {
    let count = count.max(1) as u64;
    let most = (max_dim / GRID).min(1024);
    let mut best: Option<(u64, AtlasLayout)> = None;
    for x in 1..=most {
        for z in 1..=most {
            let y = count.div_ceil(x as u64 * z as u64);
            if y > most as u64 {
                continue;
            }
            let total = x as u64 * y * z as u64;
            if best.is_none_or(|(least, _)| total < least) {
                let tiles = [x, y as u32, z];
                best = Some((total, AtlasLayout { tiles }));
            }
        }
    }
    best.map(|(_, layout)| layout).ok_or_else(|| {
        Error::argument(
            "fields",
            format!("{count} do not fit into a 3D image of {max_dim} texels an edge"),
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_field_has_a_tile_of_its_own_within_the_limit() {
        for max_dim in [256, 2048] {
            for count in [1, 2, 7, 16, 19, 53, 61, 67, 200, 511, 512] {
                let layout = atlas_layout(count, max_dim).unwrap();
                assert!(layout.extent().iter().all(|&e| e <= max_dim), "{layout:?}");
                let mut tiles: Vec<_> = (0..count as u32).map(|i| layout.tile(i)).collect();
                tiles.sort_unstable();
                tiles.dedup();
                assert_eq!(tiles.len(), count);
                assert!(tiles.iter().all(|t| (0..3).all(|a| t[a] < layout.tiles[a])));
            }
        }
        assert_eq!(atlas_layout(19, 2048).unwrap().tiles, [1, 19, 1]);
    }

    #[test]
    fn memory_stays_within_a_third_of_a_megabyte_a_field() {
        for count in 4..=64 {
            let tiles: u32 = atlas_layout(count, 2048).unwrap().tiles.iter().product();
            assert!(
                tiles as u64 * TILE_BYTES <= 270_000 * count as u64,
                "{count}"
            );
        }
    }

    #[test]
    fn too_many_fields_are_refused() {
        assert!(atlas_layout(513, 256).is_err());
    }
}
