//! Every struct that host and shaders share. Twins in `shaders/layout`; a test compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Twin of `SceneUniform` in shaders/layout/scene.wesl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct SceneUniform {
    pub camera_position: [f32; 3],
    pub pixel_area: f32,
    pub camera_right: [f32; 3],
    pub film_width: f32,
    pub camera_up: [f32; 3],
    pub film_height: f32,
    pub camera_back: [f32; 3],
    pub pixels_per_unit: f32,
    pub sky: [f32; 3],
    pub light_count: u32,
    pub light_weight: f32,
    pub lights_offset: u32,
    pub lens_radius: f32,
    pub focus_distance: f32,
}

/// Twin of `PassUniform` in shaders/layout/run.wesl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct PassUniform {
    pub seed: u32,
    pub pass_index: u32,
    pub stride: u32,
    pub entries: u32,
    pub entries_offset: u32,
    pub nodes_offset: u32,
    pub guides_first: u32,
    pub group_paths: u32,
    pub similarity_scale: f32,
    pub guides: u32,
    pub alpha_low: f32,
    pub alpha_high: f32,
    pub weight: f32,
    pub counters_offset: u32,
    pub origins: u32,
    pub keep: u32,
    pub group_stride: u32,
    pub path_traced_low: u32,
    pub path_traced_high: u32,
    pub path_traced_specular: u32,
    pub photons_first: u32,
    /// First row of the map of sightings; 0 where there is none.
    pub sightings_first: u32,
}

/// Whether type keys of paths with up to `max_edges` edges take four words in place of two (the flag `long`).
pub fn is_long(max_edges: u32) -> bool {
    max_edges > 32
}

/// Rows and columns of the strategy table: edges and light-side vertices, from 0 to `max_edges` (`STRATEGY_COLUMNS`).
pub const fn strategy_columns(max_edges: u32) -> usize {
    max_edges as usize + 1
}

/// Words of the strategy table, whole vec4s.
pub const fn strategy_words(max_edges: u32) -> usize {
    strategy_columns(max_edges).pow(2).next_multiple_of(4)
}

/// The most edges of paths that the path tracer renders in the chains' place (`PATH_TRACED_EDGES`).
pub const PATH_TRACED_EDGES: u32 = 16;

/// Tiles of the film along its longer side, on which w of the two-stage target is constant, and words of their table,
/// which lies behind the strategy table.
pub const WEIGHT_TILES: u32 = 32;
pub const WEIGHT_ENTRIES: usize = 1024;

/// Rows of the chain state before the vertices (`ROW_VERTICES`), and the rows of the point on the lens (`ROW_LENS`, which
/// also has the last two words of long type keys), of the type key (`ROW_KEY`), of the pixel and of the colour.
pub const ROW_VERTICES: usize = 5;
pub const ROW_LENS: usize = 4;
pub const ROW_KEY: usize = 3;
pub const ROW_PIXEL: usize = 0;
pub const ROW_COLOUR: usize = 1;

/// Rows of a crossover's record, which lies where guides do (`ROW_RECORD`): those of the state before the vertices.
const RECORD_ROWS: usize = ROW_VERTICES;

/// First of the rows in the order of a pool (`ROW_GUIDE`): what guides tell, packed as in shaders/transport/guide.wesl.
pub fn row_guide(max_edges: u32) -> usize {
    ROW_VERTICES + 2 * max_edges as usize
}

/// Rows of vec4 that a chain with up to `max_edges` edges needs.
pub fn chain_rows(max_edges: u32) -> usize {
    row_guide(max_edges) + guide_rows(max_edges, true).max(RECORD_ROWS)
}

/// Rows of vec4 that a guide with up to `max_edges` edges needs: a word for the pixel and one a position, one a normal.
pub fn guide_rows(max_edges: u32, normals: bool) -> usize {
    let vertices = max_edges as usize;
    (1 + if normals { 2 * vertices } else { vertices }).div_ceil(4)
}

/// Twin of `unpack_position` in shaders/transport/guide.wesl: in the unit sphere's frame.
pub fn unpack_position(word: u32) -> [f64; 3] {
    [0, 10, 20].map(|shift| f64::from((word >> shift) & 1023) / 511.5 - 1.0)
}

/// Words of one kernel's counters, and which word counts what (`COUNTER_*`).
pub const COUNTER_WORDS: usize = 8;
pub const COUNTER_ACCEPTED: usize = 0;
pub const COUNTER_NON_FINITE: usize = 1;
pub const COUNTER_RAYS: usize = 2;
pub const COUNTER_JUMP_LOW: usize = 3;
pub const COUNTER_JUMP_HIGH: usize = 4;
pub const COUNTER_LONGEST_WAIT: usize = 5;
/// Bytes of the counters of a run with so many kernels; the last ones are for paths that rest because no kernel applies.
pub fn counter_bytes(kernels: usize) -> u64 {
    4 * (COUNTER_WORDS * (kernels + 1)) as u64
}

/// Counter units per px^2 of acceptance-weighted squared jump.
pub const JUMP_SCALE: f64 = 16.0;

/// Units per 1.0 of a film channel (`FILM_SCALE`).
pub const FILM_SCALE: f64 = 4_194_304.0;

/// First code of a light that is no triangle (`PUNCTUAL` in shaders/light/sources.wesl), and the code of what lies at
/// infinity (`NO_TRIANGLE`).
pub const PUNCTUAL: u32 = 0xff00_0000;
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Rows of vec4 a material takes in `tables` (`MATERIAL_ROWS`).
pub const MATERIAL_ROWS: usize = 4;
/// The same where materials have textures, an alpha or absorb light.
pub const EXTENDED_ROWS: usize = 8;
/// The same where materials have layers or are anisotropic.
pub const LAYERED_ROWS: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{Variant, compose, validate};
    use crate::scene::Features;
    use naga::{Literal, TypeInner};
    use std::mem::offset_of;

    fn module(pass: &'static str) -> naga::Module {
        let variant = Variant { pass, features: Features::default(), max_edges: 12, flags: vec![] };
        validate(&compose(&variant).unwrap()).unwrap()
    }

    fn struct_of(module: &naga::Module, name: &str) -> (Vec<(String, u32)>, u32) {
        module
            .types
            .iter()
            .find_map(|(_, t)| match &t.inner {
                TypeInner::Struct { members, span } if t.name.as_deref()?.ends_with(name) => {
                    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect();
                    Some((members, *span))
                }
                _ => None,
            })
            .unwrap_or_else(|| panic!("no struct {name}"))
    }

    macro_rules! same_layout {
        ($module:expr, $type:ident, $($field:ident),+ $(,)?) => {
            let (members, span) = struct_of($module, stringify!($type));
            let ours = vec![$((stringify!($field).to_string(), offset_of!($type, $field) as u32)),+];
            assert_eq!(members, ours);
            assert_eq!(span as usize, size_of::<$type>());
        };
    }

    #[test]
    fn structs_agree_with_the_shaders() {
        let lens = module("camera_side");
        same_layout!(
            &lens,
            SceneUniform,
            camera_position,
            pixel_area,
            camera_right,
            film_width,
            camera_up,
            film_height,
            camera_back,
            pixels_per_unit,
            sky,
            light_count,
            light_weight,
            lights_offset,
            lens_radius,
            focus_distance,
        );
        same_layout!(
            &lens,
            PassUniform,
            seed,
            pass_index,
            stride,
            entries,
            entries_offset,
            nodes_offset,
            guides_first,
            group_paths,
            similarity_scale,
            guides,
            alpha_low,
            alpha_high,
            weight,
            counters_offset,
            origins,
            keep,
            group_stride,
            path_traced_low,
            path_traced_high,
            path_traced_specular,
            photons_first,
            sightings_first,
        );
        let (_, span) = struct_of(&module("weigh"), "StrategyUniform");
        assert_eq!(span as usize, 4 * strategy_words(12));
        let flags = vec!["two_stage"];
        let two_stage = Variant { pass: "independence", features: Features::default(), max_edges: 12, flags };
        let module = validate(&compose(&two_stage).unwrap()).unwrap();
        let (members, span) = struct_of(&module, "StrategyUniform");
        assert_eq!(members[1].1 as usize, 4 * strategy_words(12));
        assert_eq!(span as usize, 4 * (strategy_words(12) + WEIGHT_ENTRIES));
    }

    #[test]
    fn constants_agree_with_the_shaders() {
        // With maps, which alone need COUNTER_WORDS.
        let (features, flags) = (Features::default(), vec!["maps"]);
        let lens = Variant { pass: "camera_side", features, max_edges: 12, flags };
        let lens = validate(&compose(&lens).unwrap()).unwrap();
        let value = |name: &str| {
            let (_, c) = lens
                .constants
                .iter()
                .find(|(_, c)| c.name.as_deref().is_some_and(|n| n.ends_with(name)))
                .unwrap_or_else(|| panic!("no constant {name}"));
            match lens.global_expressions[c.init] {
                naga::Expression::Literal(Literal::U32(v)) => v as f64,
                naga::Expression::Literal(Literal::F32(v)) => v as f64,
                ref other => panic!("{name}: {other:?}"),
            }
        };
        assert_eq!(value("ROW_VERTICES"), ROW_VERTICES as f64);
        assert_eq!(value("ROW_KEY"), ROW_KEY as f64);
        assert_eq!(value("COUNTER_WORDS"), COUNTER_WORDS as f64);
        assert_eq!(value("ROW_PIXEL"), ROW_PIXEL as f64);
        assert_eq!(value("ROW_COLOUR"), ROW_COLOUR as f64);
        assert_eq!(value("COUNTER_ACCEPTED"), COUNTER_ACCEPTED as f64);
        assert_eq!(value("COUNTER_NON_FINITE"), COUNTER_NON_FINITE as f64);
        assert_eq!(value("COUNTER_RAYS"), COUNTER_RAYS as f64);
        assert_eq!(value("COUNTER_JUMP_LOW"), COUNTER_JUMP_LOW as f64);
        assert_eq!(value("COUNTER_JUMP_HIGH"), COUNTER_JUMP_HIGH as f64);
        assert_eq!(value("COUNTER_LONGEST_WAIT"), COUNTER_LONGEST_WAIT as f64);
        assert_eq!(value("FILM_SCALE"), FILM_SCALE);
        assert_eq!(value("MATERIAL_ROWS"), MATERIAL_ROWS as f64);
        let features = Features { textured: true, ..Features::default() };
        let variant = Variant { pass: "camera_side", features, max_edges: 12, flags: vec![] };
        let textured = validate(&compose(&variant).unwrap()).unwrap();
        let rows =
            textured.constants.iter().find(|(_, c)| c.name.as_deref().is_some_and(|n| n.ends_with("MATERIAL_ROWS")));
        let init = textured.global_expressions[rows.unwrap().1.init].clone();
        assert_eq!(init, naga::Expression::Literal(Literal::U32(EXTENDED_ROWS as u32)));
    }
}
