//! The kernels that make one side of a path anew, through as many specular vertices as there are: log ratios there and
//! back (METHOD.md 4.1, A1), stationarity (4.4, S1), and what they estimate (4.3, D2).

use emlt::ensemble::pool::TypeKey;
use emlt::ensemble::subpaths::{Plan, PlanEntry};
use emlt::gpu::layout::{ROW_COLOUR, ROW_PIXEL, ROW_VERTICES};
use emlt::kernels::{Kernel, guided_light_subpath, lens_subpath, light_subpath};
use emlt::reference::rng;
use glam::{DVec2, DVec3};

use crate::bench::{Bench, FILM, HALF, SEED, context};
use crate::estimator::{Chosen, PASSES, held, held_paths};
use crate::room::{DIFFUSE, Held, Point, Room};
use crate::structural::compared;
use crate::sums::{Agreement, PROPOSALS, QUADRATURE, Sums};
use crate::{
    FEWER, GLOSSY, LAYERED, LOOKS, SCENE, SPECULAR_SCENE, Z_LIMIT, check_long, check_stationarity, say_symmetric,
    scene_of,
};

pub const KERNELS: [&Kernel; 3] = [&lens_subpath::KERNEL, &light_subpath::KERNEL, &guided_light_subpath::KERNEL];

/// Share of asymmetric proposals, of at least `wanted`. The way back has the same plan and guides, or wrongly those of
/// another path.
fn asymmetric_share(bench: &mut Bench, kernel: &Kernel, anothers_guides: bool, wanted: usize) -> (f64, usize) {
    let back = |entry: PlanEntry, next: PlanEntry| {
        PlanEntry { guides: if anothers_guides { next.guides } else { entry.guides }, ..entry }.words()
    };
    let list = |bench: &mut Bench, pass| bench.plan_list(kernel, HALF, pass).entries;
    let [bad, all, rejected] = compared(bench, kernel, wanted, list, back);
    assert_eq!(rejected, 0, "ways back cannot be drawn");
    (bad as f64 / all as f64, all)
}

/// Says and checks it of all three.
#[track_caller]
pub fn check_symmetry(bench: &mut Bench, name: &str, wanted: usize) {
    bench.publish_guides();
    for kernel in KERNELS {
        say_symmetric(name, kernel, asymmetric_share(bench, kernel, false, wanted));
    }
}

#[test]
fn log_ratios_of_subpaths_are_antisymmetric() {
    let context = context();
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    check_symmetry(&mut bench, SPECULAR_SCENE, 1_000_000);
    let (share, _) = asymmetric_share(&mut bench, &guided_light_subpath::KERNEL, true, 50_000);
    println!("twin, another path's guides on the way back: {share:.3} asymmetric");
    assert!(share > 0.05, "the twin with another path's guides passes: {share}");
}

/// Twins leave out all of the density, or the probability that a walk ends at a vertex which could also mirror.
#[test]
fn subpaths_leave_the_target_alone() {
    let [lens, light, guided] = KERNELS;
    let twins = [lens, light, guided].map(|kernel| (kernel, "twin_one_sided", 90_000));
    check_stationarity(SCENE, &KERNELS, &twins, &LOOKS);
    check_stationarity(SPECULAR_SCENE, &KERNELS, &[], &FEWER[1..2]);
    check_stationarity(GLOSSY, &KERNELS, &[], &FEWER[1..2]);
    let twins = [lens, light].map(|kernel| (kernel, "twin_stop", 330_000));
    check_stationarity(LAYERED, &KERNELS, &twins, &FEWER[1..2]);
}

/// Ends of a chain's tags to be told apart: those that x's own type and its neighbours have.
const CHAINS: [&[u32]; 4] = [&[], &[1], &[2, 2], &[2, 1, 2]];

/// From one path the mean over proposals of h(y) C(y) / (C(x) T(x -> y)) against quadratures of h C / C(x) in f64, one for
/// each chain of specular vertices; h tells these and tiles of the film (lens), or octants of the direction (light), apart.
fn check(bench: &mut Bench, room: &Room, kernel: &Kernel, lost_cosine: bool) -> Agreement {
    const POINTS: u32 = 200_000;
    const PARTS: usize = 12;
    let (features, from_light) = (bench.features, kernel.flags.contains(&"light_side"));
    let plan_of = |key: TypeKey| match from_light {
        // Of a caustic, whose C the state has.
        true => Plan::from_light(key, features).filter(|plan| plan.first > 1 && !key.is_diffuse(plan.first)),
        false => Plan::from_camera(key, 1).filter(|plan| plan.first > 1),
    };
    let chosen = Chosen::new(bench, 0, |key, _| plan_of(key).is_some() && key.edges() <= 5);
    chosen.fill(bench);
    let key = bench.keys(0, 1)[0];
    let path = held(bench, room);
    let plan = plan_of(key).unwrap();
    let first = plan.first as usize;
    // The path with another chain: only what is kept is read, and where the first new vertex lies.
    let with = |chain: &[u32], towards: DVec3| {
        let new = if from_light { [chain, &[DIFFUSE]].concat() } else { [&[DIFFUSE], chain].concat() };
        let tags = [&path.tags[..first], &new].concat();
        let start = path.points[first - 1];
        let next = Point { position: start.position + towards, ..start };
        let points = path.points[..first].iter().copied().chain(std::iter::repeat_n(next, new.len())).collect();
        Held { tags, points, pixel: path.pixel }
    };
    let film = DVec2::new(FILM[0].into(), FILM[1].into());
    let tile = |p: DVec2| (4.0 * p.x / film.x).min(3.0) as usize + 4 * (3.0 * p.y / film.y).min(2.0) as usize;
    let octant = |w: DVec3| [w.x, w.y, w.z].iter().fold(0, |part, c| 2 * part + usize::from(*c > 0.0));
    let of_x = if from_light {
        room.light_sweep(&path, first - 1, DVec2::ZERO)
    } else {
        room.camera_sweep(&path, first, path.pixel, &[])
    };
    assert!(of_x > 0.0, "x itself is not found by {}: {}", kernel.name, key.string());
    let proposals = f64::from(PASSES * HALF);
    let mut sums = Sums::new(CHAINS.len() * PARTS, [POINTS.into(), proposals, 0.0]);
    for (number, chain) in CHAINS.iter().enumerate() {
        for n in 0..POINTS {
            let u = rng::random_words(SEED, n, number as u32, 11).map(rng::uniform);
            let (part, value) = if from_light {
                let (z, phi) = (1.0 - 2.0 * u[0], 2.0 * std::f64::consts::PI * u[1]);
                let r = (1.0 - z * z).sqrt();
                let w = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                (octant(w), 4.0 * std::f64::consts::PI * room.light_sweep(&with(chain, w), first - 1, DVec2::ZERO))
            } else {
                // Densities on the film are over its area.
                let pixel = DVec2::new(u[0], u[1]) * film;
                (tile(pixel), room.camera_sweep(&with(chain, DVec3::ZERO), first, pixel, &[]))
            };
            sums.add(QUADRATURE, PARTS * number + part, value / of_x / f64::from(POINTS));
        }
    }
    bench.publish_guides();
    let log_c_row = if from_light { (ROW_PIXEL, 2) } else { (ROW_COLOUR, 3) };
    let number =
        |bench: &mut Bench, (row, word): (usize, usize)| f64::from(f32::from_bits(bench.rows(row, 0, 1)[0][word]));
    // The ratio has I(x) in place of C(x).
    let log_i_over_c = number(bench, (ROW_VERTICES, 3)) - number(bench, log_c_row);
    let kept_tags: u128 = (1..plan.first).map(|i| u128::from(key.tag_bits(i)) << (2 * (i - 1))).sum();
    for pass in 1..=PASSES {
        chosen.fill(bench);
        let mut entries = bench.plan_list(kernel, HALF, pass).entries;
        if !from_light {
            // Some would have another plan.
            entries = (0..HALF).map(|path| PlanEntry { path, plan, guides: [0; 2] }).collect();
        }
        assert!(entries.len() == HALF as usize && entries.iter().all(|entry| entry.plan == plan));
        assert_eq!(entries.iter().all(|entry| entry.guides[1] > 0), kernel.guided);
        let words: Vec<u32> = entries.iter().flat_map(|entry| entry.words()).collect();
        bench.run.set_lists(&words);
        let uniform = bench.cut_uniform(entries.len());
        bench.passes(kernel, &["probe", "probe_density"], uniform, pass..pass + 1);
        let records = bench.lens_records(HALF);
        let keys = bench.keys(0, HALF);
        for (number, chain) in CHAINS.iter().enumerate() {
            let new = if from_light { [chain, &[DIFFUSE][..]].concat() } else { [&[DIFFUSE][..], chain].concat() };
            let tags = new.iter().enumerate().map(|(i, tag)| u128::from(*tag) << (2 * (first - 1 + i))).sum::<u128>();
            let wanted = TypeKey::new(plan.first + new.len() as u32, kept_tags | tags);
            let made = held_paths(bench, room, wanted, HALF);
            for (entry, record) in entries.iter().zip(&records) {
                let path = entry.path as usize;
                if record.log_ratio < -1e29 || keys[path] != wanted {
                    continue;
                }
                let y = &made[path];
                let part = if from_light { octant(y.direction(first - 1, first)) } else { tile(y.pixel) };
                let mut value = (f64::from(record.log_ratio) + log_i_over_c).exp();
                if lost_cosine {
                    let end = &y.points[if from_light { y.edges() - 1 } else { first }];
                    value /= if from_light {
                        end.ng.dot(room.towards_eye(end))
                    } else {
                        end.ns.dot(y.direction(first, first - 1))
                    }
                    .abs();
                }
                sums.add(PROPOSALS, PARTS * number + part, value / proposals);
            }
        }
    }
    sums.agreement(&format!("{} from {}, cosine lost: {lost_cosine}", kernel.name, key.string()))
}

/// Every bin has an error probability of 1e-6, all together below 2e-4.
#[test]
#[ignore = "takes hours on a processor, minutes on a GPU; ./run test --long"]
fn long_subpaths_leave_the_target_alone() {
    [SCENE, SPECULAR_SCENE, GLOSSY, LAYERED].iter().for_each(|scene| check_long(scene, &KERNELS));
}

#[test]
fn subpaths_estimate_what_they_can_reach() {
    let context = context();
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    let room = Room::new(&scene_of(SPECULAR_SCENE), &bench.data);
    let mut broken = Vec::new();
    for kernel in KERNELS {
        if !check(&mut bench, &room, kernel, false).holds(Z_LIMIT) {
            broken.push(kernel.name);
        }
        assert!(check(&mut bench, &room, kernel, true).worst > Z_LIMIT, "{} with a cosine lost passes", kernel.name);
    }
    assert!(broken.is_empty(), "{broken:?}");
}
