//! Sorted lists of a half, made by all groups at once.

/// The entries of `parts`, each sorted by `key`, in one list sorted by it; of the same key those of earlier parts come
/// first. Keys are few, so that whole runs of one key are moved.
pub(super) fn merged<T: Copy, K: Ord>(parts: &[Vec<T>], key: impl Fn(&T) -> K) -> Vec<T> {
    let mut runs: Vec<&[T]> = parts.iter().flat_map(|part| part.chunk_by(|a, b| key(a) == key(b))).collect();
    runs.sort_by_key(|run| key(&run[0]));
    runs.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_merged_as_a_stable_sort_would() {
        let number = |i: u32| i.wrapping_mul(2_654_435_761) >> 29;
        let parts: Vec<Vec<(u32, u32)>> = (0..5)
            .map(|part| {
                let mut entries: Vec<_> = (0..40 * part).map(|i| (number(i + 1000 * part), i + 1000 * part)).collect();
                entries.sort_by_key(|e| e.0);
                entries
            })
            .collect();
        let mut expected = parts.concat();
        expected.sort_by_key(|e| e.0);
        assert_eq!(merged(&parts, |e| e.0), expected);
        assert!(merged(&Vec::<Vec<u8>>::new(), |e| *e).is_empty());
    }
}
