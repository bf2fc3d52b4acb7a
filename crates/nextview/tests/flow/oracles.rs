//! The optimal quality by successive shortest paths and by trying all assignments.

use crate::cover::fewest_by_trial;
use crate::network::{Network, networks};
use nextview::Cancel;
use nextview::flow::fewest_sets;
use proptest::prelude::*;
use std::collections::{BTreeSet, VecDeque};

proptest! {
    #[test]
    fn quality_is_that_of_the_min_cost_flow(network in networks(30, 40, 20)) {
        let best = network.best_sets();
        let (n_served, quality) = max_quality_flow(&network);
        prop_assert_eq!(best.n_served(), n_served);
        prop_assert!((best.total_quality() - quality).abs() < 1e-9);
    }

    #[test]
    fn quality_then_sets_are_those_of_the_best_assignment(network in networks(5, 5, 8)) {
        let best = network.best_sets();
        let (quality, n_sets) = best_assignment(&network);
        prop_assert!((best.total_quality() - quality).abs() < 1e-9);
        prop_assert_eq!(fewest_by_trial(best.candidates()), n_sets);
        prop_assert_eq!(fewest_sets(best.candidates(), &Cancel::default()).unwrap().len(), n_sets);
    }
}

/// The largest quality of an assignment that serves all items that can be served, and the fewest sets with
/// it.
fn best_assignment(network: &Network) -> (f64, usize) {
    let options: Vec<_> = (0..network.n_items).map(|item| network.options(item)).collect();
    let served: Vec<_> = options.into_iter().filter(|options| !options.is_empty()).collect();
    let mut best = (0.0, 0);
    try_all(&served, 0.0, &mut Vec::new(), &mut best);
    best
}

fn try_all(rest: &[Vec<(f64, u32)>], quality: f64, sets: &mut Vec<u32>, best: &mut (f64, usize)) {
    let Some((options, rest)) = rest.split_first() else {
        let n_sets = sets.iter().collect::<BTreeSet<_>>().len();
        if quality > best.0 || quality == best.0 && n_sets < best.1 {
            *best = (quality, n_sets);
        }
        return;
    };
    for &(more, set) in options {
        sets.push(set);
        try_all(rest, quality + more, sets, best);
        sets.pop();
    }
}

/// Number of items served and total quality of the largest flow of best quality: successive shortest paths,
/// each found by the queue form of Bellman-Ford (SPFA), as in the paper.
fn max_quality_flow(network: &Network) -> (usize, f64) {
    let mut graph = Residual::of(network);
    let mut served = (0, 0.0);
    while let Some((path, cost)) = graph.shortest_path() {
        for edge in path {
            graph.edges[edge].capacity -= 1;
            graph.edges[edge ^ 1].capacity += 1;
        }
        served = (served.0 + 1, served.1 - cost);
    }
    served
}

struct Edge {
    to: usize,
    capacity: u32,
    cost: f64,
}

/// Node 0 is the source, node 1 the sink. Edge `2 k + 1` is the way back along edge `2 k`.
struct Residual {
    edges: Vec<Edge>,
    edges_of: Vec<Vec<usize>>,
}

impl Residual {
    fn of(network: &Network) -> Self {
        let channel_0 = 2 + network.n_items;
        let set_0 = channel_0 + network.sets_of_channel.len();
        let mut graph = Self { edges: Vec::new(), edges_of: vec![Vec::new(); set_0 + network.n_sets] };
        let unbounded = u32::MAX / 2;
        (0..network.n_items).for_each(|item| graph.connect(0, 2 + item, 1, 0.0));
        for &(item, channel, quality) in &network.edges {
            graph.connect(2 + item, channel_0 + channel, unbounded, -quality);
        }
        for (channel, sets) in network.sets_of_channel.iter().enumerate() {
            sets.iter()
                .for_each(|&set| graph.connect(channel_0 + channel, set_0 + set as usize, unbounded, 0.0));
        }
        (0..network.n_sets).for_each(|set| graph.connect(set_0 + set, 1, unbounded, 0.0));
        graph
    }

    fn connect(&mut self, from: usize, to: usize, capacity: u32, cost: f64) {
        self.edges_of[from].push(self.edges.len());
        self.edges.push(Edge { to, capacity, cost });
        self.edges_of[to].push(self.edges.len());
        self.edges.push(Edge { to: from, capacity: 0, cost: -cost });
    }

    /// The edges and the cost of a cheapest path with capacity from source to sink.
    fn shortest_path(&self) -> Option<(Vec<usize>, f64)> {
        let mut cost = vec![f64::INFINITY; self.edges_of.len()];
        let mut came_by = vec![None; self.edges_of.len()];
        cost[0] = 0.0;
        let mut queue = VecDeque::from([0]);
        while let Some(node) = queue.pop_front() {
            for &i in &self.edges_of[node] {
                let edge = &self.edges[i];
                if edge.capacity > 0 && cost[node] + edge.cost < cost[edge.to] - 1e-12 {
                    cost[edge.to] = cost[node] + edge.cost;
                    came_by[edge.to] = Some(i);
                    if !queue.contains(&edge.to) {
                        queue.push_back(edge.to);
                    }
                }
            }
        }
        let to_source = |&edge: &usize| came_by[self.edges[edge ^ 1].to];
        let path: Vec<usize> = std::iter::successors(came_by[1], to_source).collect();
        (!path.is_empty()).then_some((path, cost[1]))
    }
}
