//! Two means, bin by bin: of a quadrature and of a device's proposals.

#[derive(Clone, Copy, Default)]
struct Bin {
    sum: f64,
    squares: f64,
    hits: u32,
}

impl Bin {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.squares += value * value;
        self.hits += u32::from(value > 0.0);
    }

    /// Variance of the sum of `n` independent samples, those that were not added being 0.
    fn variance(&self, n: f64) -> f64 {
        self.squares - self.sum * self.sum / n.max(1.0)
    }
}

pub struct Sums {
    /// Of the quadrature, proposals, and points put in their place; with how many there were for each bin.
    parts: [Vec<Bin>; 3],
    counts: [Vec<f64>; 3],
}

/// How well the two agree.
pub struct Agreement {
    pub worst: f64,
    /// Share of the integral in bins with enough hits on either side to be compared.
    covered: f64,
    bins: u32,
}

impl Agreement {
    pub fn holds(&self, limit: f64) -> bool {
        self.worst < limit && self.covered > 0.5 && self.bins > 0
    }
}

/// For the normal law a bin needs so many hits on either side.
const HITS: u32 = 150;

pub const QUADRATURE: usize = 0;
pub const PROPOSALS: usize = 1;
pub const PUT: usize = 2;

impl Sums {
    /// With the samples of each kind that a bin has.
    pub fn new(bins: usize, counts: [f64; 3]) -> Self {
        Self { parts: [(); 3].map(|()| vec![Bin::default(); bins]), counts: counts.map(|n| vec![n; bins]) }
    }

    /// What a sample adds to the integral.
    pub fn add(&mut self, kind: usize, bin: usize, value: f64) {
        self.parts[kind][bin].add(value);
    }

    /// Says how far apart the quadrature and the rest are.
    pub fn agreement(&self, what: &str) -> Agreement {
        let (mut worst, mut chi2, mut bins) = (0.0f64, 0.0, 0u32);
        let (mut sums, mut variances, mut all) = ([0.0; 2], [0.0; 2], 0.0);
        for bin in 0..self.parts[0].len() {
            let of = |kind: usize| {
                let part = &self.parts[kind][bin];
                (part.sum, part.variance(self.counts[kind][bin]), part.hits)
            };
            let [quadrature, proposals, put] = [QUADRATURE, PROPOSALS, PUT].map(of);
            let (mean, scatter) = (proposals.0 + put.0, proposals.1 + put.1);
            let (truth, variance, hits) = quadrature;
            all += truth;
            if hits < HITS || proposals.2 + put.2 < HITS {
                continue;
            }
            let z = (mean - truth) / (scatter + variance).sqrt();
            worst = worst.max(z.abs());
            chi2 += z * z;
            bins += 1;
            sums = [sums[0] + mean, sums[1] + truth];
            variances = [variances[0] + scatter, variances[1] + variance];
        }
        let ratio = sums[0] / sums[1];
        let error = (variances[0] / sums[0].powi(2) + variances[1] / sums[1].powi(2)).sqrt();
        let covered = sums[1] / all;
        println!(
            "{what}: worst |z| {worst:.2} in {bins} bins, chi2 / dof {:.2}, all together {ratio:.4} +- {error:.4} of the truth, {:.0} % of it in these bins",
            chi2 / f64::from(bins.max(1)),
            100.0 * covered
        );
        Agreement { worst, covered, bins }
    }
}
