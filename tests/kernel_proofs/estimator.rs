//! METHOD.md 4.3, D2: a kernel as an estimator. From one path x the mean over proposals y of h(y) C(y) / (C(x) T(x -> y))
//! is the integral of h C / C(x) over what the kernel can reach from x: known by quadrature in f64, apart from the shaders
//! (room.rs). It tells a wrong Jacobian, a lost factor, and a density that is not that of the proposals.
//!
//! A crossover has no density: it only exchanges what there is.

use emlt::ensemble::cuts::{Cut, CutEntry};
use emlt::ensemble::pool::TypeKey;
use emlt::gpu::layout::{ROW_COLOUR, ROW_PIXEL, ROW_VERTICES};
use emlt::kernels::{
    Family, Kernel, bidirectional, camera_sweep_end, caustic, difference, guided_bidirectional, guided_caustic,
    guided_lens, guided_multi_chain, jump, kept_lens, lens, light_sweep_start, multi_chain, walk_lens,
};
use emlt::reference::rng;
use glam::DVec2;

use crate::bench::{Bench, COLUMNS, FILM, Guides, HALF, PATHS, SEED, context};
use crate::room::{DIFFUSE, Held, Room, turn_to, turned};
use crate::sums::{Agreement, PROPOSALS, PUT, QUADRATURE, Sums};
use crate::{SPECULAR_SCENE, Z_LIMIT, scene_of};

/// Seed of the candidates among which x is chosen.
const CANDIDATES: u32 = 4001;
/// Passes over HALF copies of x.
pub const PASSES: u32 = 3;
/// Bounds of the rings in which steps on the film are told apart, in pixels, and turns, as distances of directions.
const STEPS: [f64; 6] = [0.5, 1.0, 2.0, 3.5, 5.0, 7.0];
const TURNS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];
/// Points of the quadrature in a part of a ring.
const POINTS: u32 = 2000;

/// Parts of rings, four a ring.
struct Rings(&'static [f64]);

impl Rings {
    fn count(&self) -> usize {
        4 * (self.0.len() - 1)
    }

    fn part(&self, d: DVec2) -> Option<usize> {
        let ring = self.0.windows(2).position(|b| d.length() >= b[0] && d.length() < b[1])?;
        Some(4 * ring + 2 * usize::from(d.x > 0.0) + usize::from(d.y > 0.0))
    }

    /// A point of a part, uniform in area, and that area.
    fn point(&self, part: usize, u: [f64; 2]) -> (DVec2, f64) {
        let [a, b] = [self.0[part / 4], self.0[part / 4 + 1]].map(|r| r * r);
        let r = (a + u[0] * (b - a)).sqrt();
        let phi = 0.5 * std::f64::consts::PI * u[1];
        let sign = |bit: usize| if part & bit != 0 { 1.0 } else { -1.0 };
        (r * DVec2::new(sign(2) * phi.cos(), sign(1) * phi.sin()), 0.25 * std::f64::consts::PI * (b - a))
    }
}

/// x as the first chain has it.
pub fn held(bench: &mut Bench, room: &Room) -> Held {
    let key = bench.keys(0, 1)[0];
    held_paths(bench, room, key, 1).remove(0)
}

/// The first paths, all of type `key`.
pub fn held_paths(bench: &mut Bench, room: &Room, key: TypeKey, count: u32) -> Vec<Held> {
    let edges = key.edges() as usize;
    let rows: Vec<_> = (0..edges).map(|i| bench.rows(ROW_VERTICES + 2 * i, 0, count)).collect();
    let pixels = bench.pixels(count);
    let tags: Vec<u32> = (0..edges as u32).map(|i| if i == 0 { DIFFUSE } else { key.tag_bits(i) }).collect();
    let held = |path: usize| {
        let point = |row: &Vec<[u32; 4]>| {
            let [triangle, u, v, _] = row[path];
            room.point(triangle as usize, f32::from_bits(u).into(), f32::from_bits(v).into())
        };
        let pixel = DVec2::new(pixels[path][0].into(), pixels[path][1].into());
        Held { tags: tags.clone(), points: rows.iter().map(point).collect(), pixel }
    };
    (0..count as usize).map(held).collect()
}

/// A lit candidate: its number, and the strategies of all.
pub struct Chosen {
    index: u32,
    strategies: Vec<[u32; 2]>,
}

impl Chosen {
    /// Number `n` of those that are `wanted`, in an order by chance.
    pub fn new(bench: &mut Bench, n: usize, wanted: impl Fn(TypeKey, DVec2) -> bool) -> Self {
        let (candidates, strategies) = bench.candidates(1 << 17, CANDIDATES);
        let mut chosen: Vec<u32> = (0..candidates.len() as u32)
            .filter(|i| {
                let c = &candidates[*i as usize];
                let pixel = DVec2::new(c.pixel[0].into(), c.pixel[1].into());
                c.weight() > 0.0 && c.key().is_some_and(|key| wanted(key, pixel))
            })
            .collect();
        chosen.sort_by_key(|i| rng::random_words(SEED, *i, 1, 0));
        assert!(n < chosen.len(), "only {} paths to choose from", chosen.len());
        Self { index: chosen[n], strategies }
    }

    /// Fills the first half with copies of it.
    pub fn fill(&self, bench: &mut Bench) {
        bench.fill(CANDIDATES, &self.strategies, &vec![self.index; HALF as usize]);
    }
}

/// What one kernel that keeps types is held to.
struct Case {
    kernel: &'static Kernel,
    /// Number of x among the candidates.
    x: usize,
    /// x lies within so many pixels of the film's border.
    border: f64,
    twin: Twin,
}

/// Ways to be wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Twin {
    None,
    /// A flag of the shader.
    Flag(&'static str),
    /// The cosine at the vertex that is connected, at which a sweep turns, or next to the camera is lost.
    Cosine,
}

/// Proposals of `kernel` from copies of x: what is told of each, and h C / T over C(x), 0 where one failed.
fn check(bench: &mut Bench, room: &Room, case: &Case) -> Agreement {
    let Case { kernel, x, border, twin } = *case;
    let features = bench.features;
    let light = kernel.family == Family::LightSide;
    let turns_of = |key: TypeKey| {
        let j = camera_sweep_end(key);
        (j + 1..key.edges()).filter(|&i| key.is_diffuse(i)).collect::<Vec<u32>>()
    };
    let film = DVec2::new(FILM[0].into(), FILM[1].into());
    let wanted = |key: TypeKey, p: DVec2| {
        let near = p.min(film - p).min_element() < border;
        (kernel.applies)(key, features) && near && (light || turns_of(key).len() <= 1) && key.edges() <= 5
    };
    let chosen = Chosen::new(bench, x, wanted);
    chosen.fill(bench);
    let key = bench.keys(0, 1)[0];
    let path = held(bench, room);
    let j = camera_sweep_end(key) as usize;
    let l = light_sweep_start(key, features).unwrap_or(0) as usize;
    let turns = if light { vec![] } else { turns_of(key) };
    // Two coordinates, or two pairs of them.
    let (first, second) =
        if light { (Rings(&TURNS), None) } else { (Rings(&STEPS), turns.first().map(|_| Rings(&TURNS))) };
    let parts = first.count() * second.as_ref().map_or(1, Rings::count);
    let truth = |d: DVec2, t: DVec2| match light {
        true => room.light_sweep(&path, l, d),
        false => {
            room.camera_sweep(&path, j, path.pixel + d, if turns.is_empty() { &[] } else { std::slice::from_ref(&t) })
        }
    };
    let of_x = truth(DVec2::ZERO, DVec2::ZERO);
    assert!(of_x > 0.0, "x itself is not found by {}: {}", kernel.name, key.string());
    let point = |part: usize, n: u32, block: u32| {
        let u = rng::random_words(SEED, n, part as u32, block).map(rng::uniform);
        let (d, area) = first.point(part % first.count(), [u[0], u[1]]);
        let turn = |rings: &Rings| rings.point(part / first.count(), [u[2], u[3]]);
        let (t, turn_area) = second.as_ref().map_or((DVec2::ZERO, 1.0), turn);
        (d, t, area * turn_area)
    };
    let points = if second.is_some() { POINTS / 5 } else { POINTS };
    let proposals = f64::from(PASSES * HALF);
    let put = HALF / parts as u32;
    let mut sums = Sums::new(parts, [points.into(), proposals, put.into()]);
    for part in 0..parts {
        for n in 0..points {
            let (d, t, area) = point(part, n, 7);
            sums.add(QUADRATURE, part, area / f64::from(points) * truth(d, t) / of_x);
        }
    }
    let log_c_row = if light { (ROW_PIXEL, 2) } else { (ROW_COLOUR, 3) };
    let log_c_of_x = f64::from(f32::from_bits(bench.rows(log_c_row.0, 0, 1)[0][log_c_row.1]));
    for pass in 0..=PASSES {
        chosen.fill(bench);
        let (uniform, paths) = bench.list(kernel, HALF, Guides::Other);
        // In place of proposals of a first pass, points that are even over every part: all that is made is weighed by
        // both densities together, so that no weight is large where the kernel's own is small.
        let kind = if pass == 0 { PUT } else { PROPOSALS };
        let mut flags = vec!["probe", "probe_density"];
        if kind == PUT {
            flags.push("probe_back");
            put_points(bench, &path, if light { l + 1 } else { 0 }, turns.first().copied(), |path| {
                let (d, t, _) = point(path % parts, (path / parts) as u32, 8);
                (d, t)
            });
        }
        flags.extend(if let Twin::Flag(flag) = twin { Some(flag) } else { None });
        bench.passes(kernel, &flags, uniform, pass..pass + 1);
        let records = bench.records(paths.len() as u32);
        let made = held_paths(bench, room, key, HALF);
        let used = paths.iter().map(|path| *path as usize);
        let used = used.zip(&records).filter(|(path, r)| {
            let rest = kind == PUT && *path >= parts * put as usize;
            r[0] > -1e29 && r[3] > -1e29 && !rest
        });
        for (y, record) in used.map(|(path, record)| (&made[path], record)) {
            let turn = |from: usize, to: usize| turn_to(path.direction(from, to), y.direction(from, to));
            let d = if light { turn(l, l + 1) } else { y.pixel - path.pixel };
            let b = match (&second, turns.first()) {
                (Some(rings), Some(&i)) => rings.part(turn(i as usize, i as usize - 1)),
                _ => Some(0),
            };
            let (Some(a), Some(b)) = (first.part(d), b) else { continue };
            let part = a + first.count() * b;
            let (.., area) = point(part, 0, 7);
            let mut c = (f64::from(record[3]) - log_c_of_x).exp();
            let density = c / f64::from(record[0]).exp();
            if twin == Twin::Cosine {
                let last = &y.points[y.edges() - 1];
                let at = turns.first().map_or(j, |i| *i as usize);
                c /= if light {
                    last.ng.dot(room.towards_eye(last))
                } else {
                    y.points[at].ns.dot(y.direction(at, at - 1))
                }
                .abs();
            }
            sums.add(kind, part, c / (proposals * density + f64::from(put) / area));
        }
    }
    sums.agreement(&format!("{} from {} {x}, {twin:?}", kernel.name, key.string()))
}

/// Where a pass with `probe_back` finds them, leaves pixels or directions to go to, by coordinates from `path`: the first
/// of the light's vertices to find (`found`, 0 for a sweep from the camera), and the vertex that a sweep turns at.
fn put_points(
    bench: &mut Bench,
    path: &Held,
    found: usize,
    turns_at: Option<u32>,
    point: impl Fn(usize) -> (DVec2, DVec2),
) {
    let mut rows: Vec<(usize, Vec<[f32; 4]>)> = vec![(ROW_PIXEL, vec![]), (0, vec![]), (0, vec![])];
    let full = |v: glam::DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
    for n in 0..HALF as usize {
        let (d, t) = point(n);
        if found > 0 {
            let to = path.points[found - 1].position + turned(path.direction(found - 1, found), d);
            rows[1].0 = ROW_VERTICES + 2 * found + 1;
            rows[1].1.push(full(to));
        } else {
            let pixel = path.pixel + d;
            rows[0].1.push([pixel.x as f32, pixel.y as f32, 0.0, 0.0]);
        }
        if let Some(i) = turns_at.map(|i| i as usize) {
            // A direction, as from the origin.
            rows[1].0 = ROW_VERTICES + 2 * i + 1;
            rows[1].1.push([0.0; 4]);
            rows[2].0 = ROW_VERTICES + 2 * i - 1;
            rows[2].1.push(full(turned(path.direction(i, i - 1), t)));
        }
    }
    for (row, columns) in rows.iter().filter(|(_, columns)| !columns.is_empty()) {
        let offset = 16 * (*row as u64 * u64::from(COLUMNS) + u64::from(PATHS));
        bench.run.set_chains(offset, bytemuck::cast_slice(columns));
    }
}

/// The case of a bidirectional mutation: `added` vertices in place of one, all matt, between matt ends.
fn check_stretch(bench: &mut Bench, room: &Room, kernel: &Kernel, added: u32, twin: Twin) -> Agreement {
    let matt = |key: TypeKey| {
        let k = key.edges();
        (3..k - 1).rev().find(|&i| (i - 1..=i + 1).all(|i| key.is_diffuse(i)))
    };
    let chosen = Chosen::new(bench, 0, |key, _| key.edges() > 4 && key.edges() <= 6 && matt(key).is_some());
    chosen.fill(bench);
    let key = bench.keys(0, 1)[0];
    let path = held(bench, room);
    let first = matt(key).unwrap() as usize;
    let (before, after) = (first - 1, first + 1);
    let back = (path.points[before - 1].position - path.points[before].position).normalize();
    let triangles = room.triangles();
    // Where the last new vertex lies, and the material of the first.
    let part = |new: &[crate::room::Point]| 8 * new[new.len() - 1].triangle + new[0].material;
    const WALKS: u32 = 200_000;
    let proposals = f64::from(PASSES * HALF);
    let mut sums = Sums::new(8 * triangles, [WALKS.into(), proposals, 0.0]);
    for n in 0..WALKS {
        let u = [0, 1].map(|block| rng::random_words(SEED, n, block, 8).map(rng::uniform));
        let (mut at, mut from, mut density) = (path.points[before], back, 1.0);
        let mut new = Vec::new();
        for u in &u[..added as usize] {
            let Some((found, pdf)) = room.scattered(&at, from, [u[0], u[1]]) else { break };
            from = (at.position - found.position).normalize();
            (at, density) = (found, density * pdf);
            new.push(found);
        }
        if new.len() == added as usize {
            let value = room.stretch(&path, before, after, &new) / density;
            sums.add(QUADRATURE, part(&new), value / f64::from(WALKS));
        }
    }
    bench.publish_guides();
    let tags: u128 = (1..key.edges()).filter(|i| *i != first as u32).enumerate().fold(0, |tags, (n, i)| {
        let place = if n as u32 + 1 < first as u32 { n as u32 } else { n as u32 + added };
        tags | u128::from(key.tag_bits(i)) << (2 * place)
    });
    let wanted = TypeKey::new(key.edges() + added - 1, tags);
    for pass in 1..=PASSES {
        chosen.fill(bench);
        let words: Vec<u32> = (0..HALF)
            .flat_map(|path| {
                let place = rng::random_words(SEED, path, pass, 9)[0] % HALF;
                let guide = [HALF + place, bench.guides.key_at(place).edges()];
                let cut = Cut { added, light_new: path % (added + 1), first: first as u32, deleted: 1 };
                CutEntry { path, cut, guide }.words()
            })
            .collect();
        bench.run.set_lists(&words);
        let uniform = bench.cut_uniform(HALF as usize);
        bench.passes(kernel, &["probe", "probe_density"], uniform, pass..pass + 1);
        let records = bench.lens_records(HALF);
        let keys = bench.keys(0, HALF);
        let made = held_paths(bench, room, wanted, HALF);
        for (path, record) in records.iter().enumerate() {
            if record.log_ratio < -1e29 || keys[path] != wanted {
                continue;
            }
            let new = &made[path].points[first..first + added as usize];
            let mut value = f64::from(record.log_ratio).exp();
            if twin == Twin::Cosine {
                value /= new[0].ns.dot(made[path].direction(first, first - 1)).abs();
            }
            sums.add(PROPOSALS, part(new), value / proposals);
        }
    }
    sums.agreement(&format!("{} from {}, {added} for 1, {twin:?}", kernel.name, key.string()))
}

/// Proposals of every kernel that has a density, 196,608 from each of one to three paths. Every bin has an error
/// probability of 1e-6, all together below 3e-3.
#[test]
fn kernels_estimate_what_they_can_reach() {
    let context = context();
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    let room = Room::new(&scene_of(SPECULAR_SCENE), &bench.data);
    let case = |kernel, x| Case { kernel, x, border: f64::INFINITY, twin: Twin::None };
    let cases = [
        case(&lens::KERNEL, 0),
        case(&lens::KERNEL, 1),
        Case { border: 4.0, ..case(&lens::KERNEL, 2) },
        case(&guided_lens::KERNEL, 0),
        Case { border: 4.0, ..case(&guided_lens::KERNEL, 2) },
        case(&walk_lens::KERNEL, 1),
        case(&kept_lens::KERNEL, 1),
        case(&difference::KERNEL, 1),
        case(&jump::KERNEL, 1),
        case(&multi_chain::KERNEL, 0),
        case(&guided_multi_chain::KERNEL, 0),
        case(&caustic::KERNEL, 0),
        case(&caustic::KERNEL, 1),
        case(&guided_caustic::KERNEL, 0),
        case(&guided_caustic::KERNEL, 1),
    ];
    let mut broken = Vec::new();
    for case in &cases {
        let agreement = check(&mut bench, &room, case);
        if !agreement.holds(Z_LIMIT) {
            broken.push(case.kernel.name);
        }
    }
    let mut twins = Vec::new();
    for case in [
        Case { border: 4.0, twin: Twin::Flag("twin_redraw"), ..case(&guided_lens::KERNEL, 2) },
        Case { twin: Twin::Cosine, ..case(&lens::KERNEL, 1) },
        Case { twin: Twin::Cosine, ..case(&multi_chain::KERNEL, 0) },
        Case { twin: Twin::Cosine, ..case(&caustic::KERNEL, 0) },
    ] {
        if check(&mut bench, &room, &case).worst < Z_LIMIT {
            twins.push((case.kernel.name, case.twin));
        }
    }
    for kernel in [&bidirectional::KERNEL, &guided_bidirectional::KERNEL] {
        for added in [1, 2] {
            if !check_stretch(&mut bench, &room, kernel, added, Twin::None).holds(Z_LIMIT) {
                broken.push(kernel.name);
            }
        }
        if check_stretch(&mut bench, &room, kernel, 1, Twin::Cosine).worst < Z_LIMIT {
            twins.push((kernel.name, Twin::Cosine));
        }
    }
    assert!(broken.is_empty(), "{broken:?}");
    assert!(twins.is_empty(), "twins pass: {twins:?}");
}
