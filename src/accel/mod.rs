//! The acceleration structure: a compressed wide BVH over the triangles, and the triangles in its leaf order.

use std::time::Duration;

use glam::Vec3;
use obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris, triangle::Triangle};

/// Deepest traversal stack the shaders hold (`STACK_SIZE` in shaders/geometry/trace.wesl).
pub const STACK_SIZE: usize = 24;

/// CWBVH nodes as words (20 each), and the source triangle of every leaf entry.
#[derive(Debug, Clone)]
pub struct Accel {
    pub nodes: Vec<[u32; 20]>,
    /// `order[i]` is the input triangle at leaf position `i`; shaders know triangles by leaf position.
    pub order: Vec<u32>,
}

/// Builds the structure over triangles given by their corners.
pub fn build(corners: &[[Vec3; 3]]) -> crate::Result<Accel> {
    let triangles: Vec<Triangle> =
        corners.iter().map(|c| Triangle { v0: c[0].into(), v1: c[1].into(), v2: c[2].into() }).collect();
    // Splitting triangles would repeat them in several leaves; one leaf entry a triangle keeps ids unique.
    let params = BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() };
    let bvh = build_cwbvh_from_tris(&triangles, params, &mut Duration::default());
    let depth = depth_of(&bvh.nodes);
    if depth > STACK_SIZE {
        return Err(crate::Error::input(format!(
            "the geometry needs a search tree {depth} levels deep and {STACK_SIZE} are supported: it has many overlapping or stacked triangles, remove duplicates"
        )));
    }
    Ok(Accel { nodes: bytemuck::cast_slice(&bvh.nodes).to_vec(), order: bvh.primitive_indices })
}

fn depth_of(nodes: &[obvhs::cwbvh::node::CwBvhNode]) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0usize, 1usize)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[index];
        for child in 0..node.imask.count_ones() {
            stack.push((node.child_base_idx as usize + child as usize, depth + 1));
        }
    }
    deepest
}
