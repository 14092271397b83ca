//! What subpath mutations make anew, and who guides them: drawn on the host from the path's own random numbers, so that the
//! dispatch list can be sorted by it.

use rayon::prelude::*;

use super::pool::{NodeRange, Pool, TypeKey, TypeNode};
use super::runs::merged;
use crate::kernels::Kernel;
use crate::reference::rng;
use crate::scene::Features;

/// Dimension block from which the host draws.
const DIMENSION_PLAN: u32 = 0xffff;
/// Share of the lens's subpaths with two diffuse vertices, in scenes with specular ones.
const LONG_SHARE: f64 = 0.25;

/// What is made anew: vertices from `first` on, of which so many are diffuse. What comes out has the same plan as the path
/// that it was drawn for, so that the way back is drawn with the same probability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Plan {
    pub first: u32,
    pub diffuse: u32,
}

impl Plan {
    /// Up to the diffuse vertex number `diffuse` from the camera, if its neighbour can be connected to. Where there is none
    /// at all, all of the path: by specular vertices to the light, and for 1 alone.
    pub fn from_camera(key: TypeKey, diffuse: u32) -> Option<Self> {
        if diffuse == 1 && !(1..key.edges()).any(|i| key.is_diffuse(i)) {
            return Some(Self { first: 0, diffuse: 0 });
        }
        let first = (1..key.edges()).rev().filter(|i| key.is_diffuse(*i)).nth(diffuse as usize - 1)?;
        (first == 1 || key.is_diffuse(first - 1)).then_some(Self { first, diffuse })
    }

    /// From the last diffuse vertex before the one that the camera sees, or from the light.
    pub fn from_light(key: TypeKey, features: Features) -> Option<Self> {
        let last = key.edges() - 1;
        if last == 0 || !key.is_diffuse(last) {
            return None;
        }
        let l = (1..last).rev().find(|&i| key.is_diffuse(i)).unwrap_or(0);
        // Nothing is traced from a point of the sky.
        (l > 0 || !features.sky).then_some(Self { first: l + 1, diffuse: 1 })
    }
}

/// One entry of the pass `subpath`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanEntry {
    pub path: u32,
    pub plan: Plan,
    /// Column of the first guide of a node, and how many guides that has; no guides, and the plain kernel, for 0.
    pub guides: [u32; 2],
}

impl PlanEntry {
    /// As `take_plan` in shaders/kernels/subpath.wesl reads it.
    pub fn words(self) -> [u32; 4] {
        [self.path, self.plan.first | self.plan.diffuse << 8, self.guides[0], self.guides[1]]
    }
}

/// The work of one subpath pass over a half.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlanList {
    /// Sorted so that neighbours trace alike.
    pub entries: Vec<PlanEntry>,
    /// The entries, then (path, 0) for every path that has no plan and rests.
    pub words: Vec<u32>,
    pub resting: u32,
    pub resting_offset: u32,
}

impl PlanList {
    /// Draws a plan for every path of every group with `random(path, dimension)`. A group is its moving half, the frozen
    /// one, and the column of the latter's first guide.
    pub fn draw(
        kernel: &Kernel,
        features: Features,
        groups: &[(&Pool, &Pool, u32)],
        random: impl Fn(u32, u32) -> [u32; 4] + Sync,
    ) -> Self {
        let from_light = kernel.flags.contains(&"light_side");
        let of_group = |&(moving, frozen, guides_first): &(&Pool, &Pool, u32)| {
            let mut entries: Vec<(TypeKey, PlanEntry)> = Vec::with_capacity(moving.order.len());
            let mut resting: Vec<u32> = Vec::new();
            for TypeNode { key, range } in &moving.types {
                let plans = match from_light {
                    true => [Plan::from_light(*key, features); 2],
                    false => [1, 2].map(|diffuse| Plan::from_camera(*key, diffuse)),
                };
                let caustics = plans[0].filter(|_| kernel.guided).map(|plan| Caustics::of(frozen, plan, features));
                for &path in moving.members(*range) {
                    let u = random(path, DIMENSION_PLAN).map(rng::uniform);
                    let Some(plan) = plans[usize::from(features.mirror && u[0] < LONG_SHARE)] else {
                        resting.extend([path, 0]);
                        continue;
                    };
                    let node = caustics.as_ref().and_then(|caustics| caustics.node(u[1]));
                    let guides = node.map_or([0; 2], |node| [guides_first + node.offset, node.count]);
                    entries.push((*key, PlanEntry { path, plan, guides }));
                }
            }
            // Types are in order already.
            entries.sort_by_key(|(_, entry)| entry.plan);
            (entries, resting)
        };
        let (entries, resting): (Vec<_>, Vec<_>) = groups.par_iter().map(of_group).unzip();
        let (entries, resting) = (merged(&entries, |(key, entry)| (entry.plan, *key)), resting.concat());
        let mut list = Self { entries: entries.into_iter().map(|(_, entry)| entry).collect(), ..Self::default() };
        list.words.extend(list.entries.iter().flat_map(|entry| entry.words()));
        list.resting_offset = list.words.len() as u32;
        list.resting = resting.len() as u32 / 2;
        list.words.extend(resting);
        list
    }
}

/// Types of a frozen half whose caustics leave the same vertex as a plan: a function of what the plan keeps, and of that
/// half, alone.
struct Caustics {
    nodes: Vec<NodeRange>,
    members: u32,
}

impl Caustics {
    fn of(frozen: &Pool, plan: Plan, features: Features) -> Self {
        let leaves = |key: TypeKey| Plan::from_light(key, features) == Some(plan) && !key.is_diffuse(plan.first);
        let nodes: Vec<_> = frozen.types.iter().filter(|node| leaves(node.key)).map(|node| node.range).collect();
        let members = nodes.iter().map(|node| node.count).sum();
        Self { nodes, members }
    }

    /// The node of a member drawn evenly from all.
    fn node(&self, u: f64) -> Option<NodeRange> {
        let mut member = (u * f64::from(self.members)) as u32;
        self.nodes.iter().copied().find(|node| {
            let found = member < node.count;
            member -= if found { 0 } else { node.count };
            found
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{self, Diffuse as D, Transmission as T};
    use crate::kernels::{guided_light_subpath, lens_subpath};

    #[test]
    fn plans_keep_what_can_be_connected_to() {
        type Case<'a> = (&'a [Tag], [Option<u32>; 2], Option<u32>);
        // Tags from the light; first vertices with one and two diffuse ones from the camera, and from the light.
        let cases: [Case; 8] = [
            (&[], [Some(0), None], None),              // L E
            (&[T], [Some(0), None], None),             // L S E
            (&[D], [Some(1), None], Some(1)),          // L D E
            (&[D, D], [Some(2), Some(1)], Some(2)),    // L D D E
            (&[D, T, T], [Some(1), None], None),       // L D S S E
            (&[T, D], [None, None], Some(1)),          // L S D E
            (&[D, T, D], [None, Some(1)], Some(2)),    // L D S D E
            (&[D, D, T, D, T], [None, Some(2)], None), // L D D S D S E
        ];
        for (tags, from_camera, from_light) in cases {
            let key = TypeKey::from_tags(tags);
            let plans = [1, 2].map(|n| Plan::from_camera(key, n));
            assert_eq!(plans.map(|plan| plan.map(|p| p.first)), from_camera, "{tags:?}");
            assert_eq!(Plan::from_light(key, Features::default()).map(|p| p.first), from_light, "{tags:?}");
            let under_a_sky = Plan::from_light(key, Features { sky: true, ..Features::default() });
            assert_eq!(under_a_sky.map(|p| p.first), from_light.filter(|first| *first > 1), "{tags:?}");
        }
    }

    /// Every path once; guides are caustics that leave the vertex which the plan keeps.
    #[test]
    fn lists_hold_every_path_and_caustics_guide() {
        let [plain, caustic, glass, longer] = [&[D][..], &[T, D], &[D, T], &[D, T, D]].map(TypeKey::from_tags);
        let moving = Pool::build(&[plain, caustic, glass, longer].repeat(64), 0);
        let frozen = Pool::build(&[longer, caustic, plain, caustic], 256);
        let features = Features { mirror: true, ..Features::default() };
        let random = |path, dimension| rng::random_words(1, path, 2, dimension);
        for (kernel, resting) in [(&guided_light_subpath::KERNEL, 64), (&lens_subpath::KERNEL, 64)] {
            let list = PlanList::draw(kernel, features, &[(&moving, &frozen, 256)], random);
            let rest = &list.words[list.resting_offset as usize..];
            assert_eq!(list.words.len(), 4 * list.entries.len() + 2 * list.resting as usize);
            assert!(list.resting >= resting);
            let mut paths: Vec<u32> = list.entries.iter().map(|entry| entry.path).collect();
            paths.extend(rest.iter().step_by(2));
            paths.sort_unstable();
            assert_eq!(paths, (0..256).collect::<Vec<_>>());
            for PlanEntry { plan, guides: [column, count], .. } in list.entries {
                let guided: Vec<u32> = (column..column + count).map(|c| frozen.order[c as usize - 256] - 256).collect();
                let expected: &[u32] = if plan.first == 1 { &[1, 3] } else { &[0] };
                assert!(guided.is_empty() || (kernel.guided && guided == expected), "{plan:?}: {guided:?}");
            }
        }
    }
}
