use super::N_FEATURES;
use serde::{Deserialize, Serialize};

/// The boundary weights available to a policy.
pub const BOUNDARY_WEIGHTS: [f64; 5] = [0.0, 0.25, 0.5, 1.0, 2.0];

/// A learned choice of the boundary weight: for each weight, a linear function of the state estimates the
/// number of views still needed, negated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Policy {
    /// A row of feature weights for each of [`BOUNDARY_WEIGHTS`].
    rows: Vec<Vec<f64>>,
}

impl Default for Policy {
    /// The library's policy.
    fn default() -> Self {
        Self::from_json(include_str!("../../weights/kaba.json")).expect("the file is a policy")
    }
}

impl Policy {
    /// Creates a policy with these feature weights.
    pub fn new(rows: &[[f64; N_FEATURES]; BOUNDARY_WEIGHTS.len()]) -> Self {
        Self { rows: rows.iter().map(|row| row.to_vec()).collect() }
    }

    /// Reads a policy written by [`to_json`](Self::to_json); `None` if the text is anything else.
    pub fn from_json(text: &str) -> Option<Self> {
        let policy: Self = serde_json::from_str(text).ok()?;
        let fits = policy.rows.len() == BOUNDARY_WEIGHTS.len()
            && policy.rows.iter().all(|row| row.len() == N_FEATURES);
        fits.then_some(policy)
    }

    /// Returns the policy as JSON text, with a line for each boundary weight; it reads back bit for bit.
    pub fn to_json(&self) -> String {
        let rows: Vec<String> =
            self.rows.iter().map(|row| serde_json::to_string(row).expect("numbers are finite")).collect();
        format!("{{\"rows\": [\n{}\n]}}\n", rows.join(",\n"))
    }

    /// Returns, for each boundary weight, the estimated number of views still needed, negated.
    pub fn values(&self, features: &[f64; N_FEATURES]) -> [f64; BOUNDARY_WEIGHTS.len()] {
        std::array::from_fn(|action| self.rows[action].iter().zip(features).map(|(w, x)| w * x).sum())
    }

    /// Returns the boundary weight with the largest value, as its index in [`BOUNDARY_WEIGHTS`]; the smaller
    /// one on ties.
    pub fn choice(&self, features: &[f64; N_FEATURES]) -> usize {
        let values = self.values(features);
        let better = |best: usize, action: usize| if values[action] > values[best] { action } else { best };
        (1..values.len()).fold(0, better)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_the_weight_of_largest_value() {
        let mut rows = [[0.0; N_FEATURES]; BOUNDARY_WEIGHTS.len()];
        let mut features = [0.0; N_FEATURES];
        (features[0], features[3]) = (1.0, 0.5);
        assert_eq!(Policy::new(&rows).choice(&features), 0, "the smaller one on ties");
        rows[2][3] = 1.0;
        rows[4][0] = 0.4;
        assert_eq!(Policy::new(&rows).choice(&features), 2);
        rows[4][0] = 0.6;
        assert_eq!(Policy::new(&rows).choice(&features), 4);
    }

    #[test]
    fn comes_back_from_its_text() {
        let mut rows = [[1.0 / 3.0; N_FEATURES]; BOUNDARY_WEIGHTS.len()];
        rows[1][7] = -1e-17;
        let policy = Policy::new(&rows);
        assert_eq!(Policy::from_json(&policy.to_json()), Some(policy));
        assert_eq!(Policy::from_json("{\"rows\": [[1.0]]}"), None);
    }
}
