//! How much paths resemble each other (METHOD.md 3.3; our design over the supplement's "positions, no normals").

use super::pool::{NodeRange, Pool, select};

/// How many members of a pool are looked at for the median. There are several pools, and this is host work: more would
/// cost time that tells little, as the median only centres a sigmoid.
const SUBSAMPLE: usize = 64;

/// d^2 = (1/n) SUM_j |x_j - v_j|^2 / h^2 over vertices j = 0..edges of both paths: all but the camera's.
///
/// `bandwidth` is h, in scene units; what is compared may have more coordinates than a position (scaled normals).
pub fn mean_squared_distance<const N: usize>(
    edges: u32,
    bandwidth: f64,
    x: impl Fn(usize) -> [f64; N],
    v: impl Fn(usize) -> [f64; N],
) -> f64 {
    let squared = |(a, b): ([f64; N], [f64; N])| -> f64 { a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum() };
    let sum: f64 = (0..edges as usize).map(|j| squared((x(j), v(j)))).sum();
    sum / (f64::from(edges) * bandwidth * bandwidth)
}

/// The similarities exp(-d^2/2) of a set of guides, kept as logarithms so that they never underflow together.
#[derive(Debug, Clone, PartialEq)]
pub struct Similarity {
    /// Normalised to sum 1.
    pub weights: Vec<f64>,
    /// S, the log of the mean similarity: l_max + ln mean exp(l_i - l_max).
    pub log_mean: f64,
}

impl Similarity {
    /// From the d^2 of each guide; `None` if there is no guide.
    pub fn from_squared_distances(squared: &[f64]) -> Option<Self> {
        let log_max = -0.5 * squared.iter().copied().min_by(f64::total_cmp)?;
        let mut weights: Vec<f64> = squared.iter().map(|d2| (-0.5 * d2 - log_max).exp()).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        let log_mean = log_max + (sum / squared.len() as f64).ln();
        Some(Self { weights, log_mean })
    }
}

/// S_0, the median over a pool of its members' S against the pool itself (METHOD.md 3.4).
///
/// A function of the frozen half alone, so using it as the centre of the sigmoid adapts nothing to the moving half.
/// Up to 64 members spread evenly over `pool.order` are each compared with `guides` members of the node they would
/// find if they were not in the pool themselves (C12: leave a member out of its own S).
/// `None` if no member has another of its length. `position(place, vertex)` is that of the path at `pool.order[place]`,
/// vertex 0 at the light.
pub fn similarity_median<const N: usize>(
    pool: &Pool,
    position: impl Fn(u32, usize) -> [f64; N],
    bandwidth: f32,
    guides: u32,
) -> Option<f32> {
    let count = pool.order.len();
    let samples = count.min(SUBSAMPLE);
    let mut values: Vec<f64> = (0..samples)
        .filter_map(|sample| {
            // Even spread: the first member of each of `samples` equal parts.
            let at = sample * count / samples;
            leave_one_out(pool, at as u32, &position, f64::from(bandwidth), guides)
        })
        .collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 1 => Some(values[middle] as f32),
        _ => Some((0.5 * (values[middle - 1] + values[middle])) as f32),
    }
}

/// S of the member at `order[at]` against the others; `None` if it is alone.
fn leave_one_out<const N: usize>(
    pool: &Pool,
    at: u32,
    position: impl Fn(u32, usize) -> [f64; N],
    bandwidth: f64,
    guides: u32,
) -> Option<f64> {
    let key = pool.key_at(at);
    // Without itself, a single member of a type would be guided by its length.
    let has_peers = |node: &NodeRange| node.count > 1;
    let node = pool.type_node(key).filter(has_peers).or_else(|| pool.length_node(key.edges()).filter(has_peers))?;
    let rank = at - node.offset;
    // rank + o mod count with o < count is never the member itself.
    let squared: Vec<f64> = (1..=guides.min(node.count - 1))
        .map(|o| {
            let guide = node.offset + select(rank, o, node.count);
            mean_squared_distance(key.edges(), bandwidth, |j| position(at, j), |j| position(guide, j))
        })
        .collect();
    Some(Similarity::from_squared_distances(&squared)?.log_mean)
}

#[cfg(test)]
mod tests {
    use super::super::pool::{Tag, TypeKey};
    use super::*;

    fn key(tags: &[Tag]) -> TypeKey {
        TypeKey::from_tags(tags)
    }

    #[test]
    fn distant_guides_do_not_underflow() {
        let near = Similarity::from_squared_distances(&[0.0, 2.0]).unwrap();
        let far = Similarity::from_squared_distances(&[1e6, 1e6 + 2.0]).unwrap();
        for (a, b) in near.weights.iter().zip(&far.weights) {
            assert!((a - b).abs() < 1e-9);
        }
        assert!((near.log_mean - 5e5 - far.log_mean).abs() < 1e-9);
        assert_eq!(Similarity::from_squared_distances(&[]), None);
    }

    #[test]
    fn distance_leaves_the_camera_vertex_out_and_is_a_mean() {
        // Two edges: vertices 0 and 1 are compared, vertex 2 is not.
        let x = |j: usize| [[0.0; 3], [1.0, 0.0, 0.0], [9.0; 3]][j];
        let v = |j: usize| [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]][j];
        assert_eq!(mean_squared_distance(2, 0.5, x, v), 8.0);
    }

    /// Paths of one edge on a line: only the light's position counts. Places hold paths in order, as the types are one.
    fn line(xs: &[f64]) -> impl Fn(u32, usize) -> [f64; 3] {
        |place, _| [xs[place as usize], 0.0, 0.0]
    }

    #[test]
    fn median_leaves_the_member_itself_out() {
        // Neighbours at distance 1, one guide each, the last one compared with the first: d = 1, 1, 2.
        let position = line(&[0.0, 1.0, 2.0]);
        let pool = Pool::build(&[key(&[]); 3], 0);
        assert_eq!(similarity_median(&pool, &position, 1.0, 1), Some(-0.5));
        // All others: (1, 2), (1, 1), (1, 2); with itself each S would be larger.
        let expected = ((-0.5f64).exp() / 2.0 + (-2.0f64).exp() / 2.0).ln() as f32;
        let all = similarity_median(&pool, &position, 1.0, 16).unwrap();
        assert!((all - expected).abs() < 1e-6);
    }

    #[test]
    fn a_single_member_of_a_type_is_compared_with_its_length() {
        use Tag::{Diffuse as D, Reflection as R};
        let position = |place: u32, _| [3.0 * f64::from(place), 0.0, 0.0];
        let pool = Pool::build(&[key(&[D]), key(&[R])], 0);
        assert_eq!(similarity_median(&pool, position, 3.0, 4), Some(-0.5));
        let alone = Pool::build(&[key(&[D]), key(&[])], 0);
        assert_eq!(similarity_median(&alone, position, 3.0, 4), None);
        assert_eq!(similarity_median(&Pool::default(), position, 3.0, 4), None);
    }

    #[test]
    fn a_large_pool_is_sampled_evenly() {
        // Distances to the next member grow linearly, so the median is near the middle one.
        let xs: Vec<f64> = (0..10_000).map(|i| 0.5 * 1e-4 * f64::from(i).powi(2)).collect();
        let pool = Pool::build(&vec![key(&[]); xs.len()], 0);
        let median = similarity_median(&pool, line(&xs), 1.0, 1).unwrap();
        assert!((median + 0.125).abs() < 0.01, "{median}");
    }
}
