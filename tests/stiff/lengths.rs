//! Item 7: paths of 64 edges, the longest there are. In furnaces so dark that their light is 1e-140 of the shortest's, b of
//! every length has a closed form, and all of it comes from products of 64 factors.

use emlt::ensemble::bootstrap::{Given, Mean};
use emlt::ensemble::crossings::{Pair, PairList, Partners};
use emlt::ensemble::cuts::{CutEntry, CutList};
use emlt::ensemble::pool::{MAX_EDGES, Pool, TypeKey};
use emlt::ensemble::strategies::Strategies;
use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::kernels::ALL;
use emlt::methods::{Method, Settings};
use emlt::reference::rng::random_words;
use emlt::report::student::two_sided;
use emlt::scene::{Lens, Material, Scene};
use glam::{Vec3, vec3};

use super::bench::Bench;
use super::comparison::{LEVEL, Power, Truth, check};
use super::furnaces::{EMISSION, box_furnace};
use super::renders::{replicates, settings};

const LONGEST: u32 = MAX_EDGES;
const COUNT: u32 = 1 << 18;

#[test]
fn the_longest_paths_neither_overflow_nor_underflow() {
    let albedo = vec3(0.006, 0.005, 0.003);
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    // Bright enough that f itself, near the camera, is far from 1 the other way.
    for brightness in [1.0f32, 1e25] {
        let mut scene = box_furnace();
        scene.materials[0].base_color = albedo;
        scene.materials[0].emission = brightness * EMISSION;
        let mut bench = Bench::new(&context, &scene, [16, 12], LONGEST, 64);
        bench.bootstrap.strategies = Strategies::uniform(1..=LONGEST, false, false);
        let (candidates, strategies) = bench.candidates(COUNT);
        let (mut least, mut widest) = (1.0f64, 0.0f64);
        for edges in 1..=LONGEST {
            let mut weights = Mean::default();
            // Every wall is a light, so a walk ends after one edge.
            let made = |l: &[u32; 2]| l[0] == edges || (edges == 1 && l[0] == 0);
            let of = candidates.iter().zip(&strategies).filter(|(_, l)| made(l));
            // In units of the closed form, whose squares f64 would not hold.
            let term =
                |c: usize| f64::from(scene.materials[0].emission[c]) * f64::from(albedo[c]).powi(edges as i32 - 1);
            let truth = 0.2126 * term(0) + 0.7152 * term(1) + 0.0722 * term(2);
            of.for_each(|(c, _)| weights.add((f64::from(c.log_weight) - truth.ln()).exp()));
            // The number of candidates of each length is fixed (systematic sampling), so it adds no noise.
            let share = weights.count / f64::from(COUNT);
            let (ratio, error) = (share * weights.mean(), share * weights.standard_error());
            let p = two_sided((ratio - 1.0) / error, 1000);
            (least, widest) = (least.min(p), widest.max(error));
            assert!(p * f64::from(LONGEST) > LEVEL, "{edges} edges: {ratio} +- {error} of {truth:.1e}");
        }
        println!(
            "{LONGEST} lengths at brightness {brightness:.0e}: least p {least:.1e}, errors up to {:.2} %",
            100.0 * widest
        );
        // What the test can see: 10 % at any length.
        assert!(widest < 0.02, "{widest}");
    }
}

/// The longest paths of the following: of more than 32 edges, types take keys of twice the words.
const LONG: u32 = 40;

/// A white furnace of which two walls are mirrors, through a lens: each length holds as much light as any other, those above
/// 32 edges a fifth of it.
fn white_furnace() -> Scene {
    let mut scene = Scene { name: "white furnace".into(), ..box_furnace() };
    scene.materials[0].base_color = Vec3::ONE;
    scene.materials.push(Material { base_color: Vec3::ONE, roughness: 0.0, emission: EMISSION, ..Material::default() });
    // Two walls that meet.
    [0, 1, 8, 9].into_iter().for_each(|triangle| scene.triangle_materials[triangle] = 1);
    scene.cameras[0].lens = Some(Lens { aperture: 0.2, focus: 1.5 });
    scene
}

#[test]
fn long_keys_by_every_kernel() {
    let scene = white_furnace();
    let [width, height] = [16, 12];
    let pixels = vec![(LONG as f32 * EMISSION).to_array(); (width * height) as usize];
    let truth = Truth { image: Image { width, height, pixels }, variance: None, tile: 4 };
    let mix = ALL.map(|kernel| (kernel, if kernel.family.keeps_types() { 1.0 } else { 0.1 })).to_vec();
    let base = settings(Method::Emlt, [width, height], 200);
    let settings = Settings { max_depth: LONG, candidates: 1 << 16, kernels: Some(mix), ..base };
    let images = replicates(&scene, &settings, 12);
    check("long keys by every kernel", &images, &truth, Power { film: 0.05, tile: 0.2 });
}

/// Paths keep their keys when they are made again and stored; crossovers and bidirectional mutations change them as the
/// host has it.
#[test]
fn long_keys_are_those_of_the_host() {
    const HALF: u32 = 4096;
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut bench = Bench::new(&context, &white_furnace(), [16, 12], LONG, 2 * HALF);
    let (candidates, strategies) = bench.candidates(1 << 16);
    let chosen: Vec<u32> = (0..).zip(&candidates).filter(|(_, c)| c.weight() > 0.0).map(|(i, _)| i).collect();
    let chosen: Vec<u32> = chosen.into_iter().rev().take(2 * HALF as usize).collect();
    bench.start.fill(&mut bench.run, Given::default(), &strategies, &chosen).unwrap();
    let keys = bench.keys();
    let drawn: Vec<TypeKey> = chosen.iter().map(|i| candidates[*i as usize].key().unwrap()).collect();
    assert!(keys == drawn, "stored keys are not those of the candidates");

    let halves = [0, HALF].map(|first| Pool::build(&keys[first as usize..][..HALF as usize], first));
    let partners = Partners { halves: [&halves[0], &halves[1]], first: [0, HALF], shift: 5 };
    let random = |path, dimension| random_words(7, path, 0, dimension);
    let list = PairList::draw([partners], random, 1..=LONG);
    bench.run.set_lists(&list.words);
    let uniform = bench.uniform(2 * list.pairs.len());
    bench.pass("crossover", &[], uniform);
    let uniform = bench.uniform(list.pairs.len());
    bench.pass("exchange", &["probe"], uniform);
    let (after, records) = (bench.keys(), bench.records(list.pairs.len()));
    let mut long = 0;
    for (Pair { paths, crossing, .. }, record) in list.pairs.iter().zip(records) {
        let before = paths.map(|path| keys[path as usize]);
        let expected = if record[3] > -1e29 { crossing.exchanged(before) } else { before };
        assert_eq!(paths.map(|path| after[path as usize]), expected, "{before:?} {crossing:?}");
        long += usize::from(expected != before && before.iter().chain(&expected).any(|key| key.edges() > 32));
    }
    println!("{long} of {} crossovers had to do with more than 32 edges", list.pairs.len());
    assert!(long > 100, "{long}");

    let keys = after;
    let [x, v] = [0, HALF].map(|first| Pool::build(&keys[first as usize..][..HALF as usize], first));
    let list = CutList::draw(&[(&x, &v, HALF)], random, 1..=LONG);
    bench.run.set_lists(&list.words);
    let uniform = bench.uniform(list.entries.len());
    bench.pass("bidirectional", &["segment", "probe"], uniform);
    let (after, records) = (bench.keys(), bench.records(list.entries.len()));
    let mut long = 0;
    for (CutEntry { path, cut, .. }, _) in list.entries.iter().zip(records).filter(|(_, record)| record[0] > -1e29) {
        let [x, y] = [&keys, &after].map(|keys| keys[*path as usize]);
        assert_eq!(y.edges(), x.edges() + cut.added - cut.deleted, "{x:?} {y:?} {cut:?}");
        let kept = |i: &u32| *i < cut.first || *i >= cut.first + cut.added;
        let old = |i: u32| if i < cut.first { i } else { i + cut.deleted - cut.added };
        assert!((1..y.edges()).filter(kept).all(|i| y.tag_bits(i) == x.tag_bits(old(i))), "{x:?} {y:?} {cut:?}");
        long += usize::from(cut.first > 32);
    }
    println!("{long} of {} cuts lay beyond 32 edges", list.entries.len());
    assert!(long > 20, "{long}");
}
