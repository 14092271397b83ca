//! The type string of a path as a sortable number.

/// Longest path that a [`TypeKey`] can name, in edges: 63 interior vertices of two bits and the sentinel.
pub const MAX_EDGES: u32 = 64;
/// Runs of more equal vertices than this are abbreviated.
const LONGEST_RUN: usize = 8;

/// What happens at an interior vertex of a path (METHOD.md section 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Tag {
    /// D: connectable scattering.
    Diffuse = 0,
    /// S: specular reflection.
    Reflection = 1,
    /// S: specular transmission.
    Transmission = 2,
}

/// The type string of a path: its length and the tags of its interior vertices.
///
/// A path of k edges has k - 1 interior vertices; vertex i = 1 is next to the light. The tag of vertex i sits
/// at bits 2(i-1), and a sentinel 1 at bit 2(k-1) marks the length, so that order by value is order by length first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(transparent)]
pub struct TypeKey(u128);

impl TypeKey {
    /// The key of a path of `edges` edges (1 to [`MAX_EDGES`]) with packed `tags`, two bits a vertex.
    ///
    /// # Panics
    /// If `edges` is out of range or `tags` has bits beyond the interior vertices: both are bugs of the caller.
    pub fn new(edges: u32, tags: u128) -> Self {
        assert!((1..=MAX_EDGES).contains(&edges), "a path has 1 to {MAX_EDGES} edges, not {edges}");
        let sentinel = 1u128 << (2 * (edges - 1));
        assert!(tags < sentinel, "more tags than interior vertices");
        Self(sentinel | tags)
    }

    /// The key of a path with these interior vertices, from the light to the camera.
    pub fn from_tags(tags: &[Tag]) -> Self {
        let packed = tags.iter().enumerate().take(MAX_EDGES as usize).map(|(i, &tag)| (tag as u128) << (2 * i));
        Self::new(tags.len() as u32 + 1, packed.sum())
    }

    /// A key from its value; `None` if no path has it (zero, or a sentinel at an odd bit).
    pub fn from_bits(bits: u128) -> Option<Self> {
        (bits != 0 && bits.ilog2().is_multiple_of(2)).then_some(Self(bits))
    }

    /// A key from the words of a shader, two or four, low word first; `None` if no path has it.
    pub fn from_words<const N: usize>(words: [u32; N]) -> Option<Self> {
        const { assert!(N <= 4, "a key has four words at most") };
        Self::from_bits(words.iter().rev().fold(0, |bits, word| bits << 32 | u128::from(*word)))
    }

    /// The value: order by it is order by length first.
    pub fn bits(self) -> u128 {
        self.0
    }

    /// Heckbert's string with S for any specular vertex, from the light: L S D E for a caustic.
    pub fn string(self) -> String {
        let interior = (1..self.edges()).map(|i| if self.is_diffuse(i) { " D" } else { " S" });
        ["L"].into_iter().chain(interior).chain([" E"]).collect()
    }

    /// The key of a path that Heckbert's string describes, any specular vertex as a reflection; `None` for other texts.
    pub fn from_string(string: &str) -> Option<Self> {
        let vertices = string.strip_prefix("L ")?.strip_suffix('E')?;
        let tag = |vertex| match vertex {
            "D" => Some(Tag::Diffuse),
            "S" => Some(Tag::Reflection),
            _ => None,
        };
        let tags: Vec<Tag> = vertices.split_whitespace().map(tag).collect::<Option<_>>()?;
        (tags.len() < MAX_EDGES as usize).then(|| Self::from_tags(&tags))
    }

    /// The words a shader sees, low word first; the last two are 0 in keys of up to 32 edges.
    pub fn words(self) -> [u32; 4] {
        [0, 32, 64, 96].map(|shift| (self.0 >> shift) as u32)
    }

    /// Path length in edges.
    pub fn edges(self) -> u32 {
        self.0.ilog2() / 2 + 1
    }

    /// The two tag bits of interior vertex `i`, 1 (next to the light) to `edges() - 1` (next to the camera).
    pub fn tag_bits(self, i: u32) -> u32 {
        debug_assert!((1..self.edges()).contains(&i), "vertex {i} is not an interior vertex");
        (self.0 >> (2 * (i - 1))) as u32 & 3
    }

    /// True if interior vertex `i` is connectable (tag D).
    pub fn is_diffuse(self, i: u32) -> bool {
        self.tag_bits(i) == Tag::Diffuse as u32
    }
}

/// A type string as people read it: of long runs one letter and the number, L D S x32 E.
pub fn abbreviated(string: &str) -> String {
    let vertices: Vec<&str> = string.split(' ').collect();
    let runs = vertices.chunk_by(|a, b| a == b).map(|run| match run.len() {
        n if n > LONGEST_RUN => format!("{} x{n}", run[0]),
        _ => run.join(" "),
    });
    runs.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use Tag::{Diffuse as D, Reflection as R, Transmission as T};

    /// Keys of every length, three tag patterns each.
    fn keys() -> Vec<TypeKey> {
        let key = |edges| {
            [0x2612_4890_1249_2612_4890_1249_2612_4890u128, 0, u128::MAX / 3]
                .map(|tags| TypeKey::new(edges, tags % (1 << (2 * (edges - 1)))))
        };
        (1..=MAX_EDGES).flat_map(key).collect()
    }

    #[test]
    fn key_holds_length_and_tags() {
        let key = TypeKey::from_tags(&[D, T, R]);
        assert_eq!((key.edges(), key.bits()), (4, 0b01_01_10_00));
        assert_eq!((1..4).map(|i| key.tag_bits(i)).collect::<Vec<_>>(), [0, 2, 1]);
        assert!(key.is_diffuse(1) && !key.is_diffuse(2));
        assert_eq!(TypeKey::from_tags(&[]).edges(), 1);
        for tags in [&[][..], &[D], &[R, D, R]] {
            let key = TypeKey::from_tags(tags);
            assert_eq!(TypeKey::from_string(&key.string()), Some(key));
        }
        assert_eq!(["", "L D", "E", "L X E"].map(TypeKey::from_string), [None; 4]);
        assert_eq!(TypeKey::from_tags(&[T; MAX_EDGES as usize - 1]).edges(), MAX_EDGES);
    }

    #[test]
    fn keys_survive_the_way_through_words() {
        for key in keys() {
            let [a, b, c, d] = key.words();
            assert_eq!(TypeKey::from_words([a, b, c, d]), Some(key));
            assert_eq!([c, d] == [0; 2], key.edges() <= 32);
            assert_eq!(TypeKey::from_words([a, b]) == Some(key), key.edges() <= 32);
        }
        assert_eq!(TypeKey::from_words([0, 0]), None);
        assert_eq!(TypeKey::from_words([0b10, 0]), None);
        assert_eq!(TypeKey::from_words([0, 1 << 31]), None);
        assert_eq!(TypeKey::from_words([0, 0, 0, 1 << 31]), None);
    }

    #[test]
    fn a_longer_path_has_a_larger_key() {
        let mut keys = keys();
        keys.sort();
        assert!(keys.is_sorted_by_key(|key| key.edges()));
    }

    #[test]
    fn long_runs_are_abbreviated() {
        let of = |tags: &[Tag]| abbreviated(&TypeKey::from_tags(tags).string());
        assert_eq!(of(&[D, T, R, D]), "L D S S D E");
        assert_eq!(of(&[D; 8]), "L D D D D D D D D E");
        assert_eq!(of(&[&[D][..], &[R; 20], &[T; 12]].concat()), "L D S x32 E");
        assert_eq!(of(&[]), "L E");
    }
}
