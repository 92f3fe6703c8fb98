//! Lists of a few items each, all in one allocation: they are replaced and cut short far too often for one of their own.

/// Rows of items. A row that outgrows its room moves to the end, with room to grow on.
#[derive(Debug)]
pub(super) struct Rows<T> {
    items: Vec<T>,
    spans: Vec<Span>,
}

/// Where a row is.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    start: usize,
    len: u32,
    room: u32,
}

impl Span {
    fn range(self) -> std::ops::Range<usize> {
        self.start..self.start + self.len as usize
    }
}

impl<T: Copy> Rows<T> {
    /// No rows, with space for so many and their items.
    pub(super) fn with_capacity(rows: usize, items: usize) -> Self {
        Self {
            items: Vec::with_capacity(items),
            spans: Vec::with_capacity(rows),
        }
    }

    /// Appends a row, which has no room to grow.
    pub(super) fn push(&mut self, row: impl IntoIterator<Item = T>) {
        let start = self.items.len();
        self.items.extend(row);
        let len = (self.items.len() - start) as u32;
        let room = len;
        self.spans.push(Span { start, len, room });
    }

    pub(super) fn row(&self, at: usize) -> &[T] {
        &self.items[self.spans[at].range()]
    }

    pub(super) fn row_mut(&mut self, at: usize) -> &mut [T] {
        &mut self.items[self.spans[at].range()]
    }

    /// Number of a row's items.
    pub(super) fn len(&self, at: usize) -> usize {
        self.spans[at].len as usize
    }

    /// Takes the last item of a row.
    pub(super) fn pop(&mut self, at: usize) -> Option<T> {
        let last = self.row(at).last().copied();
        self.spans[at].len -= u32::from(last.is_some());
        last
    }

    /// Removes the item at a place of a row; those behind it move up.
    pub(super) fn remove(&mut self, at: usize, place: usize) {
        self.row_mut(at)[place..].rotate_left(1);
        self.spans[at].len -= 1;
    }

    /// Empties a row for good.
    pub(super) fn clear(&mut self, at: usize) {
        self.spans[at] = Span::default();
    }

    /// Gives a row other items.
    pub(super) fn replace(&mut self, at: usize, row: &[T]) {
        let span = &mut self.spans[at];
        let len = row.len() as u32;
        if len > span.room {
            let room = len.next_power_of_two();
            let start = self.items.len();
            *span = Span { start, len, room };
            self.items.extend_from_slice(row);
            self.items.resize(start + room as usize, row[0]);
        } else {
            span.len = len;
            self.row_mut(at).copy_from_slice(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_what_vectors_would_be() {
        let mut rows = Rows::with_capacity(0, 0);
        let mut vectors: Vec<Vec<u32>> = Vec::new();
        for i in 0..20u32 {
            rows.push(0..i % 5);
            vectors.push((0..i % 5).collect());
        }
        let mut seed = 7u32;
        let mut chance = |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 16) % below
        };
        for _ in 0..2000 {
            let at = chance(20) as usize;
            match chance(4) {
                0 => assert_eq!(rows.pop(at), vectors[at].pop()),
                1 if !vectors[at].is_empty() => {
                    let place = chance(vectors[at].len() as u32) as usize;
                    rows.remove(at, place);
                    vectors[at].remove(place);
                }
                2 if chance(9) == 0 => {
                    rows.clear(at);
                    vectors[at].clear();
                }
                _ => {
                    let row: Vec<u32> = (0..chance(12)).map(|_| chance(99)).collect();
                    rows.replace(at, &row);
                    vectors[at] = row;
                }
            }
            for (at, vector) in vectors.iter().enumerate() {
                assert_eq!(rows.row(at), vector);
                assert_eq!(rows.len(at), vector.len());
            }
        }
    }
}
