//! Lens perturbation: an isotropic step on the film (METHOD.md 2.3; Veach 1997, section 11.4.3).

use super::{Kernel, first_diffuse};
use crate::ensemble::pool::TypeKey;

/// Applies to (L|D) D S* E and L S* E.
pub const KERNEL: Kernel = Kernel { name: "lens", pass: "lens", flags: &[], applies, guided: false };

/// Whether the vertex before the first diffuse one (seen from the camera) can be connected to.
pub fn applies(key: TypeKey) -> bool {
    let j = first_diffuse(key);
    j < 2 || key.is_diffuse(j - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::pool::Tag::{Diffuse as D, Reflection as R, Transmission as T};

    #[test]
    fn applies_where_a_connection_can_be_made() {
        let cases: [(&[crate::ensemble::pool::Tag], bool); 9] = [
            (&[], true),            // L E
            (&[D], true),           // L D E
            (&[R], true),           // L S E: on to the light
            (&[T, T], true),        // L S S E
            (&[D, D], true),        // L D D E
            (&[D, T, T], true),     // L D S S E
            (&[T, D], false),       // L S D E: a caustic
            (&[D, R, D, T], false), // L D S D S E
            (&[T, D, D, R], true),  // L S D D S E
        ];
        for (tags, expected) in cases {
            assert_eq!(applies(TypeKey::from_tags(tags)), expected, "{tags:?}");
        }
    }
}
