//! A map of photons: where light comes from that speculars have bent (METHOD.md 2.1b).
//!
//! Walks from the light leave photons at the first diffuse vertex behind speculars. The independence kernel's walks from the
//! camera aim a share of their directions as the photons around came (shaders/transport/photons.wesl).

use glam::Vec3;

use super::bootstrap::{BATCH, Start};
use crate::gpu::layout::PassUniform;
use crate::gpu::run::{Buffer, Dispatch, Run};
use crate::gpu::shader::Variant;
use crate::scene::Features;

/// Pass index of the walks: apart from those of the start.
const PHOTON_PASS: u32 = 0x8000_0003;
/// Walks from the light at most.
pub const WALKS: u32 = 1 << 20;
/// Walks for each photon at most: where fewer leave any, a map is not worth its time.
pub const MOST_WALKS_A_PHOTON: usize = 1000;
/// Photons after which no more are looked for.
pub const ENOUGH: usize = 1 << 16;
/// Cells on a side of the grid: two to this power.
const LEVELS: u32 = 7;
const CELLS: usize = 1 << (3 * LEVELS);
/// Photons of a list; at most 15, which a cell's word can count.
const MOST_PHOTONS: usize = 15;
/// Photons that a cube has at least which is worth a list of its own, and that are compared when it is made.
const FEWEST_PHOTONS: usize = 16;
const MOST_COMPARED: usize = 64;
/// Rows of vec4 that the map takes at most: cells, and a list for every cube that holds enough photons.
pub(super) const MOST_ROWS: u64 = (CELLS / 4) as u64 + (LEVELS as u64 + 1) * ENOUGH as u64;

/// What a photon tells: where it arrived, and the point that it seems to come from.
#[derive(Debug, Clone, Copy)]
pub struct Photon {
    pub at: Vec3,
    pub source: Vec3,
}

impl Photon {
    /// From the two rows that the device reports; none if the walk left no photon.
    pub fn from_rows(rows: [[f32; 4]; 2]) -> Option<Self> {
        let [[x, y, z, found], [a, b, c, _]] = rows;
        let photon = Self { at: Vec3::new(x, y, z), source: Vec3::new(a, b, c) };
        (found == 1.0 && photon.at.is_finite() && photon.source.is_finite()).then_some(photon)
    }
}

/// The map as rows of words: cells in Morton order, four a row, then the lists. Empty without photons.
pub fn map(photons: &[Photon]) -> Vec<[u32; 4]> {
    let mut sorted: Vec<(u32, Photon)> = photons.iter().map(|photon| (cell(photon.at), *photon)).collect();
    sorted.sort_by_key(|(cell, _)| *cell);
    if sorted.is_empty() {
        return Vec::new();
    }
    let mut map = Map { cells: vec![0; CELLS], lists: Vec::new() };
    map.fill(&sorted, 0, 0, 0);
    let rows = map.cells.chunks_exact(4).map(|row| [row[0], row[1], row[2], row[3]]);
    rows.chain(map.lists.iter().map(|photon| photon.map(f32::to_bits))).collect()
}

struct Map {
    cells: Vec<u32>,
    /// Apparent source and width s of the law about it.
    lists: Vec<[f32; 4]>,
}

impl Map {
    /// Fills a cube's cells, given the photons inside in the cells' order; `outer` is the word of the cube around.
    fn fill(&mut self, inside: &[(u32, Photon)], first_cell: u32, level: u32, outer: u32) {
        let cells = 1u32 << (3 * (LEVELS - level));
        let mut word = outer;
        if level == 0 || inside.len() >= FEWEST_PHOTONS {
            let first = (CELLS / 4 + self.lists.len()) as u32;
            word = first << 4 | self.add_list(inside);
        }
        if level == LEVELS || inside.len() < FEWEST_PHOTONS {
            self.cells[first_cell as usize..(first_cell + cells) as usize].fill(word);
            return;
        }
        let mut rest = inside;
        for child in 0..8 {
            let begin = first_cell + child * cells / 8;
            let count = rest.partition_point(|(cell, _)| *cell < begin + cells / 8);
            self.fill(&rest[..count], begin, level + 1, word);
            rest = &rest[count..];
        }
    }

    /// Of photons evenly spaced in the cells' order those whose directions are the farthest apart, so that every way that light
    /// takes has its own; each as wide as the mean of the photons it stands for, or half of the way to the next if alone.
    fn add_list(&mut self, inside: &[(u32, Photon)]) -> u32 {
        let count = inside.len().min(MOST_COMPARED);
        let looked: Vec<Photon> = (0..count).map(|i| inside[(2 * i + 1) * inside.len() / (2 * count)].1).collect();
        let centre = looked.iter().map(|photon| photon.at).sum::<Vec3>() / count as f32;
        let ways: Vec<Vec3> = looked.iter().map(|photon| (photon.source - centre).normalize_or_zero()).collect();
        let versine = |a: usize, b: usize| 0.5 * (ways[a] - ways[b]).length_squared();
        let mut chosen = vec![0usize];
        let mut nearest: Vec<(f32, usize)> = (0..count).map(|i| (versine(i, 0), 0)).collect();
        while chosen.len() < MOST_PHOTONS.min(count) {
            let far = (0..count).max_by(|a, b| nearest[*a].0.total_cmp(&nearest[*b].0)).expect("some photons");
            let number = chosen.len();
            chosen.push(far);
            for (i, near) in nearest.iter_mut().enumerate() {
                let apart = versine(i, far);
                if apart < near.0 {
                    *near = (apart, number);
                }
            }
        }
        for (number, &representative) in chosen.iter().enumerate() {
            let own = nearest.iter().filter(|near| near.1 == number).map(|near| near.0);
            let (sum, n) = own.fold((0.0, 0), |(sum, n), apart| (sum + apart, n + 1));
            let others =
                chosen.iter().filter(|other| **other != representative).map(|other| versine(*other, representative));
            let next = others.fold(WIDEST, f32::min);
            let width = if n > 1 { sum / (n - 1) as f32 } else { 0.25 * next };
            self.lists.push(looked[representative].source.extend(width.clamp(NARROWEST, WIDEST)).to_array());
        }
        chosen.len() as u32
    }
}

/// What the width s may be: 1 - cos of the angle within which half of the directions lie.
const NARROWEST: f32 = 1e-7;
const WIDEST: f32 = 0.2;

/// Number of the cell that holds a position in the unit sphere's cube. Twin: `photons_at` in shaders/transport/photons.wesl.
fn cell(at: Vec3) -> u32 {
    let side = (1u32 << LEVELS) as f32;
    let at = ((at + 1.0) * (0.5 * side)).clamp(Vec3::ZERO, Vec3::splat(side - 1.0)).as_uvec3();
    let spread = |x: u32| (0..LEVELS).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u32>();
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}

/// Whether light that speculars have bent can be looked for from its lamps: none is traced from a sky.
pub fn has_photons(features: Features) -> bool {
    features.mirror && (!features.sky || features.mixed)
}

/// The pipeline of the map of photons.
pub fn variant(features: Features, max_edges: u32) -> Variant {
    Variant { pass: "photons", features, max_edges, flags: vec![] }
}

impl Start {
    /// Makes the map of photons; its row, if there is one.
    pub(super) fn lay_photons(&self, run: &mut Run) -> crate::Result<Option<u32>> {
        let Some(row) = self.maps_row else { return Ok(None) };
        let mut found = Vec::new();
        let mut made = 0;
        for first in (0..WALKS).step_by(BATCH as usize) {
            if found.len() >= ENOUGH {
                break;
            }
            let variant = variant(self.features, self.max_edges);
            let entries = BATCH.min(WALKS - first);
            let uniform =
                PassUniform { entries, entries_offset: first, pass_index: PHOTON_PASS, ..self.uniform(self.given()) };
            run.submit(&[Dispatch { variant, uniform }])?;
            let rows: Vec<[[f32; 4]; 2]> = run.read(Buffer::Output, 0..32 * u64::from(entries))?;
            made += entries;
            found.extend(rows.into_iter().filter_map(Photon::from_rows));
        }
        if found.len() * MOST_WALKS_A_PHOTON < made as usize {
            return Ok(None);
        }
        found.truncate(ENOUGH);
        run.set_chains(16 * u64::from(row), bytemuck::cast_slice(&map(&found)));
        Ok(Some(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Photons along a line through the scene, from `source`.
    fn line(count: usize, from: Vec3, to: Vec3, source: Vec3) -> impl Iterator<Item = Photon> {
        (0..count).map(move |i| Photon { at: from.lerp(to, i as f32 / count as f32), source })
    }

    /// The list that a position's cell refers to: sources and widths.
    fn list_at(map: &[[u32; 4]], at: Vec3) -> Vec<(Vec3, f32)> {
        let cell = cell(at) as usize;
        let word = map[cell / 4][cell % 4];
        let rows = &map[(word >> 4) as usize..][..(word & 15) as usize];
        let read = |row: &[u32; 4]| row.map(f32::from_bits);
        rows.iter().map(read).map(|[x, y, z, width]| (Vec3::new(x, y, z), width)).collect()
    }

    #[test]
    fn cells_are_in_mortons_order() {
        let step = 2.0 / 128.0;
        assert_eq!(cell(Vec3::splat(-1.0)), 0);
        assert_eq!(cell(Vec3::new(-1.0 + 1.5 * step, -1.0, -1.0)), 1);
        assert_eq!(cell(Vec3::new(-1.0, -1.0 + 2.5 * step, -1.0)), 0b01_0000);
        assert_eq!(cell(Vec3::new(-1.0, -1.0, -1.0 + 1.5 * step)), 0b100);
        // What rounding puts outside is in the last cell.
        assert_eq!(cell(Vec3::splat(1.0)), (1 << 21) - 1);
    }

    #[test]
    fn every_cell_has_a_list_and_that_of_the_nearest_cube_with_photons() {
        let [left, right] = [Vec3::new(-0.9, 0.1, 0.1), Vec3::new(0.9, 0.1, 0.1)];
        let [lamp, other] = [Vec3::new(-0.5, 0.9, 0.0), Vec3::new(0.5, 0.9, 0.0)];
        let near = line(500, left, left + 0.05, lamp).chain(line(500, right, right - 0.05, other));
        let map = map(&near.collect::<Vec<_>>());
        assert!(map.len() as u64 <= MOST_ROWS);
        for step in 0..1000 {
            let at = Vec3::new(-1.0 + 0.002 * step as f32, 0.3, -0.7);
            let list = list_at(&map, at);
            assert!(!list.is_empty() && list.len() <= MOST_PHOTONS, "{at}");
            assert!(list.iter().all(|(_, width)| (NARROWEST..=WIDEST).contains(width)), "{list:?}");
        }
        assert!(list_at(&map, left).iter().all(|(source, _)| *source == lamp));
        assert!(list_at(&map, right).iter().all(|(source, _)| *source == other));
        // All photons of a cube from one point: the law is as narrow as it gets.
        assert!(list_at(&map, left).iter().all(|(_, width)| *width == NARROWEST));
        assert_eq!(super::map(&[]).len(), 0);
    }

    #[test]
    fn ways_of_few_photons_are_kept() {
        let at = Vec3::new(0.01, 0.01, 0.01);
        let [bright, faint] = [Vec3::new(0.0, 0.9, 0.0), Vec3::new(0.9, 0.2, 0.0)];
        let photons: Vec<_> = line(60, at, at, bright).chain(line(4, at, at, faint)).collect();
        let list = list_at(&map(&photons), at);
        assert!(list.iter().any(|(source, _)| *source == bright) && list.iter().any(|(source, _)| *source == faint));
    }
}
