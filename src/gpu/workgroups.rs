//! How the entries of a dispatch are shared among workgroups, and in which order those take them.

/// Threads a workgroup, in every pass: shaders are composed with it. Nothing else may depend on it.
pub const WORKGROUP: u32 = 64;

/// Workgroups of `threads` for a dispatch, in two dimensions, as one holds at most 65,535.
pub(super) fn workgroups(entries: u32, threads: u32) -> [u32; 2] {
    let groups = entries.div_ceil(threads).max(1);
    let rows = groups.div_ceil(65535);
    [groups.div_ceil(rows), rows]
}

/// A number near the golden section of `groups` and coprime to it: its multiples modulo `groups` are a permutation whose
/// every stretch is spread evenly. `entry_index` in shaders/layout/run.wesl multiplies in 32 bits.
pub(super) fn group_stride(groups: u32) -> u32 {
    let section = (0.618_034 * f64::from(groups)) as u32;
    let largest = (u32::MAX / groups).min(section.max(1));
    (1..=largest).rev().find(|stride| gcd(*stride, groups) == 1).unwrap_or(1)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strides_order_workgroups_without_loss_or_overflow() {
        for entries in [1, 64, 65, 8192, 8191, 1 << 20, 76_800, 4_194_241, 33_177_600, 1 << 27] {
            let [x, y] = workgroups(entries, WORKGROUP);
            let groups = x * y;
            assert!(groups * WORKGROUP >= entries && x <= 65535 && y <= 65535);
            let stride = group_stride(groups);
            assert!(u64::from(groups) * u64::from(stride) <= u64::from(u32::MAX), "{groups} {stride}");
            assert_eq!(gcd(stride, groups), 1, "{groups} {stride}");
        }
    }

    #[test]
    fn every_half_of_the_workgroups_is_a_mixture() {
        for groups in [16u32, 100, 128, 1024, 16384] {
            let stride = group_stride(groups);
            let first_half = (0..groups / 2).map(|i| i * stride % groups);
            let of_the_cheap = first_half.filter(|entry| *entry < groups / 2).count() as f64;
            assert!((of_the_cheap / f64::from(groups / 4) - 1.0).abs() < 0.3, "{groups}: {of_the_cheap}");
        }
    }
}
