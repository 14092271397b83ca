//! Twin of shaders/math/rng.wesl: the same words for the same key, on host and device.

/// PCG4D (Jarzynski and Olano 2020).
pub fn pcg4d(key: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = key.map(|k| k.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for shift in [true, false] {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if shift {
            [x, y, z, w] = [x, y, z, w].map(|v| v ^ (v >> 16));
        }
    }
    [x, y, z, w]
}

/// The words of one dimension block, keyed like `random_words` in the shaders.
pub fn random_words(seed: u32, path: u32, pass_index: u32, dimension: u32) -> [u32; 4] {
    pcg4d([path, pass_index, dimension, seed])
}

/// Uniform in (0, 1) with 32 bits.
pub fn uniform(word: u32) -> f64 {
    (f64::from(word) + 0.5) / 4_294_967_296.0
}
