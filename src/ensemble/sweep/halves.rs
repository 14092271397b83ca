//! What the host reads of a half: the types of its paths, and what a frozen half tells the other.

use rayon::prelude::*;

use super::Ensemble;
use crate::ensemble::build::Build;
use crate::ensemble::candidate::weight;
use crate::ensemble::groups::Group;
use crate::ensemble::guidance::{Guidance, NORMAL_LENGTH, SIMILARITY_RADIUS};
use crate::ensemble::pool::{Pool, TypeKey};
use crate::ensemble::similarity::similarity_median;
use crate::gpu::layout::{PassUniform, ROW_KEY, ROW_LENS, guide_rows, is_long, row_guide, unpack_position};
use crate::gpu::run::{Buffer, Dispatch, Run};
use crate::{Error, Result};

/// The types of the paths of a half.
#[derive(Clone, Copy)]
pub(super) struct Keys<'a> {
    rows: &'a [[u32; 4]],
    /// Where keys may be long.
    lens: &'a [[u32; 4]],
}

impl Keys<'_> {
    pub(super) fn len(self) -> usize {
        self.rows.len()
    }

    /// None where the device has miscomputed.
    pub(super) fn get(self, i: usize) -> Option<TypeKey> {
        let [third, last] = self.lens.get(i).map_or([0; 2], |row| [row[2], row[3]]);
        TypeKey::from_words([self.rows[i][0], self.rows[i][1], third, last])
    }
}

impl Ensemble {
    /// What the frozen half tells the moving one, taken after all its moves (METHOD.md C6e).
    pub(super) fn freeze(&mut self, run: &mut Run, half: usize) -> Result<()> {
        if !self.mix.guided() {
            return Ok(());
        }
        let first = self.build.groups.first_of_half(half);
        let count = self.build.groups.half_paths();
        // The pools' orders one after another: a group's guides take the columns of its own paths.
        let order = self.halves[half].iter().flat_map(|group| &group.pool.order);
        let words: Vec<u32> = order.flat_map(|&path| [path, 0]).collect();
        run.set_lists(&words);
        let uniform = PassUniform { entries: count, guides_first: first, ..self.build.uniform() };
        run.submit(&[Dispatch { variant: self.build.variant("gather", &[]), uniform }])?;
        let Guidance { normals, guides, .. } = self.build.guidance;
        let ranges: Vec<_> = (0..guide_rows(self.build.max_edges, normals))
            .map(|i| {
                let row = (row_guide(self.build.max_edges) + i) as u64;
                let start = 16 * (row * u64::from(self.build.groups.paths()) + u64::from(first));
                start..start + 16 * u64::from(count)
            })
            .collect();
        let max_edges = self.build.max_edges as usize;
        let of_group = |bytes: &[u8], begin: u32, pool: &Pool| {
            let rows: &[[u32; 4]] = bytemuck::cast_slice(bytes);
            let read = |place: u32, word: usize| {
                unpack_position(rows[word / 4 * count as usize + (begin + place) as usize][word % 4])
            };
            let position = |place, vertex| read(place, 1 + vertex);
            let with_normal = |place, vertex| {
                let [x, y, z] = position(place, vertex);
                let n = read(place, 1 + max_edges + vertex).map(|n| NORMAL_LENGTH * n);
                [x, y, z, n[0], n[1], n[2]]
            };
            let median = if normals {
                similarity_median(pool, with_normal, SIMILARITY_RADIUS, guides)
            } else {
                similarity_median(pool, position, SIMILARITY_RADIUS, guides)
            };
            // A pool in which no path has company guides nobody: any median will do.
            median.unwrap_or(0.0)
        };
        let groups = &mut self.halves[half];
        let each = self.build.groups.group_paths();
        run.look_at(Buffer::Chains, &ranges, |bytes| {
            groups.par_iter_mut().enumerate().for_each(|(number, group)| {
                group.similarity_median = of_group(bytes, number as u32 * each, &group.pool);
            });
        })
    }

    /// Rows of the paths of a half, one after another: those of their types, then `rows`.
    pub(super) fn look_at_keys<T>(
        &self,
        run: &mut Run,
        half: usize,
        rows: &[usize],
        look: impl FnOnce(Keys, &[[u32; 4]]) -> T,
    ) -> Result<T> {
        let groups = self.build.groups;
        let range = |row: &usize| {
            let start = 16 * (*row as u64 * u64::from(groups.paths()) + u64::from(groups.first_of_half(half)));
            start..start + 16 * u64::from(groups.half_paths())
        };
        // Where keys may be long, the lens's row has the rest of them.
        let of_keys: &[usize] = if is_long(self.build.max_edges) { &[ROW_KEY, ROW_LENS] } else { &[ROW_KEY] };
        let ranges: Vec<_> = of_keys.iter().chain(rows).map(range).collect();
        run.look_at(Buffer::Chains, &ranges, |bytes| {
            let all: &[[u32; 4]] = bytemuck::cast_slice(bytes);
            let (keys, rest) = all.split_at(groups.half_paths() as usize);
            let (lens, rest) = rest.split_at((of_keys.len() - 1) * keys.len());
            look(Keys { rows: keys, lens }, rest)
        })
    }

    /// Sorts the groups of a half anew by the types of their paths, as the device tells them. With `weighed`, also the
    /// samples of b and of the target's integral that the independence kernel has left with the keys, by group and path.
    pub(super) fn regroup(&mut self, run: &mut Run, half: usize, weighed: bool) -> Result<Vec<Vec<[f64; 2]>>> {
        let Build { groups, two_stage, .. } = self.build;
        // log w of the last independent proposal; log w(p) of its pixel, under a two-stage target.
        let sample = |[_, _, log_w, log_proposed]: &[u32; 4]| {
            let [log_w, log_proposed] = [log_w, log_proposed].map(|bits| f64::from(f32::from_bits(*bits)));
            [weight(log_proposed), weight(log_proposed - if two_stage { log_w } else { 0.0 })]
        };
        let regrouped: Option<Vec<_>> = self.look_at_keys(run, half, &[], |keys, _| {
            let each = groups.group_paths() as usize;
            let of_group = |group: u32| {
                let paths = group as usize * each..(group as usize + 1) * each;
                let samples = if weighed { keys.rows[paths.clone()].iter().map(sample).collect() } else { Vec::new() };
                let keys: Option<Vec<TypeKey>> = paths.map(|i| keys.get(i)).collect();
                Some((Group::new(Pool::build(&keys?, groups.first(half, group))), samples))
            };
            (0..groups.count()).into_par_iter().map(of_group).collect()
        })?;
        let regrouped = regrouped.ok_or_else(|| {
            Error::runtime(
                "the device returned paths without a type: its driver miscomputes, try another with --device",
            )
        })?;
        let samples;
        (self.halves[half], samples) = regrouped.into_iter().unzip();
        Ok(samples)
    }
}
