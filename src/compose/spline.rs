//! Curves in a plane as polylines: a cubic B-spline evaluated, points at equal distances.

/// Segments for each span of a B-spline.
const SEGMENTS: usize = 32;

/// The uniform cubic B-spline of control points, from the first to the last: both count three times.
pub(super) fn cubic(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let padded: Vec<[f64; 2]> = [first, first]
        .into_iter()
        .chain(points.iter().copied())
        .chain([last, last])
        .collect();
    let mut curve = Vec::with_capacity((padded.len() - 3) * SEGMENTS + 1);
    for span in padded.windows(4) {
        for k in 0..SEGMENTS {
            let t = k as f64 / SEGMENTS as f64;
            let s = 1.0 - t;
            let weights = [
                s * s * s / 6.0,
                (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
                t * t * t / 6.0,
            ];
            curve.push([0, 1].map(|c| (0..4).map(|i| weights[i] * span[i][c]).sum()));
        }
    }
    curve.push(last);
    curve
}

/// Distance between two points.
fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Length of a polyline.
pub(super) fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|w| distance(w[0], w[1])).sum()
}

/// The inner `count - 1` of the points that part a polyline into `count` pieces of equal length.
pub(super) fn parted(line: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let step = length(line) / count as f64;
    let mut points = Vec::with_capacity(count);
    let mut passed = 0.0;
    for w in line.windows(2) {
        let piece = distance(w[0], w[1]);
        // The slack keeps the line's last point out, whatever the sums' rounding.
        while points.len() + 1 < count && (points.len() + 1) as f64 * step <= passed + piece + 1e-12
        {
            let share = ((points.len() + 1) as f64 * step - passed) / piece.max(1e-300);
            points.push([0, 1].map(|c| w[0][c] + share.min(1.0) * (w[1][c] - w[0][c])));
        }
        passed += piece;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_keeps_its_ends_a_line_and_a_tripled_corner() {
        let line = [[0.0, 0.5], [0.1, 0.5], [0.3, 0.5], [0.5, 0.5]];
        let curve = cubic(&line);
        assert!(distance(curve[0], line[0]) < 1e-15 && curve[curve.len() - 1] == line[3]);
        assert!(curve.iter().all(|p| (p[1] - 0.5).abs() < 1e-12));
        assert!(curve.windows(2).all(|w| w[1][0] > w[0][0]));
        let corner = [[0.0, 0.5], [0.5, 0.5], [0.5, 0.5], [0.5, 0.5], [0.5, 0.0]];
        assert!(
            cubic(&corner)
                .iter()
                .any(|p| distance(*p, [0.5, 0.5]) < 1e-12)
        );
        let rounded = [[0.0, 0.5], [0.5, 0.5], [0.5, 0.0]];
        assert!(
            cubic(&rounded)
                .iter()
                .all(|p| distance(*p, [0.5, 0.5]) > 0.05)
        );
    }

    #[test]
    fn parts_of_a_polyline_are_equal_and_turn_its_corner() {
        let line = [[0.0, 0.5], [0.5, 0.5], [0.5, 0.0]];
        let points = parted(&line, 5);
        let expected = [[0.2, 0.5], [0.4, 0.5], [0.5, 0.4], [0.5, 0.2]];
        assert_eq!(points.len(), 4);
        for (p, e) in points.iter().zip(expected) {
            assert!(distance(*p, e) < 1e-12, "{p:?} {e:?}");
        }
        assert_eq!(length(&line), 1.0);
    }
}
