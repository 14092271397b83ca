//! Which light the path tracer renders in the chains' place (METHOD.md 1.5).
//!
//! Some types of paths are found by path tracing as well as anything can find them, and chains would only stand about in
//! their light. The choice is a function of the path alone: of its number of edges, and of whether the vertices next to the
//! light and next to the camera are specular. So neither side needs to know of the other, and the image is the sum.

use super::bootstrap::Candidate;
use super::pool::TypeKey;
use super::strategies::INDIRECT_EDGES;
use super::two_stage::PixelWeights;
use crate::gpu::layout::{PATH_TRACED_EDGES, PassUniform};
use crate::scene::Features;

/// Who renders light that the path tracer could (METHOD.md 1.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Direct {
    /// The chains: all light is theirs
    Mcmc,
    /// The path tracer renders direct light
    Pt,
    /// The path tracer renders whatever types of paths it finds easily, as the start's pilot shows
    Auto,
}

impl Direct {
    /// As the command line has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mcmc => "mcmc",
            Self::Pt => "pt",
            Self::Auto => "auto",
        }
    }

    /// Edges of the shortest path that is left to the chains, as far as it is known before the start.
    pub fn min_edges(self) -> u32 {
        if self == Self::Pt { INDIRECT_EDGES } else { 1 }
    }

    /// What is known before the start.
    pub fn path_traced(self) -> PathTraced {
        if self == Self::Pt { PathTraced::direct() } else { PathTraced::default() }
    }

    /// What the shaders that may change a path's type are compiled with.
    pub fn flag(self) -> Option<&'static str> {
        (self != Self::Mcmc).then_some("path_traced")
    }
}

/// A set of classes of paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathTraced {
    /// A bit a class that has a diffuse vertex, four classes for every number of edges.
    classes: u64,
    /// A bit for every number of edges: paths without a diffuse vertex, from a light seen through speculars alone.
    specular: u32,
}

/// What the path tracer is to do, and its share of the time after the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Easy {
    pub path_traced: PathTraced,
    pub time_share: f64,
}

/// Up to this mean square of the path tracer's samples over the mean light they bring, both relative to the luminance around, a
/// class is easy; where the light's next vertex is diffuse, and where it is specular, so that chains are hard to start as well
/// (docs/kernels.md, "Light that is path traced").
const MOST_VARIANCE: [f64; 2] = [8.0, 100.0];
/// The fewest candidates that speak for a class by itself.
const FEWEST_SEEN: u32 = 64;
/// The fewest that speak for light behind speculars, all lengths together.
const FEWEST_KNOWN: u32 = 16;
/// As in relMSE: dark parts count as if they had this share of the film's mean luminance.
const DARKNESS: f64 = 0.1;
/// Share of the light that the path tracer has at least, or it has none.
const LEAST_LIGHT: f64 = 0.2;
/// Share of the time that a start leaves, about.
const LEFT_BY_START: f64 = 0.6;
/// What the share of time lies between.
const TIME_SHARES: [f64; 2] = [0.25, 0.5];

/// What pilot candidates tell of a class.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    count: u32,
    /// Sums of weights; of weights times the path tracer's, and the largest of these; and of squared weights, all over the
    /// luminance around.
    light: f64,
    path_traced: f64,
    largest: f64,
    own: f64,
}

impl Seen {
    fn add(&mut self, weight: f64, path_traced: f64) {
        self.count += 1;
        self.light += weight;
        self.path_traced += weight * path_traced;
        self.largest = self.largest.max(weight * path_traced);
        self.own += weight * weight;
    }

    fn with(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            light: self.light + other.light,
            path_traced: self.path_traced + other.path_traced,
            largest: self.largest.max(other.largest),
            own: self.own + other.own,
        }
    }

    /// The path tracer's mean square over its mean, but for the largest candidate, which chance may have found.
    fn variance(self) -> f64 {
        (self.path_traced - self.largest) / self.light.max(1e-300)
    }

    /// The same of the start's candidates.
    fn own_variance(self) -> f64 {
        self.own / self.light.max(1e-300)
    }
}

impl PathTraced {
    /// All paths of up to 16 edges.
    #[cfg(test)]
    pub(super) const EVERYTHING: Self = Self { classes: u64::MAX, specular: u32::MAX };

    /// Direct light: paths of at most 2 edges.
    pub fn direct() -> Self {
        Self { classes: (1 << (4 * (INDIRECT_EDGES - 1))) - 1, specular: (1 << (INDIRECT_EDGES - 1)) - 1 }
    }

    pub fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// Whether it has all paths of up to so many edges.
    pub fn is_all(self, max_edges: u32) -> bool {
        max_edges <= PATH_TRACED_EDGES
            && self.classes.trailing_ones() >= 4 * max_edges
            && self.specular.trailing_ones() >= max_edges
    }

    /// Tells the shaders of a pass.
    pub fn set(self, uniform: PassUniform) -> PassUniform {
        PassUniform {
            path_traced_low: self.classes as u32,
            path_traced_high: (self.classes >> 32) as u32,
            path_traced_specular: self.specular,
            ..uniform
        }
    }

    /// Edges of the longest path in it.
    pub fn longest(self) -> u32 {
        let last = |bits: u64| bits.checked_ilog2().map_or(0, |bit| bit + 1);
        last(self.classes).div_ceil(4).max(last(self.specular.into()))
    }

    /// Whether a path of the type is in it.
    pub fn has(self, key: TypeKey) -> bool {
        match class(key) {
            None => false,
            Some(Class::Specular(edges)) => self.specular >> (edges - 1) & 1 == 1,
            Some(Class::Other(class)) => self.classes >> class & 1 == 1,
        }
    }
}

impl Easy {
    /// What the path tracer does well among paths of up to `max_edges` edges, by pilot candidates over a film.
    ///
    /// Lights seen through speculars alone go with the others: chance has to find them in any case, and a walk tries all lengths
    /// at once.
    pub fn chosen(film: [u32; 2], features: Features, max_edges: u32, pilot: &[Candidate]) -> Self {
        let splats: Vec<_> = pilot.iter().map(|candidate| (candidate.pixel, candidate.weight())).collect();
        let around = PixelWeights::from_pilot(film, 1.0, &splats);
        let mean = splats.iter().map(|(_, weight)| weight).sum::<f64>() / pilot.len().max(1) as f64;
        let scale = mean / around.mean();
        let mut seen = [Seen::default(); 4 * PATH_TRACED_EDGES as usize];
        let mut specular = Seen::default();
        for candidate in pilot.iter().filter(|candidate| candidate.weight() > 0.0) {
            let m = (scale * around.at(candidate.pixel)).hypot(DARKNESS * mean);
            let sum = match candidate.key().and_then(class) {
                None => continue,
                Some(Class::Specular(_)) => &mut specular,
                Some(Class::Other(class)) => &mut seen[class as usize],
            };
            sum.add(candidate.weight() / m, candidate.path_traced_weight() / m);
        }
        let judged = |class: u32| {
            let own = seen[class as usize];
            let alike = (class % 4..seen.len() as u32).step_by(4);
            let all = alike.fold(Seen::default(), |all, other| all.with(seen[other as usize]));
            // Where few speak for a length, all lengths do.
            if own.count >= FEWEST_SEEN { own } else { all }
        };
        let is_possible = |class: u32| {
            let specular_to_light = class & 2 != 0;
            // Of lights that nothing can hit, the path tracer finds those alone that a diffuse vertex sees.
            let findable = !(specular_to_light && features.mixed);
            // What the pilot has hardly found may be hard to find.
            let known = !(specular_to_light && features.mirror) || judged(class).count >= FEWEST_KNOWN;
            findable && known && judged(class).variance() <= MOST_VARIANCE[usize::from(specular_to_light)]
        };
        let is_better = |class: u32| class & 2 == 0 || judged(class).variance() <= judged(class).own_variance();
        let lengths = max_edges.min(PATH_TRACED_EDGES);
        let set =
            |has: &dyn Fn(u32) -> bool| (0..4 * lengths).filter(|class| has(*class)).map(|class| 1u64 << class).sum();
        let [possible, better]: [u64; 2] = [set(&is_possible), set(&|class| is_possible(class) && is_better(class))];
        let specular_easy = specular.variance() <= MOST_VARIANCE[1];
        let sums = |classes: u64| {
            let specular = if specular_easy { [specular.path_traced, 0.0] } else { [0.0, specular.own] };
            (0u32..).zip(&seen).fold(specular, |[easy, hard], (class, seen)| {
                if classes >> class & 1 == 1 { [easy + seen.path_traced, hard] } else { [easy, hard + seen.own] }
            })
        };
        let whole = PathTraced { classes: possible, specular: ((1u64 << lengths) - 1) as u32 };
        let [easy, hard] = sums(better).map(f64::sqrt);
        // The variance at best shares of the time, chains taken for as many of the start's candidates, against that of the
        // path tracer alone, which needs no start.
        let alone =
            whole.is_all(max_edges) && specular_easy && sums(possible)[0] * LEFT_BY_START <= (easy + hard).powi(2);
        let classes = if alone { possible } else { better };
        let light = |classes: u64| {
            (0u32..).zip(&seen).filter(|(class, _)| classes >> class & 1 == 1).map(|(_, seen)| seen.light).sum::<f64>()
        };
        let worth_it = light(classes) > 0.0 && light(classes) >= LEAST_LIGHT * light(u64::MAX);
        let specular_lengths = if specular_easy { whole.specular } else { 0 };
        let path_traced =
            if worth_it { PathTraced { classes, specular: specular_lengths } } else { PathTraced::default() };
        let [least, most] = TIME_SHARES;
        Self { path_traced, time_share: (easy / (easy + hard).max(1e-300)).clamp(least, most) }
    }
}

enum Class {
    /// Of so many edges, all vertices specular.
    Specular(u32),
    /// Of these its bit.
    Other(u32),
}

/// The class of a type; none where paths are longer than any that the path tracer is given. Twin: `is_path_traced` in
/// shaders/target/path_traced.wesl.
fn class(key: TypeKey) -> Option<Class> {
    let edges = key.edges();
    if edges > PATH_TRACED_EDGES {
        return None;
    }
    if edges > 1 && (1..edges).all(|i| !key.is_diffuse(i)) {
        return Some(Class::Specular(edges));
    }
    let specular = |i| u32::from(edges > 1 && !key.is_diffuse(i));
    Some(Class::Other(4 * (edges - 1) + 2 * specular(1) + specular(edges.max(2) - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{self, Diffuse as D, Reflection as R, Transmission as T};

    fn key(tags: &[Tag]) -> TypeKey {
        TypeKey::from_tags(tags)
    }

    #[test]
    fn direct_light_has_two_edges_at_most() {
        let direct = PathTraced::direct();
        assert!([&[][..], &[D], &[R], &[T]].iter().all(|tags| direct.has(key(tags))));
        assert!([&[D, D][..], &[R, T], &[D, T, D]].iter().all(|tags| !direct.has(key(tags))));
        assert_eq!((direct.longest(), direct.is_all(2), direct.is_all(3), direct.is_empty()), (2, true, false, false));
    }

    #[test]
    fn classes_part_by_length_and_by_the_specular_next_to_light_and_camera() {
        // D T T D E and so on: bit 4 (k - 1) + 2 (light's side) + (camera's side).
        let only = |class: u32| PathTraced { classes: 1 << class, specular: 0 };
        assert!(only(12).has(key(&[D, T, D])) && only(12).has(key(&[D, D, D])));
        assert!(only(13).has(key(&[D, D, T])) && only(14).has(key(&[R, D, D])) && only(15).has(key(&[R, D, T])));
        assert!(!only(15).has(key(&[R, R, R])) && !only(15).has(key(&[R, D, D, T])));
        let specular = PathTraced { classes: 0, specular: 0b1000 };
        assert!(specular.has(key(&[R, T, R])) && !specular.has(key(&[R, D, R])) && !specular.has(key(&[R, R])));
        assert_eq!((only(15).longest(), only(16).longest(), specular.longest()), (4, 5, 4));
        // Longer paths than the table has are nobody's but the chains'.
        let everything = PathTraced::EVERYTHING;
        assert!(everything.has(key(&[D; 15])) && !everything.has(key(&[D; 16])));
        assert!(everything.is_all(16) && !everything.is_all(17));
    }

    /// `count` candidates of a type, each of weight 1, spread over an 8x8 film; of the path tracer's they would weigh `w`.
    fn candidates(count: u32, tags: &[Tag], w: f64) -> Vec<Candidate> {
        let last = ((512.0 * w.ln() + 32768.0) as u32) << 16;
        let words = |i: u32| {
            let [x, y] = [i % 8, i / 8 % 8].map(|place| (place as f32 + 0.5).to_bits());
            let [a, b, c, d] = key(tags).words();
            [0f32.to_bits(), x, y, last, a, b, c, d]
        };
        (0..count).map(|i| bytemuck::cast(words(i))).collect()
    }

    #[test]
    fn what_the_path_tracer_finds_easily_is_its_own() {
        let pilot = [
            candidates(6400, &[D], 1.0),
            candidates(640, &[D, D], 30.0),
            candidates(640, &[D, T], 2.0),
            candidates(640, &[T, D, T], 1e5),
        ]
        .concat();
        let choose = |features, pilot: &[Candidate]| Easy::chosen([8, 8], features, 4, pilot);
        let easy = choose(Features::default(), &pilot);
        let has = |tags: &[Tag]| easy.path_traced.has(key(tags));
        assert!(has(&[D]) && has(&[D, T]) && !has(&[D, D]) && !has(&[T, D, T]), "{easy:?}");
        assert!((TIME_SHARES[0]..=TIME_SHARES[1]).contains(&easy.time_share));
        // Of a light that nothing hits, nothing but next-event estimation is its own.
        let caustic = [candidates(6400, &[D], 1.0), candidates(640, &[T, D], 1.0)].concat();
        assert!(choose(Features::default(), &caustic).path_traced.has(key(&[T, D])));
        let mixed = Features { mixed: true, ..Features::default() };
        assert!(!choose(mixed, &caustic).path_traced.has(key(&[T, D])));
        // A few per cent of the light are not worth a second renderer.
        let little = [candidates(64, &[D], 1.0), candidates(6400, &[D, D], 30.0)].concat();
        assert!(choose(Features::default(), &little).path_traced.is_empty());
        assert!(choose(Features::default(), &[]).path_traced.is_empty());
        // Nor is light behind glass that the pilot has hardly seen.
        let mirror = Features { mirror: true, ..Features::default() };
        let rare = [candidates(6400, &[D], 1.0), candidates(3, &[T, D], 1.0)].concat();
        assert!(!choose(mirror, &rare).path_traced.has(key(&[T, D])));
        assert!(choose(Features::default(), &rare).path_traced.is_all(4));
    }
}
