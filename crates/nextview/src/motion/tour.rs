use super::KeepOut;
use super::long_tour::long_tour;
use crate::geometry::check_position;
use crate::{Cancel, Cancelled, Error};
use glam::DVec3;

/// Maximum number of views for an exact shortest order; a heuristic orders more.
const MOST_EXACT: usize = 12;

/// Maximum number of views ordered by cheapest insertion and all moves, which takes up to a second or two; a
/// search among neighbours orders more.
const MOST_INSERTED: usize = 1000;

/// Maximum number of sweeps over all moves; a test needs far fewer.
const MOST_SWEEPS: usize = 100;

/// Relative differences below this may be rounding errors.
const TOLERANCE: f64 = 1e-12;

/// Returns the order of a short path through all positions, from the start and without returning. Each leg
/// goes around the ball. Without a start, the path begins at the first position of the order.
///
/// Up to 12 positions, the path is the shortest possible (Held and Karp 1962). More positions are inserted
/// one by one where they cost least. They are then moved as long as that shortens the path, in up to 100
/// sweeps: by reversing a part of it (2-opt, Croes 1958), or by moving up to three positions elsewhere
/// (Or-opt, Or 1976). For more than 1000 positions, the order begins along a space-filling curve, and only
/// moves that lead to neighbours are tried, so the time grows little faster than their number. The path is
/// never longer than in the order given.
///
/// Fails if a position or the start is not within [`Pose::REACH`](crate::geometry::Pose::REACH).
pub fn tour(start: Option<DVec3>, positions: &[DVec3], ball: &KeepOut) -> Result<Vec<usize>, Error> {
    start.iter().chain(positions).try_for_each(|position| check_position("position", *position))?;
    Ok(tour_unless(start, positions, ball, &Cancel::default())?)
}

/// [`tour`] through positions within reach, unless cancelled.
pub(crate) fn tour_unless(
    start: Option<DVec3>,
    positions: &[DVec3],
    ball: &KeepOut,
    cancel: &Cancel,
) -> Result<Vec<usize>, Cancelled> {
    if positions.len() > MOST_INSERTED {
        return long_tour(start, positions, ball, cancel);
    }
    let ways = Ways::new(start, positions, ball);
    if positions.len() <= MOST_EXACT { Ok(shortest(&ways)) } else { short(&ways, cancel) }
}

/// Length of the path through the positions in the given order, metres.
pub fn tour_length(start: Option<DVec3>, positions: impl IntoIterator<Item = DVec3>, ball: &KeepOut) -> f64 {
    let (mut length, mut last) = (0.0, start);
    for position in positions {
        length += last.map_or(0.0, |last| ball.path_length(last, position));
        last = Some(position);
    }
    length
}

/// Returns the place in the path through `route` where another position costs least, the first on ties, and
/// the added length (metres).
pub fn detour(start: Option<DVec3>, route: &[DVec3], position: DVec3, ball: &KeepOut) -> (usize, f64) {
    let way = |from: Option<DVec3>, to: DVec3| from.map_or(0.0, |from| ball.path_length(from, to));
    let costs = (0..=route.len()).map(|place| {
        let (before, after) = (place.checked_sub(1).map(|place| route[place]).or(start), route.get(place));
        let through = way(before, position) + after.map_or(0.0, |&after| way(Some(position), after));
        (place, through - after.map_or(0.0, |&after| way(before, after)))
    });
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
}

/// Lengths of the paths between all positions.
struct Ways {
    n: usize,
    /// From the start to each; zeros without a start.
    from_start: Vec<f64>,
    /// Row by row.
    between: Vec<f64>,
}

impl Ways {
    fn new(start: Option<DVec3>, positions: &[DVec3], ball: &KeepOut) -> Self {
        let way = |from: DVec3| positions.iter().map(move |&to| ball.path_length(from, to));
        Self {
            n: positions.len(),
            from_start: start.map_or(vec![0.0; positions.len()], |start| way(start).collect()),
            between: positions.iter().flat_map(|&from| way(from)).collect(),
        }
    }

    fn between(&self, a: usize, b: usize) -> f64 {
        self.between[a * self.n + b]
    }

    /// Length of the leg between two positions: from the start if `from` is `None`, 0 if `to` is `None`.
    fn leg(&self, from: Option<usize>, to: Option<usize>) -> f64 {
        match (from, to) {
            (_, None) => 0.0,
            (None, Some(to)) => self.from_start[to],
            (Some(from), Some(to)) => self.between(from, to),
        }
    }

    fn length(&self, order: &[usize]) -> f64 {
        let first = self.leg(None, order.first().copied());
        order.windows(2).fold(first, |sum, leg| sum + self.between(leg[0], leg[1]))
    }
}

/// Dynamic programming over the sets of visited positions.
fn shortest(ways: &Ways) -> Vec<usize> {
    let n = ways.n;
    if n == 0 {
        return Vec::new();
    }
    // By set and last position: the shortest path, and the position before the last.
    let mut table = vec![(f64::INFINITY, 0); n << n];
    (0..n).for_each(|first| table[(1 << first) * n + first].0 = ways.from_start[first]);
    for set in 1..1_usize << n {
        for last in (0..n).filter(|last| set >> last & 1 == 1) {
            let length = table[set * n + last].0;
            for next in (0..n).filter(|next| set >> next & 1 == 0) {
                let longer = &mut table[(set | 1 << next) * n + next];
                let way = length + ways.between(last, next);
                if way < longer.0 {
                    *longer = (way, last);
                }
            }
        }
    }
    let mut set = (1 << n) - 1;
    let end = |a: &usize, b: &usize| table[set * n + a].0.total_cmp(&table[set * n + b].0);
    let mut last = (0..n).min_by(end).unwrap_or_default();
    let mut order = vec![last];
    while order.len() < n {
        let before = table[set * n + last].1;
        set ^= 1 << last;
        last = before;
        order.push(last);
    }
    order.reverse();
    order
}

/// The better of two local optima: one from cheapest insertion, one from the order given.
fn short(ways: &Ways, cancel: &Cancel) -> Result<Vec<usize>, Cancelled> {
    let inserted = improved(ways, inserted(ways, cancel)?, cancel)?;
    let given = improved(ways, (0..ways.n).collect(), cancel)?;
    Ok(if ways.length(&given) < ways.length(&inserted) { given } else { inserted })
}

/// Inserts the positions one by one, each time the one that lengthens the path least.
fn inserted(ways: &Ways, cancel: &Cancel) -> Result<Vec<usize>, Cancelled> {
    let mut order = Vec::new();
    let mut left: Vec<usize> = (0..ways.n).collect();
    while !left.is_empty() {
        cancel.check()?;
        let cheapest = |&position: &usize| {
            let costs = (0..=order.len()).map(|place| (place, insertion(ways, &order, place, position)));
            costs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
        };
        let costs: Vec<(usize, f64)> = left.iter().map(cheapest).collect();
        let next = (0..left.len()).min_by(|&a, &b| costs[a].1.total_cmp(&costs[b].1)).unwrap_or_default();
        order.insert(costs[next].0, left.remove(next));
    }
    Ok(order)
}

/// The added length of a visit to a position between those at `place - 1` and `place`.
fn insertion(ways: &Ways, order: &[usize], place: usize, position: usize) -> f64 {
    let (before, after) = around(order, place, place);
    ways.leg(before, Some(position)) + ways.leg(Some(position), after) - ways.leg(before, after)
}

/// The positions before and after a part of the order.
fn around(order: &[usize], begin: usize, end: usize) -> (Option<usize>, Option<usize>) {
    (begin.checked_sub(1).map(|place| order[place]), order.get(end).copied())
}

/// Improves the order by sweeps over all moves that shorten the path, until none does or the maximum number
/// of sweeps is reached.
fn improved(ways: &Ways, mut order: Vec<usize>, cancel: &Cancel) -> Result<Vec<usize>, Cancelled> {
    let least_gain = TOLERANCE * ways.length(&order);
    for _ in 0..MOST_SWEEPS {
        cancel.check()?;
        let is_turned = turn_parts(ways, &mut order, least_gain);
        let is_moved =
            (1..=3).fold(false, |moved, len| move_parts(ways, &mut order, len, least_gain) | moved);
        if !is_turned && !is_moved {
            break;
        }
    }
    Ok(order)
}

/// Reverses parts of the order where that shortens the path; returns whether any was reversed.
fn turn_parts(ways: &Ways, order: &mut [usize], least_gain: f64) -> bool {
    let mut is_better = false;
    for begin in 0..order.len() {
        for end in begin + 2..=order.len() {
            let (before, after) = around(order, begin, end);
            let (first, last) = (Some(order[begin]), Some(order[end - 1]));
            let present = ways.leg(before, first) + ways.leg(last, after);
            if present - ways.leg(before, last) - ways.leg(first, after) > least_gain {
                order[begin..end].reverse();
                is_better = true;
            }
        }
    }
    is_better
}

/// Moves parts of `len` positions elsewhere in the order where that shortens the path; returns whether any
/// was moved.
fn move_parts(ways: &Ways, order: &mut [usize], len: usize, least_gain: f64) -> bool {
    let mut is_better = false;
    for begin in 0..(order.len() + 1).saturating_sub(len) {
        for place in (0..=order.len()).filter(|place| !(begin..=begin + len).contains(place)) {
            let end = begin + len;
            let (before, after) = around(order, begin, end);
            let (new_before, new_after) = around(order, place, place);
            let (first, last) = (Some(order[begin]), Some(order[end - 1]));
            let present = ways.leg(before, first) + ways.leg(last, after) + ways.leg(new_before, new_after);
            let moved = ways.leg(before, after) + ways.leg(new_before, first) + ways.leg(last, new_after);
            if present - moved > least_gain {
                if place < begin {
                    order[place..end].rotate_right(len);
                } else {
                    order[begin..place].rotate_left(len);
                }
                is_better = true;
            }
        }
    }
    is_better
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn ball() -> KeepOut {
        KeepOut::new(DVec3::ZERO, 0.5, 0.0).unwrap()
    }

    fn positions(n: usize, seed: u64) -> Vec<DVec3> {
        let mut random = Random::new(seed, 0);
        (0..n).map(|_| random.in_cube().normalize() * random.range(0.6, 1.0)).collect()
    }

    fn length(start: Option<DVec3>, positions: &[DVec3], order: &[usize]) -> f64 {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..positions.len()).collect::<Vec<_>>(), "every position once");
        tour_length(start, order.iter().map(|&i| positions[i]), &ball())
    }

    /// The shortest of all orders, by brute force.
    fn by_trial(ways: &Ways, order: &mut Vec<usize>) -> f64 {
        if order.len() == ways.n {
            return ways.length(order);
        }
        let mut best = f64::INFINITY;
        for next in 0..ways.n {
            if !order.contains(&next) {
                order.push(next);
                best = best.min(by_trial(ways, order));
                order.pop();
            }
        }
        best
    }

    #[test]
    fn up_to_a_dozen_views_the_way_is_the_shortest() {
        for n in 0..=7 {
            for seed in 0..20 {
                let positions = positions(n, seed);
                for start in [None, Some(DVec3::new(0.0, 0.8, 0.1))] {
                    let found = length(start, &positions, &tour(start, &positions, &ball()).unwrap());
                    let best = by_trial(&Ways::new(start, &positions, &ball()), &mut Vec::new());
                    assert!((found - best).abs() < 1e-12, "{n} views, seed {seed}: {found}, not {best}");
                }
            }
        }
    }

    #[test]
    fn a_detour_is_the_difference_of_two_ways() {
        for seed in 0..20 {
            let (mut route, position) = (positions(5, seed), positions(6, seed + 100)[5]);
            for start in [None, Some(DVec3::X)] {
                let before = tour_length(start, route.iter().copied(), &ball());
                let (place, cost) = detour(start, &route, position, &ball());
                route.insert(place, position);
                let after = tour_length(start, route.iter().copied(), &ball());
                assert!((after - before - cost).abs() < 1e-12 && cost > -1e-12);
                route.remove(place);
            }
        }
        assert_eq!(detour(None, &[], DVec3::X, &ball()), (0, 0.0));
    }

    #[test]
    fn the_heuristic_is_close_to_the_shortest() {
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
        for n in 10..=12 {
            for seed in 0..10 {
                let ways = Ways::new(Some(DVec3::X), &positions(n, seed), &ball());
                let excess = ways.length(&short(&ways, &Cancel::default()).unwrap())
                    / ways.length(&shortest(&ways))
                    - 1.0;
                assert!(excess > -1e-12);
                (sum, worst, count) = (sum + excess, worst.max(excess), count + 1.0);
            }
        }
        assert!(sum / count < 0.01 && worst < 0.1, "mean {} and worst {worst} too long", sum / count);
    }

    #[test]
    fn the_heuristic_never_makes_the_way_longer() {
        for seed in 0..10 {
            let positions = positions(25, seed);
            let order = tour(Some(DVec3::X), &positions, &ball()).unwrap();
            // Its own result, fed back, is a start that is hard to improve.
            let sorted: Vec<DVec3> = order.iter().map(|&i| positions[i]).collect();
            let again = tour(Some(DVec3::X), &sorted, &ball()).unwrap();
            let found = length(Some(DVec3::X), &positions, &order);
            assert!(length(Some(DVec3::X), &sorted, &again) <= found * (1.0 + TOLERANCE));
            assert!(found < length(Some(DVec3::X), &positions, &(0..25).collect::<Vec<_>>()));
        }
    }

    /// Both searches on the same positions.
    #[test]
    fn long_tours_are_hardly_longer() {
        for (n, seed) in [(13, 0), (100, 1), (300, 2), (300, 3)] {
            let positions = positions(n, seed);
            for start in [None, Some(DVec3::X)] {
                let (ways, never) = (Ways::new(start, &positions, &ball()), &Cancel::default());
                let [thorough, quick] =
                    [short(&ways, never).unwrap(), long_tour(start, &positions, &ball(), never).unwrap()]
                        .map(|order| length(start, &positions, &order));
                println!("{n} views: {quick:.3} m, thorough {thorough:.3} m");
                assert!(quick < 1.15 * thorough, "{n} views: {quick} m, not {thorough} m");
            }
        }
    }

    #[test]
    fn thousands_of_views_take_no_time() {
        let positions = positions(20_000, 7);
        let start = std::time::Instant::now();
        let order = tour(Some(DVec3::X), &positions, &ball()).unwrap();
        let time = start.elapsed();
        println!("{} m in {time:?}", length(Some(DVec3::X), &positions, &order));
        assert!(time.as_secs_f64() < 20.0, "{time:?}");
        // Its own result, as the given order, does not get longer.
        let sorted: Vec<DVec3> = order.iter().take(3000).map(|&i| positions[i]).collect();
        let again = tour(Some(DVec3::X), &sorted, &ball()).unwrap();
        let given: Vec<usize> = (0..3000).collect();
        assert!(length(Some(DVec3::X), &sorted, &again) <= length(Some(DVec3::X), &sorted, &given));
    }

    #[test]
    fn positions_that_are_none_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, 1e300].map(|x| DVec3::new(0.0, x, 0.0)) {
            for n in [1, 12, 13, 1001] {
                let positions = [positions(n, 0), vec![bad]].concat();
                assert!(tour(None, &positions, &ball()).is_err());
            }
            assert!(tour(Some(bad), &[], &ball()).is_err());
        }
        assert_eq!(tour(None, &[DVec3::X; 2000], &ball()).unwrap().len(), 2000, "all at one place");
    }

    #[test]
    fn sweeps_are_bounded_without_effect() {
        let most = (0..40).map(|seed| {
            let ways = Ways::new(Some(DVec3::X), &positions(13 + 7 * seed as usize, seed), &ball());
            let sweeps = |mut order: Vec<usize>| {
                let least_gain = TOLERANCE * ways.length(&order);
                (1..).find(|_| {
                    let is_turned = turn_parts(&ways, &mut order, least_gain);
                    !((1..=3)
                        .fold(is_turned, |moved, len| move_parts(&ways, &mut order, len, least_gain) | moved))
                })
            };
            sweeps(inserted(&ways, &Cancel::default()).unwrap()).max(sweeps((0..ways.n).collect()))
        });
        let most = most.max().flatten().unwrap();
        println!("at most {most} sweeps");
        assert!(most < MOST_SWEEPS / 2, "{most}");
    }
}
