//! What the host reads of every path after a mutation that may have changed its type.

use super::Ensemble;
use crate::ensemble::groups::Group;
use crate::ensemble::pool::{Pool, TypeKey};
use crate::gpu::layout::{ROW_KEY, ROW_LENS, is_long};
use crate::gpu::run::{Buffer, Run};
use crate::{Error, Result};

/// The row of a path's type.
pub(super) struct KeyRow {
    pub(super) key: TypeKey,
    /// log w of the state; under a two-stage target, once the independence kernel has run, log w(p) of its proposal.
    pub(super) log_w: f32,
    /// log w of the last independent proposal.
    pub(super) log_proposed: f32,
}

impl Ensemble {
    /// The types of the paths of a half.
    pub(super) fn read_keys(&self, run: &mut Run, half: usize) -> Result<Vec<KeyRow>> {
        // Where keys may be long, the lens's row has the rest of them.
        let rows: &[usize] = if is_long(self.build.max_edges) { &[ROW_KEY, ROW_LENS] } else { &[ROW_KEY] };
        let rows = self.read_rows(run, half, rows)?;
        let (rows, lens) = rows.split_at(self.build.groups.half_paths() as usize);
        let keys: Option<Vec<KeyRow>> = (0..)
            .zip(rows)
            .map(|(i, [low, next, log_w, log_proposed])| {
                let [third, last] = lens.get(i).map_or([0; 2], |row: &[u32; 4]| [row[2], row[3]]);
                let key = TypeKey::from_words([*low, *next, third, last])?;
                let [log_w, log_proposed] = [log_w, log_proposed].map(|bits| f32::from_bits(*bits));
                Some(KeyRow { key, log_w, log_proposed })
            })
            .collect();
        keys.ok_or_else(|| {
            Error::runtime(
                "the device returned paths without a type: its driver miscomputes, try another with --device",
            )
        })
    }

    /// Rows of the paths of a half, one after another.
    pub(super) fn read_rows(&self, run: &mut Run, half: usize, rows: &[usize]) -> Result<Vec<[u32; 4]>> {
        let groups = self.build.groups;
        let range = |row: &usize| {
            let start = 16 * (*row as u64 * u64::from(groups.paths()) + u64::from(groups.first_of_half(half)));
            start..start + 16 * u64::from(groups.half_paths())
        };
        let ranges: Vec<_> = rows.iter().map(range).collect();
        Ok(bytemuck::cast_slice(&run.read_ranges(Buffer::Chains, &ranges)?).to_vec())
    }

    /// The groups of a half by the types of its paths.
    pub(super) fn groups_of(&self, rows: &[KeyRow], half: usize) -> Vec<Group> {
        let keys: Vec<TypeKey> = rows.iter().map(|row| row.key).collect();
        let stretches = (0..).zip(keys.chunks_exact(self.build.groups.group_paths() as usize));
        stretches.map(|(group, keys)| Group::new(Pool::build(keys, self.build.groups.first(half, group)))).collect()
    }
}
