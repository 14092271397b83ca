//! A map of sightings: where on the film lamps are seen through specular vertices alone (METHOD.md 2.1c).
//!
//! The first seeks, walks from the camera through specular vertices, begin anywhere on the film. Those that meet a lamp tell
//! where others should begin (shaders/transport/sightings.wesl).

use super::bootstrap::Start;
use super::candidate::Candidate;
use super::path_traced::PathTraced;
use super::photons;
use super::pool::TypeKey;
use super::strategies::Strategies;
use crate::gpu::lights::alias_table;
use crate::gpu::run::Run;

/// Pass indices of the first seeks: apart from those of the start.
const SEEK_PASSES: [u32; 2] = [0x8000_0004, 0x8000_0005];
/// First seeks, in two rounds: where the first finds nothing, or enough, it is the last.
const SEEKS: u32 = 1 << 17;
const ENOUGH: usize = 1 << 10;
/// Cells on a side of the film.
const SIDE: usize = 64;
/// Rows of vec4 that the map takes.
pub const ROWS: u64 = (SIDE * SIDE) as u64;
/// Share of the seeks that begin anywhere on the film.
const EVEN_SHARE: f64 = 0.25;
/// What cells beside one with a sighting and across its corners are given of its square: its lamp may go on there.
const BESIDE: f64 = 1.0 / 16.0;
const ACROSS: f64 = 1.0 / 64.0;

/// A lamp that was seen through specular vertices.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    pub pixel: [f32; 2],
    /// I over the density of an even seek.
    pub weight: f64,
    pub key: TypeKey,
}

impl Sighting {
    fn of(candidate: &Candidate) -> Option<Self> {
        let weight = candidate.weight();
        candidate.key().filter(|_| weight > 0.0).map(|key| Self { pixel: candidate.pixel, weight, key })
    }
}

/// The map as rows of an alias table, the last word the density of its cell relative to an even one: about as the root of the
/// mean square of what is seen there, the law of least variance. None without sightings.
pub fn map(film: [u32; 2], sightings: impl Iterator<Item = Sighting>) -> Option<Vec<[u32; 4]>> {
    let mut squares = vec![0.0f64; SIDE * SIDE];
    for sighting in sightings {
        let cell = [0, 1].map(|i| {
            let at = f64::from(sighting.pixel[i]) / f64::from(film[i]) * SIDE as f64;
            (at as usize).min(SIDE - 1)
        });
        squares[cell[1] * SIDE + cell[0]] += sighting.weight.powi(2);
    }
    let at = |x: usize, y: usize| if x < SIDE && y < SIDE { squares[y * SIDE + x] } else { 0.0 };
    let spread = |i: usize| {
        // Cells past the edge wrap to what `at` knows as none.
        let ([left, x, right], [above, y, below]) = (around(i % SIDE), around(i / SIDE));
        let beside = at(left, y) + at(right, y) + at(x, above) + at(x, below);
        let across = at(left, above) + at(right, above) + at(left, below) + at(right, below);
        (at(x, y) + BESIDE * beside + ACROSS * across).sqrt()
    };
    let wanted: Vec<f64> = (0..SIDE * SIDE).map(spread).collect();
    let sum: f64 = wanted.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let cells = wanted.len() as f64;
    let density: Vec<f64> = wanted.iter().map(|w| EVEN_SHARE + (1.0 - EVEN_SHARE) * cells * w / sum).collect();
    let own: Vec<u32> = (0..wanted.len() as u32).collect();
    let rows = alias_table(&density, &own).into_iter().zip(&density);
    Some(rows.map(|([threshold, own, other, _], d)| [threshold, own, other, (*d as f32).to_bits()]).collect())
}

fn around(i: usize) -> [usize; 3] {
    [i.wrapping_sub(1), i, i + 1]
}

impl Start {
    /// Seeks lamps from anywhere on the film.
    pub(super) fn seek(&self, run: &mut Run) -> crate::Result<Vec<Sighting>> {
        let mut found = Vec::new();
        let strategies = Strategies::seeks(self.max_edges);
        for pass in SEEK_PASSES {
            let (candidates, _) = self.candidates(run, &strategies, self.given(), SEEKS, pass)?;
            found.extend(candidates.iter().filter_map(Sighting::of));
            if found.is_empty() || found.len() >= ENOUGH {
                break;
            }
        }
        Ok(found)
    }

    /// Lays the map of those that are not left to the path tracer; its row, if there is one.
    pub(super) fn lay_sightings(&self, run: &Run, found: &[Sighting], path_traced: PathTraced) -> Option<u32> {
        let row = self.maps_row? + photons::MOST_ROWS as u32;
        let map = map(self.film, found.iter().copied().filter(|sighting| !path_traced.has(sighting.key)))?;
        run.set_chains(16 * u64::from(row), bytemuck::cast_slice(&map));
        Some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sighting(x: f32, y: f32, weight: f64) -> Sighting {
        Sighting { pixel: [x, y], weight, key: TypeKey::new(2, 1) }
    }

    fn density(map: &[[u32; 4]], x: usize, y: usize) -> f64 {
        f64::from(f32::from_bits(map[y * SIDE + x][3]))
    }

    #[test]
    fn lamps_are_looked_for_where_they_were_seen() {
        // A cell is 10 x 5 pixels.
        let map = map([640, 320], [sighting(105.0, 52.0, 4.0), sighting(639.9, 319.9, 1.0)].into_iter()).unwrap();
        assert_eq!(map.len() as u64, ROWS);
        let [seen, beside, across, corner] = [(10, 10), (11, 10), (9, 9), (63, 63)].map(|(x, y)| density(&map, x, y));
        let hot = |d: f64| d - EVEN_SHARE;
        assert!((hot(beside) / hot(seen) - 0.25).abs() < 1e-5 && (hot(across) / hot(seen) - 0.125).abs() < 1e-5);
        assert!((hot(corner) / hot(seen) - 0.25).abs() < 1e-5);
        assert!((density(&map, 40, 20) - EVEN_SHARE).abs() < 1e-6);
        let mean = (0..SIDE * SIDE).map(|i| density(&map, i % SIDE, i / SIDE)).sum::<f64>() / ROWS as f64;
        assert!((mean - 1.0).abs() < 1e-5, "{mean}");
        // What the alias table gives every cell is its density.
        let mut given = vec![0.0; SIDE * SIDE];
        for [threshold, own, other, _] in &map {
            let share = f64::from(f32::from_bits(*threshold)).min(1.0);
            given[*own as usize] += share;
            given[*other as usize] += 1.0 - share;
        }
        assert!(given.iter().enumerate().all(|(i, d)| (d - density(&map, i % SIDE, i / SIDE)).abs() < 1e-3));
    }

    #[test]
    fn there_is_no_map_of_nothing() {
        assert!(map([64, 48], std::iter::empty()).is_none());
        assert!(map([64, 48], [sighting(1.0, 1.0, f64::INFINITY)].into_iter()).is_none());
    }
}
