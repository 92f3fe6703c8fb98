//! Heads of the work lists of all instances (`shaders/shared/instance.glsl`): workgroups for an indirect dispatch, and the
//! number of items of every instance.

/// Words of the workgroups.
const GROUPS: usize = 3;

/// Heads, a row a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Heads {
    words: Vec<u32>,
    instances: usize,
}

impl Heads {
    /// Heads of empty lists.
    pub(super) fn empty(rows: usize, instances: usize) -> Self {
        let mut head = vec![0; words(1, instances)];
        head[1..GROUPS].copy_from_slice(&[instances as u32, 1]);
        Self {
            words: head.repeat(rows),
            instances,
        }
    }

    /// Heads as they lie in a buffer.
    pub(super) fn of_words(words: Vec<u32>, instances: usize) -> Self {
        Self { words, instances }
    }

    /// One of the heads of every one of several instances.
    pub(super) fn join(parts: &[Self]) -> Self {
        let rows = parts.first().map_or(0, |p| p.words.len() / words(1, 1));
        let mut all = Self::empty(rows, parts.len());
        for row in 0..rows {
            let (groups, counts) = all.row_mut(row).split_at_mut(GROUPS);
            for (part, count) in parts.iter().zip(counts) {
                groups[0] = groups[0].max(part.groups(row));
                *count = part.counts(row)[0];
            }
        }
        all
    }

    /// Lets the list of every instance have `count` items, 64 a workgroup.
    pub(super) fn set(&mut self, row: usize, count: usize) {
        self.row_mut(row)[0] = (count as u32).div_ceil(64);
        self.set_counts(row, count as u32);
    }

    /// Sets the numbers of items alone.
    pub(super) fn set_counts(&mut self, row: usize, count: u32) {
        self.row_mut(row)[GROUPS..].fill(count);
    }

    /// Workgroups along x, the most that any instance needs.
    pub(super) fn groups(&self, row: usize) -> u32 {
        self.row(row)[0]
    }

    /// Items of every instance.
    pub(super) fn counts(&self, row: usize) -> &[u32] {
        &self.row(row)[GROUPS..]
    }

    /// Items of all instances.
    pub(super) fn count(&self, row: usize) -> u64 {
        self.counts(row).iter().map(|c| u64::from(*c)).sum()
    }

    /// The words of all rows.
    pub(super) fn words(&self) -> &[u32] {
        &self.words
    }

    fn row(&self, row: usize) -> &[u32] {
        let words = words(1, self.instances);
        &self.words[row * words..(row + 1) * words]
    }

    fn row_mut(&mut self, row: usize) -> &mut [u32] {
        let words = words(1, self.instances);
        &mut self.words[row * words..(row + 1) * words]
    }
}

/// Words of heads.
pub(super) fn words(rows: usize, instances: usize) -> usize {
    rows * (GROUPS + instances)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_have_the_most_workgroups_and_the_items_of_every_instance() {
        let head = |count| {
            let mut heads = Heads::empty(2, 1);
            heads.set(1, count);
            heads
        };
        assert_eq!(head(65).words(), [0, 1, 1, 0, 2, 1, 1, 65]);
        let all = Heads::join(&[head(3), head(65), head(0)]);
        assert_eq!(all.words(), [0, 3, 1, 0, 0, 0, 2, 3, 1, 3, 65, 0]);
        assert_eq!((all.groups(1), all.count(1)), (2, 68));
        assert_eq!(Heads::of_words(all.words().to_vec(), 3), all);
    }
}
