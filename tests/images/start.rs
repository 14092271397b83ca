//! What a start may change without the light: maps of photons and of sightings, and a share left to the path tracer.

use std::collections::BTreeMap;

use emlt::ensemble::bootstrap::{
    BATCH, BATCH_BYTES, CANDIDATE_PASS, CANDIDATES, Candidate, Given, MAPS_ROWS, Mean, Start,
};
use emlt::ensemble::groups::Groups;
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::pool::TypeKey;
use emlt::ensemble::sweep::list_words;
use emlt::gpu::context::Context;
use emlt::gpu::layout::chain_rows;
use emlt::gpu::run::{Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::report::student::two_sided;
use emlt::scene::{Features, Scene};

use super::changed_sources::changed_sources;
use super::renders::scene;

const FILM: [u32; 2] = [64, 48];
/// Probability that one comparison of a test raises a false alarm, all its types together.
const LEVEL: f64 = 1e-4;
const MAX_EDGES: u32 = 8;
/// Paths of which the start is to be; these tests need none.
const PATHS: u32 = 64;

/// A start that has found out what it needs, and its candidates.
struct Begun {
    given: Given,
    candidates: Vec<Candidate>,
}

/// All that a start does before its candidates, and as many candidates as count, by the strategies that its pilots chose.
fn begin(context: &Context, scene: &Scene, maps: bool, direct: Direct, seed: u32) -> Begun {
    let camera = scene.camera(None).unwrap();
    let data = SceneData::with_threshold(scene, camera, FILM[0], FILM[1], 0.0).unwrap();
    let rows = chain_rows(MAX_EDGES) as u64 * u64::from(PATHS);
    let sizes = Sizes {
        chains: 16 * (rows + if maps { MAPS_ROWS } else { 0 }),
        lists: 4 * list_words(PATHS, BATCH),
        output: BATCH_BYTES,
        counters: 256,
    };
    let mut run = Run::new(context, &data, sizes).unwrap();
    let start = Start {
        features: Features::with_threshold(scene, 0.0).seen_by(scene, camera),
        direct,
        maps_row: maps.then_some(rows as u32),
        max_edges: MAX_EDGES,
        two_stage: None,
        candidates: 1 << 16,
        seed,
        groups: Groups::new(PATHS, 1),
        stride: PATHS,
        film: FILM,
    };
    let mut starting = start.begin(&run);
    while start.step(&mut run, &mut starting).unwrap() {}
    let given = starting.given();
    let bootstrap = start.finish(&mut run, starting).unwrap().unwrap();
    let (candidates, _) = start.candidates(&mut run, &bootstrap.strategies, given, CANDIDATES, CANDIDATE_PASS).unwrap();
    Begun { given, candidates }
}

/// b by type, and of all under the shortest key.
fn by_type(candidates: &[Candidate]) -> BTreeMap<Option<TypeKey>, Mean> {
    let mut means: BTreeMap<Option<TypeKey>, Mean> = BTreeMap::new();
    for candidate in candidates.iter().filter(|candidate| candidate.weight() > 0.0) {
        for key in [None, candidate.key()] {
            means.entry(key).or_default().add(candidate.weight());
        }
    }
    // The others add nothing but their number.
    means.values_mut().for_each(|mean| mean.count = candidates.len() as f64);
    means
}

/// Candidates that find a type at least, for its mean to be as good as normal.
const FEWEST: f64 = 200.0;

/// Compares b and its parts by type; says the least error probability times the number of comparisons, and how exactly b
/// itself was compared.
fn compare(name: &str, one: &[Candidate], other: &[Candidate], only: impl Fn(TypeKey) -> bool) -> (f64, f64) {
    let [a, b] = [one, other].map(by_type);
    let count = |candidates: &[Candidate], key: TypeKey| {
        candidates.iter().filter(|c| c.weight() > 0.0 && c.key() == Some(key)).count() as f64
    };
    let seen = |key: &TypeKey| only(*key) && count(one, *key).min(count(other, *key)) >= FEWEST;
    let types: Vec<TypeKey> =
        a.keys().flatten().copied().filter(|key| b.contains_key(&Some(*key)) && seen(key)).collect();
    let mut least = 1.0f64;
    let keys = types.iter().map(|key| Some(*key)).chain((types.len() == a.len() - 1).then_some(None));
    for key in keys {
        let (x, y) = (a[&key], b[&key]);
        let z = (x.mean() - y.mean()) / x.standard_error().hypot(y.standard_error());
        least = least.min(two_sided(z, 1000));
        let type_name = key.map_or("all".into(), TypeKey::string);
        println!("{name}, {type_name}: {:.5} and {:.5}, z {z:.2}", x.mean(), y.mean());
    }
    assert!(types.len() > 3, "{name}: {} types", types.len());
    let [x, y] = [a[&None], b[&None]];
    let relative = x.standard_error().hypot(y.standard_error()) / y.mean();
    println!("{name}: all of it to {:.2} %", 100.0 * relative);
    (least * (types.len() + 1) as f64, relative)
}

const POOL: &str = "tests/scenes/pool_wide_lamp.glb";
const RING: &str = "scenes/ring.glb";
const PHOTONS: &str = "transport/photons.wesl";
const SIGHTINGS: &str = "transport/sightings.wesl";
/// Lamps that are large enough, and seen by mirrors, to be hit without a map as well.
const MIRRORS: &str = "scenes/mirrors.glb";

/// Whether lamps are seen through specular vertices alone: what the map of sightings is for.
fn is_sighting(key: TypeKey) -> bool {
    key.edges() > 1 && (1..key.edges()).all(|i| key.tag_bits(i) != 0)
}

/// Light by mirrors is as much with maps of photons and of sightings as without, type by type.
#[test]
fn maps_leave_the_light_alone() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let scene = scene(MIRRORS);
    let seeds = [(true, 1), (false, 2)];
    let [with, without] = seeds.map(|(maps, seed)| begin(&context, &scene, maps, Direct::Mcmc, seed));
    assert!(with.given.photons.is_some() && with.given.sightings.is_some());
    assert!(without.given.photons.is_none() && without.given.sightings.is_none());
    let sightings = by_type(&with.candidates).into_keys().flatten().filter(|key| is_sighting(*key)).count();
    assert!(sightings > 1, "{sightings} types of sightings");
    let (p, _) = compare(MIRRORS, &with.candidates, &without.candidates, |_| true);
    assert!(p > LEVEL, "p {p}");
}

/// What the comparison is for: a density that takes a map's law for another, or leaves its share out, fails it.
#[test]
fn twins_of_the_maps_are_caught() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let scene = scene(MIRRORS);
    let without = begin(&context, &scene, false, Direct::Mcmc, 1);
    let twins = [
        ("narrow", PHOTONS, "sum += s * (2.0 + s) / (x * x);", "sum += 0.8 * s * (2.0 + s) / (x * x);"),
        ("share", PHOTONS, "return (1.0 - PHOTON_SHARE) * plain", "return plain"),
        ("even", SIGHTINGS, "return log(bitcast<f32>(chains[run.sightings_first + cell_of(pixel)].w));", "return 0.0;"),
        ("alias", SIGHTINGS, "select(row.z, row.y, u.y < bitcast<f32>(row.x))", "row.y"),
    ];
    for (name, module, from, to) in twins {
        context.set_sources(changed_sources(&format!("maps_{name}"), module, from, to)).unwrap();
        let twin = begin(&context, &scene, true, Direct::Mcmc, 2);
        let (p, _) = compare(name, &twin.candidates, &without.candidates, |_| true);
        assert!(p < LEVEL, "{name} passes: p {p}");
    }
}

/// What the path tracer is given, no candidate is of; all other light is there as before.
#[test]
fn what_is_path_traced_is_left_out_and_nothing_else() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    for path in [POOL, RING] {
        let scene = scene(path);
        let parted = begin(&context, &scene, true, Direct::Auto, 3);
        let whole = begin(&context, &scene, true, Direct::Mcmc, 4);
        let path_traced = parted.given.path_traced;
        assert!(!path_traced.is_empty() && !path_traced.is_all(MAX_EDGES), "{path}: {path_traced:?}");
        let lit = parted.candidates.iter().filter(|candidate| candidate.weight() > 0.0);
        assert!(lit.filter_map(Candidate::key).all(|key| !path_traced.has(key)), "{path}");
        let (p, _) = compare(path, &parted.candidates, &whole.candidates, |key| !path_traced.has(key));
        assert!(p > LEVEL, "{path}: p {p}");
    }
}
