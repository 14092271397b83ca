//! The work of one half-sweep's perturbations: which paths each dispatch moves, as the shaders read it.

use std::collections::{BTreeMap, HashMap};

use super::groups::Group;
use super::mix::Mix;
use super::pool::TypeKey;
use crate::scene::Features;

/// A run of entries (path, guide node; two words each) in [`Work::words`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct List {
    /// In words.
    pub offset: u32,
    pub count: u32,
}

/// Words of a guides' node: offset and count in the order of the frozen half, and the median log similarity of its group.
/// Twin: `find_guides` in shaders/transport/similarity.wesl.
pub const NODE_WORDS: u32 = 3;

/// Dispatch lists of all passes, and the guides' nodes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Work {
    /// What goes into the lists' buffer.
    pub words: Vec<u32>,
    /// Where nodes begin, [`NODE_WORDS`] each.
    pub nodes_offset: u32,
    /// Per pass the kernels (by number) with their paths; every path that is not idle is in one list of each pass.
    pub passes: Vec<Vec<(usize, List)>>,
    /// Paths that no kernel applies to.
    pub idle: List,
}

impl Work {
    /// Types are frozen during these passes, so lists, nodes and rotas may depend on them (METHOD.md C6). Lists are sorted
    /// by type, and by group within a type: neighbours take the same branches.
    pub fn new(moving: &[Group], guides: &[Group], mix: &Mix, features: Features) -> Self {
        let mut nodes: Vec<u32> = Vec::new();
        let mut entries: BTreeMap<TypeKey, Vec<[u32; 2]>> = BTreeMap::new();
        let mut guides_begin = 0;
        for (moving, guides) in moving.iter().zip(guides) {
            let list = moving.pool.dispatch_list(|_| true, &guides.pool);
            let first_node = nodes.len() as u32 / NODE_WORDS;
            for node in &moving.pool.types {
                let of_type =
                    &list.entries[node.range.offset as usize..(node.range.offset + node.range.count) as usize];
                entries.entry(node.key).or_default().extend(of_type.iter().map(|[path, n]| [*path, first_node + n]));
            }
            for [offset, count] in list.nodes {
                nodes.extend([guides_begin + offset, count, guides.similarity_median.to_bits()]);
            }
            guides_begin += guides.pool.order.len() as u32;
        }
        let rotas: Vec<Vec<usize>> = entries.keys().map(|key| mix.rota(*key, features)).collect();
        let entries: Vec<Vec<[u32; 2]>> = entries.into_values().collect();
        let mut work = Self::default();
        // Passes in which the same types share a kernel share a list.
        let mut known: HashMap<Vec<usize>, List> = HashMap::new();
        let mut list_of = |work: &mut Self, types: Vec<usize>| {
            *known.entry(types).or_insert_with_key(|types| {
                let offset = work.words.len() as u32;
                for &t in types {
                    work.words.extend(entries[t].iter().flatten());
                }
                List { offset, count: (work.words.len() as u32 - offset) / 2 }
            })
        };
        let kernels = mix.kernels().len();
        for pass in 0..mix.perturbation_passes() as usize {
            let mut lists = Vec::new();
            for kernel in 0..kernels {
                let types: Vec<usize> = (0..rotas.len()).filter(|t| rotas[*t].get(pass) == Some(&kernel)).collect();
                if !types.is_empty() {
                    lists.push((kernel, list_of(&mut work, types)));
                }
            }
            work.passes.push(lists);
        }
        let idle: Vec<usize> = (0..rotas.len()).filter(|t| rotas[*t].is_empty()).collect();
        work.idle = list_of(&mut work, idle);
        work.nodes_offset = work.words.len() as u32;
        work.words.extend(nodes);
        work
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::groups::Groups;
    use crate::ensemble::pool::{Pool, Tag, TypeKey};
    use crate::kernels::{independence, lens, multi_chain};
    use Tag::{Diffuse as D, Transmission as T};
    use std::collections::BTreeSet;

    #[test]
    fn every_path_is_in_one_list_of_every_pass() {
        let features = Features { mirror: true, ..Default::default() };
        let keys = [&[D][..], &[T, D], &[D], &[D, D], &[T, D, T]].map(TypeKey::from_tags);
        let pool = Group::new(Pool::build(&keys, 3));
        let guides = Group::new(Pool::build(&keys[1..], 8));
        let mix = |kernels: &[_]| Mix::new(kernels, features);
        let full = mix(&[(&independence::KERNEL, 0.1), (&lens::KERNEL, 1.0), (&multi_chain::KERNEL, 1.0)]);
        let lens_only = mix(&[(&independence::KERNEL, 0.1), (&lens::KERNEL, 1.0)]);
        for (mix, moved) in [(full, 5), (lens_only, 3)] {
            let work = Work::new(std::slice::from_ref(&pool), std::slice::from_ref(&guides), &mix, features);
            assert_eq!(work.passes.len() as u32, mix.perturbation_passes());
            let paths = |list: List| -> Vec<u32> {
                (0..list.count).map(|i| work.words[(list.offset + 2 * i) as usize]).collect()
            };
            for pass in &work.passes {
                let all: Vec<u32> = pass.iter().flat_map(|(_, list)| paths(*list)).chain(paths(work.idle)).collect();
                assert_eq!((all.len(), all.iter().collect::<BTreeSet<_>>().len()), (5, 5));
            }
            assert_eq!(work.idle.count, 5 - moved);
            // One list a kernel and one for the idle: nothing is repeated from pass to pass.
            assert_eq!(work.nodes_offset, 2 * 5);
            assert_eq!(work.words.len(), 2 * 5 + 3 * pool.pool.types.len());
        }
    }
    /// Whatever the types of a group's guides, every path is led to a node within its own group, with its median.
    #[test]
    fn guides_are_of_the_paths_own_group() {
        let features = Features { mirror: true, ..Default::default() };
        let mix = Mix::new(&[(&independence::KERNEL, 0.1), (&lens::KERNEL, 1.0)], features);
        let types = [&[D][..], &[D, D], &[T, D], &[D, T, D]].map(TypeKey::from_tags);
        let keys = |salt: usize| -> Vec<TypeKey> { (0..4 * 5).map(|i| types[(i * i + salt * i) % 7 % 4]).collect() };
        let groups = Groups::new(40, 4);
        let half = |half: usize| -> Vec<Group> {
            let keys = keys(half + 1);
            let of = |group: u32| {
                let keys = &keys[5 * group as usize..][..5];
                let pool = Pool::build(keys, groups.first(half, group));
                Group { similarity_median: group as f32, pool }
            };
            (0..4).map(of).collect()
        };
        let (moving, guides) = (half(0), half(1));
        let work = Work::new(&moving, &guides, &mix, features);
        let mut guided = 0;
        for (_, list) in work.passes.iter().flatten() {
            for entry in 0..list.count {
                let word = (list.offset + 2 * entry) as usize;
                let group = groups.of_path(work.words[word]);
                let node = (work.nodes_offset + NODE_WORDS * work.words[word + 1]) as usize;
                let [offset, count, median] = [0, 1, 2].map(|i| work.words[node + i]);
                assert!(count == 0 || (offset >= 5 * group && offset + count <= 5 * (group + 1)), "{offset} {count}");
                assert_eq!(f32::from_bits(median), group as f32);
                guided += u32::from(count > 0);
            }
        }
        assert!(guided > 50);
        // Within the list the types stay together.
        let (_, list) = work.passes[0][0];
        let path = |entry: u32| work.words[(list.offset + 2 * entry) as usize] as usize;
        let of: Vec<TypeKey> = (0..list.count).map(|entry| keys(1)[path(entry)]).collect();
        assert!(of.is_sorted());
    }
}
