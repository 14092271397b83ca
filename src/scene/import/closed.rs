//! Whether triangles enclose a volume, which decides if glass without KHR_materials_volume refracts.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

/// Vertices closer than this share of the largest coordinate are one vertex: seams computed in f32 differ by some ulps.
const WELD: f64 = 1e-6;

/// True if every edge, after welding vertices by position, belongs to exactly two triangles.
/// Triangles that welding collapses do not count (the poles of a sphere).
pub fn is_closed(triangles: impl Iterator<Item = [DVec3; 3]> + Clone) -> bool {
    let extent = triangles.clone().flatten().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    if !extent.is_finite() {
        return false;
    }
    let mut weld = Weld::new(extent);
    let mut uses: HashMap<[u32; 2], u32> = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|p| weld.vertex(p));
        if a == b || b == c || c == a {
            continue;
        }
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *uses.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    !uses.is_empty() && uses.values().all(|&n| n == 2)
}

/// Vertices found so far, in a grid of cells a few times wider than the distance at which two are one.
struct Weld {
    distance: f64,
    cells: HashMap<I64Vec3, Vec<u32>>,
    vertices: Vec<DVec3>,
}

impl Weld {
    fn new(extent: f64) -> Self {
        // Any positive distance will do when all positions are zero.
        let distance = if extent > 0.0 { WELD * extent } else { 1.0 };
        Self { distance, cells: HashMap::new(), vertices: Vec::new() }
    }

    fn cell(&self, p: DVec3) -> I64Vec3 {
        (p / (4.0 * self.distance)).floor().as_i64vec3()
    }

    /// The number of the vertex at `p`, a new one if none is near.
    fn vertex(&mut self, p: DVec3) -> u32 {
        let (low, high) = (self.cell(p - self.distance), self.cell(p + self.distance));
        // One cell or few; eight near a corner of the grid.
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let near = |&&v: &&u32| (self.vertices[v as usize] - p).abs().max_element() <= self.distance;
                    if let Some(&v) = self.cells.get(&I64Vec3::new(x, y, z)).and_then(|cell| cell.iter().find(near)) {
                        return v;
                    }
                }
            }
        }
        let v = self.vertices.len() as u32;
        self.vertices.push(p);
        self.cells.entry(self.cell(p)).or_default().push(v);
        v
    }
}
