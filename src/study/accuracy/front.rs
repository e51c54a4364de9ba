//! Which modes are worth having: no other is both quicker and nearer to what is right.

/// For each point (time, error) whether it is on the front: no other point is less in one and at most as much in the other.
/// Of equal points the first one counts.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let beaten = |i: usize, (time, error): (f64, f64)| {
        points.iter().enumerate().any(|(j, &(t, e))| {
            let less = t < time || e < error || j < i;
            t <= time && e <= error && less && j != i
        })
    };
    points.iter().enumerate().map(|(i, &point)| !beaten(i, point)).collect()
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (2.0, 3.0), (2.0, 4.0), (3.0, 3.0), (4.0, 1.0), (0.5, 9.0), (1.0, 5.0)];
        assert_eq!(front(&points), [true, true, false, false, true, true, false]);
        assert_eq!(front(&[]), [true; 0]);
    }
}
