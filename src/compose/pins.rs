//! Pins: the points of a profile where a slice of an operator is held at 0.5 (2014, Eq. 2).
//!
//! The paper holds the grid vertices that lie closest to the profile. We hold the bilinear interpolant *at points of the profile*, so
//! that the sampler's own 0.5 iso-curve goes through them: half a cell of error becomes a hundredth of one.

use super::{
    profile::Outline,
    spline::{length, parted},
};

/// A point that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pin {
    /// (f1, f2).
    pub(super) at: [f64; 2],
    /// In (0, 1]: 1 holds firmly, less lets go by degrees, so that pins come and go without a jump from slice to slice.
    pub(super) share: f64,
}

/// The pins of all outlines on a grid of `cells` by `cells`.
///
/// Each surface gets the same number, at equal distances, so that they move smoothly from slice to slice; no closer than a cell,
/// since more would overdetermine the bilinear interpolant; an odd number, so that one stands where the two halves meet.
pub(super) fn pins(outlines: &[Outline], cells: usize) -> Vec<Vec<Pin>> {
    let lengths = outlines.iter().map(|o| length(&o.surface));
    let shortest = lengths.fold(f64::MAX, f64::min);
    let pieces = (shortest * cells as f64 + 1e-9) as usize / 2 * 2;
    let all = outlines.iter().map(|outline| {
        let surface = parted(&outline.surface, pieces);
        let firm = surface.into_iter().map(|at| Pin { at, share: 1.0 });
        firm.chain(contact(&outline.contact, cells))
            .filter(|pin| is_inside(pin.at, cells))
            .collect()
    });
    all.collect()
}

/// Whether a point is clear of the sides, whose values Eq. 1 gives: half a cell from the axes, two cells from where g = 1.
fn is_inside(at: [f64; 2], cells: usize) -> bool {
    let place = at.map(|f| f * cells as f64);
    place
        .iter()
        .all(|&x| x >= 0.5 && x <= cells as f64 - 2.0 + 1e-9)
}

/// Cells before a pin in which a contact line's tip makes it grow.
const GROWTH: usize = 2;

/// Pins of a contact line where it crosses f1 + f2 = 2i / cells: on the diagonal these are the grid's vertices.
///
/// With T = i / cells, the pin at T grows while the line's tip travels from T - 2/cells (or the line's start) to T; until then it
/// lies ahead of the tip, along the diagonal. Two pins grow at a time, and what one gains less at the ends of its way the other
/// gains more: so the line grows evenly, and the slices are C¹ in the depth.
fn contact(line: &[[f64; 2]], cells: usize) -> Vec<Pin> {
    let ([start, ..], [.., tip]) = (line, line) else {
        return Vec::new();
    };
    let [first, last] = [start, tip].map(|p| 0.5 * (p[0] + p[1]));
    let at = |i: usize| i as f64 / cells as f64;
    let begin = |i: usize| at(i.saturating_sub(GROWTH)).max(first);
    let indices = (1..=cells).filter(|&i| at(i) > first + 1e-9 && begin(i) < last - 1e-9);
    let pin = |i: usize| Pin {
        at: crossing(line, at(i)).unwrap_or_else(|| tip.map(|f| f + at(i) - last)),
        share: growth((last - begin(i)) / (at(i) - begin(i))),
    };
    indices.map(pin).filter(|pin| pin.share > 1e-6).collect()
}

/// From 0 to 1 with a rate that rises to its middle and falls again, both evenly.
fn growth(way: f64) -> f64 {
    let left = 1.0 - way.clamp(0.0, 1.0);
    if left > 0.5 {
        2.0 * (1.0 - left) * (1.0 - left)
    } else {
        1.0 - 2.0 * left * left
    }
}

/// Where a line, f1 + f2 not descending, has f1 + f2 = 2 `mean`.
fn crossing(line: &[[f64; 2]], mean: f64) -> Option<[f64; 2]> {
    let sum = |p: [f64; 2]| 0.5 * (p[0] + p[1]);
    let segment = line
        .windows(2)
        .find(|w| sum(w[0]) < mean && mean <= sum(w[1]))?;
    let (a, b) = (segment[0], segment[1]);
    let share = (mean - sum(a)) / (sum(b) - sum(a));
    Some([0, 1].map(|c| a[c] + share * (b[c] - a[c])))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{super::Profile, *};

    fn of(profile: &Profile, depth: f64, cells: usize) -> Vec<Pin> {
        pins(&[profile.outline(depth)], cells).remove(0)
    }

    #[test]
    fn contact_pins_lie_on_the_surface_and_on_vertices_of_the_diagonal() {
        let pins = of(&Profile::contact(), 0.4, 127);
        let (line, surface): (Vec<&Pin>, Vec<&Pin>) = pins.iter().partition(|p| p.at[0] == p.at[1]);
        // 126 pieces of the surface; the pin at (0.5, 0.5) is on the diagonal too.
        assert_eq!(surface.len(), 124);
        for pin in surface {
            assert!((pin.at[0].max(pin.at[1]) - 0.5).abs() < 1e-12);
        }
        // 0.5 + 0.4 / √2 = 99.42 / 127: vertices 64 to 99, and of those ahead 100 at .71 of its way, 101 at .21.
        assert_eq!((line.len(), line[0].at), (39, [0.5, 0.5]));
        let off = |f: f64| (f * 127.0 - (f * 127.0).round()).abs();
        assert!(line[1..].iter().all(|p| off(p.at[0]) < 1e-9));
        assert!(line[..37].iter().all(|p| p.share == 1.0));
        assert!((line[37].share - 0.832).abs() < 1e-3, "{:?}", line[37]);
        assert!((line[38].share - 0.088).abs() < 1e-3, "{:?}", line[38]);
    }

    #[test]
    fn a_line_without_length_has_no_pin_and_a_full_one_ends_two_cells_before_the_corner() {
        let contact = Profile::contact();
        assert_eq!(of(&contact, 0.0, 127).len(), 125);
        let greatest = of(&contact, 1.0, 127)
            .iter()
            .map(|p| p.at[0])
            .fold(0.0, f64::max);
        assert!((greatest - 125.0 / 127.0).abs() < 1e-12);
    }

    #[test]
    fn pins_of_the_bulge_lie_on_its_curve_a_cell_apart() {
        let bulge = Profile::bulge(1.0).unwrap();
        let curve = bulge.outline(1.0).surface;
        let outlines = [bulge.outline(0.0), bulge.outline(1.0)];
        let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) * 127.0;
        let all = pins(&outlines, 127);
        let deep = &all[1][..all[0].len()];
        // Vertices of the curve are less than a tenth of a cell apart at its end, a third in the middle.
        for pin in deep {
            let nearest = curve.iter().map(|&p| distance(p, pin.at));
            assert!(nearest.fold(f64::MAX, f64::min) < 0.3, "{pin:?}");
        }
        let gaps = deep.windows(2).map(|w| distance(w[0].at, w[1].at));
        let (least, most) = gaps.fold((f64::MAX, 0.0), |(l, m): (f64, f64), g| {
            (l.min(g), m.max(g))
        });
        assert!(least > 0.9 && most < 1.1, "{least} {most}");
    }
}
