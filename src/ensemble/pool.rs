//! The pool: one half of an ensemble (of one group), sorted by path type into flat index buffers.
//!
//! The supplement (section 3) describes a tree of three levels: all paths, paths of one length, paths of one
//! type string. Here every node of that tree is a range of one sorted array, [`Pool::order`]. The same order
//! serves as guide pool when the other half moves and as dispatch list when this half moves.

pub use super::type_key::{MAX_EDGES, Tag, TypeKey, abbreviated};

/// A range of [`Pool::order`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NodeRange {
    pub offset: u32,
    pub count: u32,
}

impl NodeRange {
    /// How many guides a look-up for `guides` of them returns: all members if there are no more.
    pub fn guide_count(self, guides: u32) -> u32 {
        guides.min(self.count)
    }

    fn indices(self) -> std::ops::Range<usize> {
        self.offset as usize..(self.offset + self.count) as usize
    }
}

/// The paths of one length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LengthNode {
    pub edges: u32,
    pub range: NodeRange,
}

/// The paths of one type string.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TypeNode {
    pub key: TypeKey,
    pub range: NodeRange,
}

/// The deterministic look-up of the supplement (section 3): member number (id + o) mod count of a node, o = 1..=M.
///
/// Computed as ((id mod count) + o) mod count: id + o may pass 2^32, and since 2^32 is no multiple of `count` in
/// general the wrapped sum would jump to another place, so that a set could hold the same member twice.
/// With o <= count <= 2^31 the sum cannot wrap.
///
/// `id` is a function of path index and mutation number only (METHOD.md 3.2), one for all look-ups of a mutation.
pub fn select(id: u32, o: u32, count: u32) -> u32 {
    debug_assert!(count > 0 && count <= 1 << 31 && o <= count);
    ((id % count) + o) % count
}

/// Types by number, in the order in which they are met, with how often that was.
#[derive(Default)]
struct Numbers {
    counts: Vec<(TypeKey, u32)>,
    /// Open addressing: 1 + number, or 0; a power of two of them, at least twice as many as types.
    table: Vec<u32>,
}

impl Numbers {
    /// The number of a type, met once more.
    fn count(&mut self, key: TypeKey) -> u32 {
        if self.table.len() <= 2 * self.counts.len() {
            self.grow();
        }
        let place = self.place(key);
        if self.table[place] == 0 {
            self.counts.push((key, 0));
            self.table[place] = self.counts.len() as u32;
        }
        let number = self.table[place] - 1;
        self.counts[number as usize].1 += 1;
        number
    }

    /// Where a type is in the table, or would be.
    fn place(&self, key: TypeKey) -> usize {
        let mask = self.table.len() - 1;
        // Multiplied by 2^64 over the golden ratio, whose upper bits depend on all of the key.
        let folded = (key.bits() >> 64) as u64 ^ key.bits() as u64;
        let mut place = (folded.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize & mask;
        while self.table[place] != 0 && self.counts[self.table[place] as usize - 1].0 != key {
            place = (place + 1) & mask;
        }
        place
    }

    fn grow(&mut self) {
        self.table = vec![0; (4 * self.table.len()).max(256)];
        for number in 0..self.counts.len() {
            let place = self.place(self.counts[number].0);
            self.table[place] = number as u32 + 1;
        }
    }
}

/// One half of an ensemble, sorted by type.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pool {
    /// Path indices, sorted by key, then by index.
    pub order: Vec<u32>,
    /// One node for each length present, shortest first.
    pub lengths: Vec<LengthNode>,
    /// One node for each type string present, in the order of keys.
    pub types: Vec<TypeNode>,
}

impl Pool {
    /// Sorts paths `first_index..first_index + keys.len()`, whose keys are given in the order of their indices.
    ///
    /// A counting sort: types are numbered as they are met, counted, put in order, and paths written behind one another.
    pub fn build(keys: &[TypeKey], first_index: u32) -> Self {
        let mut numbers = Numbers::default();
        let number_of: Vec<u32> = keys.iter().map(|key| numbers.count(*key)).collect();
        let mut in_order: Vec<u32> = (0..numbers.counts.len() as u32).collect();
        in_order.sort_unstable_by_key(|number| numbers.counts[*number as usize].0);

        let mut pool = Self { order: vec![0; keys.len()], ..Self::default() };
        let mut next = vec![0; in_order.len()];
        let mut offset = 0;
        for number in in_order {
            let (key, count) = numbers.counts[number as usize];
            pool.types.push(TypeNode { key, range: NodeRange { offset, count } });
            match pool.lengths.last_mut() {
                Some(node) if node.edges == key.edges() => node.range.count += count,
                _ => pool.lengths.push(LengthNode { edges: key.edges(), range: NodeRange { offset, count } }),
            }
            next[number as usize] = offset;
            offset += count;
        }
        for (index, number) in (first_index..).zip(number_of) {
            let place = &mut next[number as usize];
            pool.order[*place as usize] = index;
            *place += 1;
        }
        pool
    }

    /// The node that guides a path of type `key`: the paths of its type, or of its length if there are none of its
    /// type (the supplement's backtracking, section 3), or `None` if there is none of its length either.
    ///
    /// Exactness asks only that x and y use the same rule (METHOD.md 3.2): every look-up goes through here.
    pub fn node(&self, key: TypeKey) -> Option<NodeRange> {
        self.type_node(key).or_else(|| self.length_node(key.edges()))
    }

    /// The paths of exactly this type, if there are any.
    pub fn type_node(&self, key: TypeKey) -> Option<NodeRange> {
        let at = self.types.binary_search_by_key(&key, |node| node.key).ok()?;
        Some(self.types[at].range)
    }

    /// The paths of this length, if there are any.
    pub fn length_node(&self, edges: u32) -> Option<NodeRange> {
        let at = self.lengths.binary_search_by_key(&edges, |node| node.edges).ok()?;
        Some(self.lengths[at].range)
    }

    /// The type of the path at `order[place]`.
    pub fn key_at(&self, place: u32) -> TypeKey {
        let after = self.types.partition_point(|node| node.range.offset <= place);
        self.types[after - 1].key
    }

    /// Path indices of a node.
    pub fn members(&self, node: NodeRange) -> &[u32] {
        &self.order[node.indices()]
    }

    /// Path indices of the guides that `id` selects in a node: min(M, count) different members.
    pub fn select(&self, node: NodeRange, id: u32, guides: u32) -> impl Iterator<Item = u32> + '_ {
        let members = self.members(node);
        (1..=node.guide_count(guides)).map(move |o| members[select(id, o, node.count) as usize])
    }

    /// What one kernel has to do in a type-keeping pass over this half, guided by the pool of the other half.
    ///
    /// Types are frozen during these passes, so lists and nodes may depend on them (METHOD.md C6). Paths in
    /// `idle` are credited weight 1 to their state for the pass; without it the image is biased (C6a).
    pub fn dispatch_list(&self, applicable: impl Fn(TypeKey) -> bool, guides: &Pool) -> WorkList {
        let mut list = WorkList::default();
        for node in &self.types {
            let members = self.members(node.range);
            if applicable(node.key) {
                let guide_node = list.nodes.len() as u32;
                let range = guides.node(node.key).unwrap_or(NodeRange { offset: 0, count: 0 });
                list.nodes.push([range.offset, range.count]);
                list.entries.extend(members.iter().map(|&path| [path, guide_node]));
            } else {
                list.idle.extend_from_slice(members);
            }
        }
        list
    }
}

/// The work of one kernel in one type-keeping pass, as the shader reads it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WorkList {
    /// Path index and index into `nodes`, sorted by type so that neighbouring invocations take the same branches.
    pub entries: Vec<[u32; 2]>,
    /// Offset and count into the guides' order, one for each applicable type; count 0 if nothing guides that type.
    pub nodes: Vec<[u32; 2]>,
    /// Paths the kernel does not apply to.
    pub idle: Vec<u32>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use Tag::{Diffuse as D, Reflection as R, Transmission as T};

    /// SplitMix64: small, fixed, good enough to shuffle keys.
    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn random_keys(count: usize, longest_edges: u32, seed: u64) -> Vec<TypeKey> {
        let mut state = seed;
        let mut draw = |range: u64| random(&mut state) % range;
        (0..count)
            .map(|_| {
                let edges = 1 + draw(u64::from(longest_edges)) as u32;
                TypeKey::new(edges, (1..edges).fold(0, |tags, _| tags << 2 | u128::from(draw(3))))
            })
            .collect()
    }

    #[test]
    fn small_pool_has_the_ranges_one_expects() {
        let keys = [&[D, R][..], &[D], &[D, R], &[T, R], &[D]].map(TypeKey::from_tags);
        let pool = Pool::build(&keys, 10);
        assert_eq!(pool.order, [11, 14, 10, 12, 13]);
        assert_eq!(pool.node(keys[1]), Some(NodeRange { offset: 0, count: 2 }));
        assert_eq!(pool.node(keys[0]), Some(NodeRange { offset: 2, count: 2 }));
        assert_eq!(pool.node(keys[3]), Some(NodeRange { offset: 4, count: 1 }));
        // No path of this type: back to all paths of its length.
        assert_eq!(pool.node(TypeKey::from_tags(&[D, D])), Some(NodeRange { offset: 2, count: 3 }));
        assert_eq!(pool.node(TypeKey::from_tags(&[D, D, D])), None);
    }

    #[test]
    fn empty_and_single_pools() {
        let key = TypeKey::from_tags(&[D]);
        let empty = Pool::build(&[], 0);
        assert_eq!((&empty, empty.node(key)), (&Pool::default(), None));
        let single = Pool::build(&[key], 7);
        let node = single.node(key).unwrap();
        assert_eq!((single.members(node), node.guide_count(16)), (&[7][..], 1));
        assert_eq!(single.select(node, u32::MAX, 16).collect::<Vec<_>>(), [7]);
    }

    #[test]
    fn counting_sort_agrees_with_a_stable_comparison_sort() {
        // Few distinct keys as in a scene, and many as nowhere.
        for (longest_edges, seed) in [(4, 1), (MAX_EDGES, 2)] {
            let keys = random_keys(100_000, longest_edges, seed);
            let pool = Pool::build(&keys, 500);
            let mut expected: Vec<u32> = (500..100_500).collect();
            expected.sort_by_key(|&index| keys[index as usize - 500]);
            assert_eq!(pool.order, expected);
            for node in &pool.types {
                assert!(pool.members(node.range).iter().all(|&index| keys[index as usize - 500] == node.key));
                assert_eq!(pool.node(node.key), Some(node.range));
            }
            for node in &pool.lengths {
                let of_length = |&index: &u32| keys[index as usize - 500].edges() == node.edges;
                assert!(pool.members(node.range).iter().all(of_length));
            }
            let covered = |ranges: Vec<NodeRange>| ranges.iter().map(|range| range.count).sum::<u32>();
            assert_eq!(covered(pool.types.iter().map(|node| node.range).collect()), 100_000);
            assert_eq!(covered(pool.lengths.iter().map(|node| node.range).collect()), 100_000);
        }
    }

    #[test]
    fn a_set_never_holds_a_member_twice_even_where_the_id_wraps() {
        for count in [1, 2, 3, 7, 1000] {
            for id in [0, 5, u32::MAX - 3, u32::MAX] {
                let guides = count.min(16);
                let mut set: Vec<u32> = (1..=guides).map(|o| select(id, o, count)).collect();
                assert!(set.windows(2).all(|pair| pair[1] == (pair[0] + 1) % count));
                set.sort_unstable();
                set.dedup();
                assert_eq!(set.len() as u32, guides);
            }
        }
        assert_eq!((1..=3).map(|o| select(9, o, 5)).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn dispatch_lists_hold_every_path_once_and_the_guides_node() {
        let [short, glossy, clear] = [&[D][..], &[D, R], &[D, T]].map(TypeKey::from_tags);
        let moving = Pool::build(&[glossy, short, clear, glossy], 0);
        let guides = Pool::build(&[clear, clear], 4);
        let list = moving.dispatch_list(|key| key != short, &guides);
        assert_eq!(list.entries, [[0, 0], [3, 0], [2, 1]]);
        assert_eq!(list.nodes, [[0, 2], [0, 2]]);
        assert_eq!(list.idle, [1]);
        let unguided = moving.dispatch_list(|key| key == short, &guides);
        assert_eq!((unguided.entries, unguided.nodes, unguided.idle), (vec![[1, 0]], vec![[0, 0]], vec![0, 3, 2]));
    }

    /// Prints the cost a path for growing pools of 40 keys: run with `--ignored --nocapture`.
    #[test]
    #[ignore = "a timing, not a check"]
    fn cost_a_path_does_not_grow_with_the_pool() {
        for count in [10_000, 100_000, 1_000_000] {
            let keys = random_keys(count, 4, 5);
            let start = std::time::Instant::now();
            let pool = Pool::build(&keys, 0);
            let ns = start.elapsed().as_nanos() as f64 / count as f64;
            println!("{count} paths, {} keys: {ns:.1} ns a path", pool.types.len());
        }
    }
}
