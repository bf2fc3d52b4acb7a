//! Levels the remaining differences between charts after the gains.

use super::charts::Chart;
use super::photo::Photo;
use super::sight::PhotoSight;
use nextview::{Cancel, Cancelled};

/// Number of sweeps over all corrections.
const N_SWEEPS: usize = 60;

/// Weights of equal corrections of neighbours in a chart, and of zero corrections, compared to 1 for equal
/// colours at a seam.
const SMOOTH: f32 = 1.0;
const SMALL: f32 = 0.1;

/// Larger differences come from different places, not from different light.
const LARGEST: f32 = 40.0;

/// Colours after levelling.
pub(super) struct Levelled {
    /// By chart and vertex, in the chart's order: the correction added to the colour.
    pub corrections: Vec<Vec<[f32; 3]>>,
    /// The mean colour of each vertex in the charts; `None` if it is in no chart.
    pub vertex_colors: Vec<Option<[f32; 3]>>,
}

/// Computes corrections that equalise the colours of charts at shared vertices and are smooth inside
/// (Lempitsky & Ivanov 2007), by Gauss-Seidel sweeps.
pub(super) fn level(
    photos: &[Photo],
    sights: &[PhotoSight],
    triangles: &[[u32; 3]],
    charts: &[Chart],
    gains: &[[f32; 3]],
    cancel: &Cancel,
) -> Result<Levelled, Cancelled> {
    let first: Vec<usize> =
        charts.iter().scan(0, |n, chart| Some(std::mem::replace(n, *n + chart.vertices.len()))).collect();
    let mut colors: Vec<[f32; 3]> = Vec::new();
    let mut nodes_at: Vec<Vec<usize>> =
        vec![Vec::new(); sights.first().map_or(0, |sight| sight.places.len())];
    for chart in charts {
        for vertex in &chart.vertices {
            nodes_at[*vertex as usize].push(colors.len());
            let pixel = sights[chart.photo].places[*vertex as usize]
                .map_or_else(Default::default, |place| place.pixel);
            let (color, gain) = (photos[chart.photo].mean_around(pixel.x, pixel.y), gains[chart.photo]);
            colors.push([0, 1, 2].map(|channel| color[channel] * gain[channel]));
        }
    }
    let mut inside: Vec<Vec<usize>> = vec![Vec::new(); colors.len()];
    for (chart, first) in charts.iter().zip(&first) {
        cancel.check()?;
        for triangle in &chart.triangles {
            let nodes = triangles[*triangle].map(|vertex| first + chart.slot(vertex));
            for k in 0..3 {
                inside[nodes[k]].extend([nodes[(k + 1) % 3], nodes[(k + 2) % 3]]);
            }
        }
    }
    let is_alike = |a: usize, b: usize| (0..3).all(|c| (colors[a][c] - colors[b][c]).abs() <= LARGEST);
    let mut across: Vec<Vec<usize>> = vec![Vec::new(); colors.len()];
    for nodes in &nodes_at {
        for a in nodes {
            across[*a].extend(nodes.iter().filter(|b| *b != a && is_alike(*a, **b)));
        }
    }
    let mut corrections = vec![[0.0_f32; 3]; colors.len()];
    for _ in 0..N_SWEEPS {
        cancel.check()?;
        for i in 0..colors.len() {
            let weight = SMALL + SMOOTH * inside[i].len() as f32 + across[i].len() as f32;
            corrections[i] = [0, 1, 2].map(|c| {
                let smooth: f32 = inside[i].iter().map(|j| corrections[*j][c]).sum();
                let alike: f32 =
                    across[i].iter().map(|j| corrections[*j][c] + colors[*j][c] - colors[i][c]).sum();
                (SMOOTH * smooth + alike) / weight
            });
        }
    }
    let levelled = |node: &usize| [0, 1, 2].map(|c| colors[*node][c] + corrections[*node][c]);
    let mean = |nodes: &Vec<usize>| {
        let sum = nodes.iter().map(levelled).fold([0.0; 3], |sum, next| [0, 1, 2].map(|c| sum[c] + next[c]));
        (!nodes.is_empty()).then(|| sum.map(|value| value / nodes.len() as f32))
    };
    let vertex_colors = nodes_at.iter().map(mean).collect();
    let of_chart =
        |(chart, first): (&Chart, &usize)| corrections[*first..first + chart.vertices.len()].to_vec();
    Ok(Levelled { corrections: charts.iter().zip(&first).map(of_chart).collect(), vertex_colors })
}
