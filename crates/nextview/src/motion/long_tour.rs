//! Tours through thousands of positions, in time nearly proportional to their number.

use super::KeepOut;
use crate::{Cancel, Cancelled};
use glam::DVec3;
use rayon::prelude::*;

/// Number of neighbours considered for moves.
const N_NEIGHBORS: usize = 10;

/// Range of the search for neighbours along each curve, to both sides.
const REACH_ON_CURVE: usize = 12;

/// Maximum number of sweeps over all positions.
const MOST_SWEEPS: usize = 30;

/// Maximum length of the part of the order that a move reverses or shifts.
const MOST_SHIFTED: usize = 10_000;

/// Relative differences below this may be rounding errors.
const TOLERANCE: f64 = 1e-12;

/// Starts from the order along a space-filling curve (Morton 1966), or the order given if that is shorter,
/// and sweeps over moves that lead to a neighbour: 2-opt and Or-opt, as for short tours.
pub(super) fn long_tour(
    start: Option<DVec3>,
    positions: &[DVec3],
    ball: &KeepOut,
    cancel: &Cancel,
) -> Result<Vec<usize>, Cancelled> {
    let curves = [0.0, 1.0 / 3.0].map(|shift| curve(positions, shift));
    let length = |order: &[usize]| {
        let first = start.zip(order.first()).map_or(0.0, |(start, &i)| ball.path_length(start, positions[i]));
        let legs = order.windows(2).map(|leg| ball.path_length(positions[leg[0]], positions[leg[1]]));
        first + legs.sum::<f64>()
    };
    let given: Vec<usize> = (0..positions.len()).collect();
    let backward: Vec<usize> = curves[0].iter().rev().copied().collect();
    let neighbors = neighbors(positions, &curves);
    let [first, _] = curves;
    let mut orders = [given, first, backward].map(|order| (length(&order), order));
    orders.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(length, order), ..] = orders;
    let mut search = TourSearch::new(start, positions, ball, order);
    search.improve(&neighbors, TOLERANCE * length, cancel)?;
    Ok(search.order)
}

/// Orders the positions by their codes on the curve. A shift by a third of the whole moves its jumps
/// elsewhere (Chan 1998).
fn curve(positions: &[DVec3], shift: f64) -> Vec<usize> {
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let scale = f64::from(1 << 20) / (high - low).max_element().max(f64::MIN_POSITIVE);
    let code = |position: DVec3| {
        let [x, y, z] = ((position - low) * scale + shift * f64::from(1 << 20)).to_array();
        spread(x as u64) | spread(y as u64) << 1 | spread(z as u64) << 2
    };
    let mut coded: Vec<(u64, usize)> =
        positions.par_iter().map(|p| code(*p)).zip(0..positions.len()).collect();
    coded.sort_unstable();
    coded.into_iter().map(|(_, i)| i).collect()
}

/// Spreads the lowest 21 bits, with two zeros before each.
fn spread(bits: u64) -> u64 {
    let mut x = bits.min((1 << 21) - 1);
    for (shift, mask) in [
        (32, 0x001F_0000_0000_FFFF),
        (16, 0x001F_0000_FF00_00FF),
        (8, 0x100F_00F0_0F00_F00F),
        (4, 0x10C3_0C30_C30C_30C3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Near positions of each position, nearest first.
fn neighbors(positions: &[DVec3], curves: &[Vec<usize>; 2]) -> Vec<Vec<u32>> {
    let places = curves.each_ref().map(|curve| {
        let mut places = vec![0; curve.len()];
        curve.iter().enumerate().for_each(|(place, &i)| places[i] = place);
        places
    });
    let nearest = |i: usize| {
        let window = |(curve, places): (&Vec<usize>, &Vec<usize>)| {
            let place = places[i];
            let range = place.saturating_sub(REACH_ON_CURVE)..(place + REACH_ON_CURVE + 1).min(curve.len());
            curve[range].to_vec()
        };
        let mut near: Vec<usize> = curves.iter().zip(&places).flat_map(window).collect();
        near.sort_unstable();
        near.dedup();
        near.retain(|&other| other != i);
        let distance = |other: usize| positions[i].distance_squared(positions[other]);
        near.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        near.into_iter().take(N_NEIGHBORS).map(|other| other as u32).collect()
    };
    (0..positions.len()).into_par_iter().map(nearest).collect()
}

/// An order under improvement.
struct TourSearch<'a> {
    start: Option<DVec3>,
    positions: &'a [DVec3],
    ball: &'a KeepOut,
    order: Vec<usize>,
    /// By position, its index in the order.
    index: Vec<usize>,
}

impl<'a> TourSearch<'a> {
    fn new(start: Option<DVec3>, positions: &'a [DVec3], ball: &'a KeepOut, order: Vec<usize>) -> Self {
        let mut search = Self { start, positions, ball, index: vec![0; order.len()], order };
        search.number(0, search.order.len());
        search
    }

    fn number(&mut self, begin: usize, end: usize) {
        (begin..end).for_each(|i| self.index[self.order[i]] = i);
    }

    fn improve(&mut self, neighbors: &[Vec<u32>], least_gain: f64, cancel: &Cancel) -> Result<(), Cancelled> {
        for _ in 0..MOST_SWEEPS {
            let mut is_better = self.turn_beginning(least_gain);
            for (position, near) in neighbors.iter().enumerate() {
                cancel.check()?;
                for &other in near {
                    if !self.may_gain(position, other as usize) {
                        break;
                    }
                    is_better |= self.turn(position, other as usize, least_gain);
                    is_better |= self.shift(position, other as usize, least_gain);
                }
            }
            if !is_better {
                break;
            }
        }
        Ok(())
    }

    /// Length of the leg between the positions at indices `from`, -1 for the start, and `to` of the order; 0
    /// without a start or beyond the end.
    fn leg(&self, from: isize, to: usize) -> f64 {
        let Some(&to) = self.order.get(to) else { return 0.0 };
        let from = match usize::try_from(from) {
            Ok(from) => Some(self.positions[self.order[from]]),
            Err(_) => self.start,
        };
        from.map_or(0.0, |from| self.ball.path_length(from, self.positions[to]))
    }

    /// Whether a leg between two positions can be shorter than one of the first position's present legs.
    /// Otherwise, a move that adds this leg gains nothing, or is also found from the second position.
    fn may_gain(&self, position: usize, other: usize) -> bool {
        let at = self.index[position];
        let longest = self.leg(at as isize - 1, at).max(self.leg(at as isize, at + 1));
        self.positions[position].distance(self.positions[other]) < longest
    }

    /// Reverses the part of the order between two positions so that they become neighbours, if that gains.
    fn turn(&mut self, a: usize, b: usize, least_gain: f64) -> bool {
        let (low, high) = (self.index[a].min(self.index[b]), self.index[a].max(self.index[b]));
        self.turn_part(low as isize, high, least_gain)
    }

    /// Reverses the part after index `low` (-1 for the start), up to index `high`, if that gains.
    fn turn_part(&mut self, low: isize, high: usize, least_gain: f64) -> bool {
        let begin = (low + 1) as usize;
        if high <= begin || high - begin > MOST_SHIFTED {
            return false;
        }
        let present = self.leg(low, begin) + self.leg(high as isize, high + 1);
        let turned = self.leg(low, high) + self.leg(begin as isize, high + 1);
        if present - turned <= least_gain {
            return false;
        }
        self.order[begin..=high].reverse();
        self.number(begin, high + 1);
        true
    }

    /// Reverses beginnings of the order that gain.
    fn turn_beginning(&mut self, least_gain: f64) -> bool {
        let last = self.order.len().min(MOST_SHIFTED);
        (1..last).fold(false, |is_better, high| self.turn_part(-1, high, least_gain) | is_better)
    }

    /// Moves one to three positions, if that gains: those beginning with the first one to behind the second,
    /// or those ending with it to before the second.
    fn shift(&mut self, position: usize, other: usize, least_gain: f64) -> bool {
        (1..=3).any(|len| {
            let (at, to) = (self.index[position], self.index[other]);
            self.shift_part(at, at + len, to + 1, least_gain)
                || (at + 1)
                    .checked_sub(len)
                    .is_some_and(|begin| self.shift_part(begin, at + 1, to, least_gain))
        })
    }

    /// Moves a part of the order before the position at index `place`, if that gains.
    fn shift_part(&mut self, begin: usize, end: usize, place: usize, least_gain: f64) -> bool {
        let is_part = end <= self.order.len() && !(begin..=end).contains(&place);
        if !is_part || place.abs_diff(begin) > MOST_SHIFTED {
            return false;
        }
        let (first, last, before) = (begin, end as isize - 1, begin as isize - 1);
        let present = self.leg(before, first) + self.leg(last, end) + self.leg(place as isize - 1, place);
        let joined = if end < self.order.len() { self.leg(before, end) } else { 0.0 };
        let moved = joined + self.leg(place as isize - 1, first) + self.leg(last, place);
        if present - moved <= least_gain {
            return false;
        }
        if place < begin {
            self.order[place..end].rotate_right(end - begin);
            self.number(place, end);
        } else {
            self.order[begin..place].rotate_left(end - begin);
            self.number(begin, place);
        }
        true
    }
}
