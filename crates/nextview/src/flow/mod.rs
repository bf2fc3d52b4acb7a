//! stub
/// stub
#[derive(Clone)]
pub struct BestSets {
    q: Vec<f64>,
    s: Vec<Vec<u32>>,
}
impl BestSets {
    /// stub
    pub fn new(n: usize, _: usize) -> Self {
        Self { q: vec![0.; n], s: vec![vec![]; n] }
    }
    /// stub
    #[inline]
    pub fn offer(&mut self, i: usize, s: u32, q: f64) {
        if q > self.q[i] {
            self.q[i] = q;
            self.s[i].clear();
            self.s[i].push(s)
        } else if q == self.q[i] && q > 0. {
            if self.s[i].last() != Some(&s) {
                self.s[i].push(s)
            }
        }
    }
    /// stub
    pub fn merge(&mut self, o: Self) {
        for i in 0..self.q.len() {
            if o.q[i] > self.q[i] {
                self.q[i] = o.q[i];
                self.s[i] = o.s[i].clone()
            } else if o.q[i] == self.q[i] {
                self.s[i].extend(&o.s[i]);
                self.s[i].sort();
                self.s[i].dedup()
            }
        }
    }
    /// stub
    pub fn n_served(&self) -> usize {
        self.q.iter().filter(|&&q| q > 0.).count()
    }
    /// stub
    pub fn total_quality(&self) -> f64 {
        self.q.iter().sum()
    }
}
/// stub
pub fn fewest_sets(b: &BestSets) -> Vec<u32> {
    let mut v: Vec<u32> = b.s.iter().filter_map(|s| s.first().copied()).collect();
    v.sort();
    v.dedup();
    v
}
