use super::cloud::Cloud;
use super::views::N_VIEWS;
use crate::layers::{Dense, rectify};
use crate::weights::{self, NetworkLayout, WeightsError};
use pulp::{Arch, Simd, WithSimd};

/// The network: maps a [`Cloud`] and the visited views to the share of new surface that each of the 33 views
/// would show.
///
/// The parts are the paper's, but smaller: two edge blocks, each of which finds the 16 nearest points in the
/// space of its features and takes the maximum of three layers over each pair; the maximum over all points
/// and the visited views, appended to the features of each point; attention of all points to all; two layers
/// for each point, the maximum over all points, and three layers. `docs/methods/pc-nbv.md` has the formulas.
///
/// Every number is computed in the same order of operations on every CPU, by one thread, so the results have
/// the same bits.
///
/// ```
/// use nextview_learned::pc_nbv::{Cloud, Network, views};
///
/// let one_point = Cloud::from_points(vec![[0.0; 3]; Cloud::N_POINTS]).unwrap();
/// assert_eq!(Network::default().gains(&one_point, &[false; views::N_VIEWS]).len(), 33);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    points: Dense,
    first: [Dense; 3],
    between: Dense,
    second: [Dense; 3],
    query: Dense,
    key: Dense,
    value: Dense,
    lift: [Dense; 2],
    head: [Dense; 3],
}

/// Number of neighbours in an edge block.
const N_NEIGHBORS: usize = 16;

/// Features of a point before an edge block, and those added by each of its layers.
const N_FEATURES: usize = 24;
const GROWTH: usize = 12;

/// Features of a point after an edge block, and after both together with its input.
const N_EDGE: usize = N_FEATURES + 3 * GROWTH;
const N_LOCAL: usize = 2 * N_EDGE + N_FEATURES;

/// Features of a point with the maximum over all points and the visited views.
const N_JOINED: usize = 2 * N_LOCAL + N_VIEWS;

/// Units of attention, of the layers after it, and of the hidden layer before the last.
const N_ATTENTION: usize = N_JOINED / 4;
const N_LIFTED: usize = 256;
const N_HIDDEN: usize = 128;

/// The library's weights; `docs/methods/pc-nbv.md` describes the training.
const WEIGHTS: &[u8] = include_bytes!("../../weights/pc_nbv.safetensors");

fn layout() -> NetworkLayout {
    let edge = |block: usize| {
        (0..3).map(move |n| (format!("edge{block}_{}", n + 1), N_FEATURES * 2, n)).map(|(name, pair, n)| {
            let n_in = if n == 0 { pair } else { N_FEATURES + n * GROWTH };
            (name, vec![GROWTH, n_in])
        })
    };
    let dense = |name: &str, n_out: usize, n_in: usize| (name.to_owned(), vec![n_out, n_in]);
    let layers = [dense("points", N_FEATURES, 3)]
        .into_iter()
        .chain(edge(1))
        .chain([dense("between", N_FEATURES, N_EDGE + N_FEATURES)])
        .chain(edge(2))
        .chain([
            dense("query", N_ATTENTION, N_JOINED),
            dense("key", N_ATTENTION, N_JOINED),
            dense("value", N_JOINED, N_JOINED),
            dense("lift1", N_LIFTED, N_JOINED),
            dense("lift2", N_LIFTED, N_LIFTED),
            dense("fc1", N_LIFTED, N_LIFTED),
            dense("fc2", N_HIDDEN, N_LIFTED),
            dense("fc3", N_VIEWS, N_HIDDEN),
        ]);
    NetworkLayout { network: "PC-NBV", layers: layers.collect() }
}

impl Default for Network {
    fn default() -> Self {
        Self::from_safetensors(WEIGHTS).expect("the library's own weights are whole")
    }
}

impl Network {
    /// Creates the network from the content of a safetensors file: the tensors written by
    /// `training/pc_nbv.py`, in single or half precision.
    pub fn from_safetensors(file: &[u8]) -> Result<Self, WeightsError> {
        let mut layers = weights::read(file, &layout())?.into_iter().map(Dense::new);
        let mut next = || layers.next().expect("as many as in the layout");
        Ok(Self {
            points: next(),
            first: [next(), next(), next()],
            between: next(),
            second: [next(), next(), next()],
            query: next(),
            key: next(),
            value: next(),
            lift: [next(), next()],
            head: [next(), next(), next()],
        })
    }

    /// Returns for each view the share of new surface of the object that it would show; not bounded.
    pub fn gains(&self, cloud: &Cloud, visited: &[bool; N_VIEWS]) -> [f32; N_VIEWS] {
        Arch::new().dispatch(CloudForward { network: self, cloud, visited })
    }
}

/// Computes the gains with the CPU's instructions.
#[derive(Clone, Copy)]
struct CloudForward<'a> {
    network: &'a Network,
    cloud: &'a Cloud,
    visited: &'a [bool; N_VIEWS],
}

impl WithSimd for CloudForward<'_> {
    type Output = [f32; N_VIEWS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let network = self.network;
        let before = network.points.rows(self.cloud.points().as_flattened(), 3);
        let first = beside(&edge_block(&before, &network.first), N_EDGE, &before, N_FEATURES);
        let mut between = network.between.rows(&first, N_EDGE + N_FEATURES);
        rectify(&mut between);
        let second = edge_block(&between, &network.second);
        let local = beside(&second, N_EDGE, &first, N_EDGE + N_FEATURES);
        let mut shared = largest(&local, N_LOCAL);
        shared.extend(self.visited.iter().map(|&visited| f32::from(u8::from(visited))));
        let joined = joined(&local, &shared);
        let mut lifted = network.lift[0].rows(&attended(&joined, network), N_JOINED);
        rectify(&mut lifted);
        let mut values = largest(&network.lift[1].rows(&lifted, N_LIFTED), N_LIFTED);
        for (n, layer) in network.head.iter().enumerate() {
            if n > 0 {
                rectify(&mut values);
            }
            let n_in = values.len();
            values = layer.rows(&values, n_in);
        }
        std::array::from_fn(|view| values[view])
    }
}

/// For each point, the maximum over its neighbours of three layers of the pair; each layer also takes the
/// inputs of the earlier layers, after its own output.
#[inline(always)]
fn edge_block(features: &[f32], layers: &[Dense; 3]) -> Vec<f32> {
    let mut found = Vec::with_capacity(features.len() / N_FEATURES * N_EDGE);
    let (mut pair, mut one, mut two, mut three) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (point, neighbors) in neighbors(features).chunks_exact(N_NEIGHBORS).enumerate() {
        let own = &features[point * N_FEATURES..][..N_FEATURES];
        let begin = found.len();
        found.resize(begin + N_EDGE, f32::NEG_INFINITY);
        for &neighbor in neighbors {
            let other = &features[neighbor * N_FEATURES..][..N_FEATURES];
            [&mut pair, &mut one, &mut two, &mut three].into_iter().for_each(Vec::clear);
            pair.extend_from_slice(own);
            pair.extend(other.iter().zip(own).map(|(other, own)| other - own));
            layers[0].append(&pair, &mut one);
            rectify(&mut one);
            one.extend_from_slice(own);
            layers[1].append(&one, &mut two);
            rectify(&mut two);
            two.extend_from_slice(&one);
            layers[2].append(&two, &mut three);
            three.extend_from_slice(&two);
            take_larger(&mut found[begin..], &three);
        }
    }
    found
}

/// For each point, the other points nearest to it in feature space; the first on ties.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
fn neighbors(features: &[f32]) -> Vec<usize> {
    let n = features.len() / N_FEATURES;
    let by_feature = transposed(features, N_FEATURES);
    let mut nearest = Vec::with_capacity(n * N_NEIGHBORS);
    for point in 0..n {
        let mut dist_sq = vec![0.0_f32; n];
        for feature in 0..N_FEATURES {
            let own = features[point * N_FEATURES + feature];
            let others = &by_feature[feature * n..][..n];
            for other in 0..n {
                let difference = others[other] - own;
                dist_sq[other] += difference * difference;
            }
        }
        let mut others: Vec<usize> = (0..n).filter(|&other| other != point).collect();
        others.sort_by(|&a, &b| dist_sq[a].total_cmp(&dist_sq[b]));
        nearest.extend_from_slice(&others[..N_NEIGHBORS]);
    }
    nearest
}

/// Each row of `n` numbers plus the attention of all points: the values of all points, weighted by the
/// softmax over the products of their keys with the point's query.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
fn attended(joined: &[f32], network: &Network) -> Vec<f32> {
    let n = joined.len() / N_JOINED;
    let queries = network.query.rows(joined, N_JOINED);
    let keys = transposed(&network.key.rows(joined, N_JOINED), N_ATTENTION);
    let values = network.value.rows(joined, N_JOINED);
    let mut found = joined.to_vec();
    for (row, query) in found.chunks_exact_mut(N_JOINED).zip(queries.chunks_exact(N_ATTENTION)) {
        let mut weights = vec![0.0_f32; n];
        for unit in 0..N_ATTENTION {
            let keys = &keys[unit * n..][..n];
            for point in 0..n {
                weights[point] += query[unit] * keys[point];
            }
        }
        let most = weights.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
        weights.iter_mut().for_each(|weight| *weight = (*weight - most).exp());
        let total: f32 = weights.iter().sum();
        for point in 0..n {
            let (weight, value) = (weights[point] / total, &values[point * N_JOINED..][..N_JOINED]);
            for unit in 0..N_JOINED {
                row[unit] += weight * value[unit];
            }
        }
    }
    found
}

/// Rows of `n_a` numbers, each followed by a row of `n_b`.
#[inline(always)]
fn beside(a: &[f32], n_a: usize, b: &[f32], n_b: usize) -> Vec<f32> {
    let mut found = Vec::with_capacity(a.len() + b.len());
    for (a, b) in a.chunks_exact(n_a).zip(b.chunks_exact(n_b)) {
        found.extend_from_slice(a);
        found.extend_from_slice(b);
    }
    found
}

/// The features of each point, each followed by the shared ones.
#[inline(always)]
fn joined(local: &[f32], shared: &[f32]) -> Vec<f32> {
    let mut found = Vec::with_capacity(local.len() / N_LOCAL * N_JOINED);
    for row in local.chunks_exact(N_LOCAL) {
        found.extend_from_slice(row);
        found.extend_from_slice(shared);
    }
    found
}

/// The maximum over all rows of `n` numbers.
#[inline(always)]
fn largest(rows: &[f32], n: usize) -> Vec<f32> {
    let mut found = vec![f32::NEG_INFINITY; n];
    rows.chunks_exact(n).for_each(|row| take_larger(&mut found, row));
    found
}

#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
fn take_larger(found: &mut [f32], row: &[f32]) {
    let row = &row[..found.len()];
    for i in 0..found.len() {
        found[i] = if row[i] > found[i] { row[i] } else { found[i] };
    }
}

/// Columns of rows of `n` numbers, one column after the other.
#[inline(always)]
fn transposed(rows: &[f32], n: usize) -> Vec<f32> {
    let n_rows = rows.len() / n;
    (0..rows.len()).map(|i| rows[i % n_rows * n + i / n_rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::slow_dense;
    use crate::weights::Layer;
    use crate::weights::tests::{file, tensors};
    use nextview::geometry::random::Random;
    use std::collections::BTreeMap;

    /// Layers by name.
    type Layers = BTreeMap<String, Layer>;

    fn network(seed: u64) -> (Network, Layers) {
        let (file, layout) = (file(&tensors(seed, &layout())), layout());
        let names = layout.layers.iter().map(|(name, _)| name.clone());
        let layers = names.zip(weights::read(&file, &layout).unwrap()).collect();
        (Network::from_safetensors(&file).unwrap(), layers)
    }

    /// Points, some of them repeated, and visited views.
    fn input(seed: u64) -> (Cloud, [bool; N_VIEWS]) {
        let mut random = Random::new(seed, 8);
        let points: Vec<[f32; 3]> = (0..90).map(|_| (0.5 * random.in_cube()).as_vec3().to_array()).collect();
        let points = points.into_iter().cycle().take(Cloud::N_POINTS).collect();
        (Cloud::from_points(points).unwrap(), std::array::from_fn(|_| random.index(3) == 0))
    }

    fn slow_rectified(values: Vec<f32>) -> Vec<f32> {
        values.into_iter().map(|value| value.max(0.0)).collect()
    }

    /// For each number of a row, the maximum over all rows.
    fn slow_largest(rows: &[Vec<f32>]) -> Vec<f32> {
        (0..rows[0].len()).map(|i| rows.iter().map(|row| row[i]).fold(f32::NEG_INFINITY, f32::max)).collect()
    }

    /// An edge block for one point, as in docs/methods/pc-nbv.md.
    fn slow_edges(layers: &Layers, block: usize, features: &[Vec<f32>], point: usize) -> Vec<f32> {
        let own = &features[point];
        let dist_sq = |other: usize| {
            features[other].iter().zip(own).fold(0.0_f32, |sum, (b, a)| sum + (b - a) * (b - a))
        };
        let mut others: Vec<usize> = (0..features.len()).filter(|&other| other != point).collect();
        others.sort_by(|&a, &b| dist_sq(a).total_cmp(&dist_sq(b)).then(a.cmp(&b)));
        let layer = |n: usize, row: &[f32]| slow_dense(row, &layers[&format!("edge{block}_{n}")]);
        let pair = |&other: &usize| {
            let difference = features[other].iter().zip(own).map(|(b, a)| b - a);
            let pair: Vec<f32> = own.iter().copied().chain(difference).collect();
            let one = [slow_rectified(layer(1, &pair)), own.clone()].concat();
            let two = [slow_rectified(layer(2, &one)), one.clone()].concat();
            [layer(3, &two), two].concat()
        };
        slow_largest(&others[..16].iter().map(pair).collect::<Vec<_>>())
    }

    /// The network, as in docs/methods/pc-nbv.md: one point after the other.
    fn slow_gains(layers: &Layers, cloud: &Cloud, visited: &[bool; N_VIEWS]) -> Vec<f32> {
        let on_each = |name: &str, rows: &[Vec<f32>]| -> Vec<Vec<f32>> {
            rows.iter().map(|row| slow_dense(row, &layers[name])).collect()
        };
        let rectified =
            |rows: Vec<Vec<f32>>| -> Vec<Vec<f32>> { rows.into_iter().map(slow_rectified).collect() };
        let all = 0..Cloud::N_POINTS;
        let points: Vec<Vec<f32>> = cloud.points().iter().map(|point| point.to_vec()).collect();
        let before = on_each("points", &points);
        let first = all.clone().map(|i| [slow_edges(layers, 1, &before, i), before[i].clone()].concat());
        let first: Vec<Vec<f32>> = first.collect();
        let between = rectified(on_each("between", &first));
        let local = all.clone().map(|i| [slow_edges(layers, 2, &between, i), first[i].clone()].concat());
        let local: Vec<Vec<f32>> = local.collect();
        let visited: Vec<f32> = visited.iter().map(|&visited| if visited { 1.0 } else { 0.0 }).collect();
        let shared = [slow_largest(&local), visited].concat();
        let joined: Vec<Vec<f32>> = local.iter().map(|row| [row.clone(), shared.clone()].concat()).collect();
        let [queries, keys, values] = ["query", "key", "value"].map(|name| on_each(name, &joined));
        let attended = all.map(|i| {
            let product = |key: &Vec<f32>| queries[i].iter().zip(key).fold(0.0, |sum, (q, k)| sum + q * k);
            let products: Vec<f32> = keys.iter().map(product).collect();
            let most = products.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let odds: Vec<f32> = products.iter().map(|product| (product - most).exp()).collect();
            let total: f32 = odds.iter().sum();
            let weighted = |unit: usize| {
                let terms = odds.iter().zip(&values).map(|(odds, value)| odds / total * value[unit]);
                terms.fold(joined[i][unit], |sum, term| sum + term)
            };
            (0..joined[i].len()).map(weighted).collect()
        });
        let lifted = rectified(on_each("lift1", &attended.collect::<Vec<_>>()));
        let whole = slow_largest(&on_each("lift2", &lifted));
        let hidden = slow_rectified(slow_dense(&whole, &layers["fc1"]));
        let hidden = slow_rectified(slow_dense(&hidden, &layers["fc2"]));
        slow_dense(&hidden, &layers["fc3"])
    }

    #[test]
    fn computes_what_the_slow_twin_computes_to_the_bit() {
        for seed in 0..3 {
            let ((network, layers), (cloud, visited)) = (network(seed), input(seed));
            let gains = network.gains(&cloud, &visited);
            assert_eq!(gains.as_slice(), slow_gains(&layers, &cloud, &visited), "seed {seed}");
            assert!(gains.iter().any(|gain| gain.abs() > 1e-3), "{gains:?}");
            assert_ne!(gains, network.gains(&cloud, &visited.map(|visited| !visited)));
        }
    }

    #[test]
    fn has_the_same_bits_with_all_instructions() {
        let (network, (cloud, visited)) = (Network::default(), input(9));
        let scalar = CloudForward { network: &network, cloud: &cloud, visited: &visited };
        let scalar = scalar.with_simd(pulp::Scalar::new());
        assert_eq!(scalar.map(f32::to_bits), network.gains(&cloud, &visited).map(f32::to_bits));
    }

    #[test]
    fn huge_weights_do_no_harm() {
        let ((mut network, _), (cloud, visited)) = (network(1), input(1));
        for layer in [&mut network.value, &mut network.query, &mut network.points] {
            layer.weight_mut().iter_mut().for_each(|weight| *weight *= 1e30);
        }
        network.gains(&cloud, &visited);
    }
}
