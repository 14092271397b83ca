//! Shader composition: from the WESL modules under `shaders/` to one WGSL text per pipeline, with only what the scene and
//! the pass need. The only file that names the composer.

use std::borrow::Cow;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use include_dir::{Dir, include_dir};
use wesl::{CompileOptions, Feature, ModulePath, VirtualResolver, Wesl};

use super::layout::is_long;
use super::workgroups::WORKGROUP;
use crate::Error;
use crate::ensemble::guidance::MOST_GUIDES;
use crate::scene::Features;

static SOURCES: Dir = include_dir!("$CARGO_MANIFEST_DIR/shaders");

/// What one pipeline's shader is compiled for. A flag of any other name is an error.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Variant {
    /// File stem under `shaders/passes`.
    pub pass: &'static str,
    pub features: Features,
    /// Private arrays and loops are bounded by it; paths whose types do not fit two words set the flag `long`.
    pub max_edges: u32,
    /// Flags of the pass itself, out of [`PASS_FLAGS`].
    pub flags: Vec<&'static str>,
}

/// Flags that passes know besides the scene's features. `probe*` and `twin*` are compiled by tests alone: records
/// instead of splats, and deliberately wrong kernels that the tests must catch.
pub const PASS_FLAGS: [&str; 32] = [
    "guided",
    "multi_chain",
    "manifold",
    "walk",
    "kept_weights",
    "difference",
    "jump",
    "normals",
    "segment",
    "subpath",
    "light_side",
    "maps",
    "two_stage",
    "path_traced",
    "sought",
    "probe",
    "probe_back",
    "probe_still",
    "probe_density",
    "twin_one_sided",
    "twin_stop",
    "twin_id",
    "twin_redraw",
    "twin_places",
    "twin_lens",
    "twin_jacobian",
    "twin_spread",
    "twin_flat",
    "twin_way_back",
    "twin_acceptance",
    "twin_splat",
    "twin_blocked",
];

/// The shaders' modules: those built in, or a folder's in their place, for whoever works on them.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    /// Paths under `shaders` without their extension, and texts.
    folder: Option<Arc<[(String, String)]>>,
}

impl Sources {
    /// Reads a folder like `shaders`. An error names the file that cannot be read.
    pub fn read(folder: &Path) -> crate::Result<Self> {
        let mut modules = Vec::new();
        read_modules(folder, "", &mut modules)?;
        if modules.is_empty() {
            let folder = folder.display();
            return Err(Error::input(format!("{folder} holds no .wesl files: name a folder like shaders")));
        }
        Ok(Self { folder: Some(modules.into()) })
    }

    /// The WGSL text of `variant`. Fails only on a fault of the sources, with the composer's words.
    pub fn compose(&self, variant: &Variant) -> Result<String, String> {
        self.compose_for(variant, WORKGROUP)
    }

    /// The same for workgroups of so many threads.
    pub fn compose_for(&self, variant: &Variant, workgroup: u32) -> Result<String, String> {
        let mut resolver = VirtualResolver::new();
        match &self.folder {
            None => add_modules(&SOURCES, &mut resolver)?,
            Some(modules) => {
                for (inside, text) in modules.iter() {
                    resolver.add_module(module_path(inside)?, Cow::Borrowed(text));
                }
            }
        }
        compose_with(resolver, variant, workgroup)
    }
}

fn read_modules(folder: &Path, inside: &str, modules: &mut Vec<(String, String)>) -> crate::Result<()> {
    let failed = |path: &Path, why| Error::input(format!("{} cannot be read: {why}", path.display()));
    for entry in fs::read_dir(folder).map_err(|why| failed(folder, why))? {
        let path = entry.map_err(|why| failed(folder, why))?.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let inside = if inside.is_empty() { stem.into_owned() } else { format!("{inside}::{stem}") };
        if path.is_dir() {
            read_modules(&path, &inside, modules)?;
        } else if path.extension().is_some_and(|extension| extension == "wesl") {
            modules.push((inside, fs::read_to_string(&path).map_err(|why| failed(&path, why))?));
        }
    }
    Ok(())
}

/// The WGSL text of `variant` from the sources that are built in.
pub fn compose(variant: &Variant) -> Result<String, String> {
    Sources::default().compose(variant)
}

fn compose_with(mut resolver: VirtualResolver, variant: &Variant, workgroup: u32) -> Result<String, String> {
    let constants = [("MAX_EDGES", variant.max_edges), ("MOST_GUIDES", MOST_GUIDES), ("WORKGROUP", workgroup)];
    let constants: String = constants.iter().map(|(name, value)| format!("const {name}: u32 = {value}u;\n")).collect();
    resolver.add_module(module_path("specialised")?, Cow::Owned(constants));
    // naga validates what comes out.
    let mut options = CompileOptions { validate: false, ..Default::default() };
    options.features.default = Feature::Error;
    for (name, value) in variant.features.flags() {
        options.features.flags.insert(name.into(), value.into());
    }
    for name in &variant.flags {
        if !PASS_FLAGS.contains(name) {
            return Err(format!("unknown shader flag '{name}'"));
        }
    }
    for name in PASS_FLAGS {
        options.features.flags.insert(name.into(), variant.flags.contains(&name).into());
    }
    options.features.flags.insert("long".into(), is_long(variant.max_edges).into());
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
    compiler.set_options(options);
    compiler.set_mangler(wesl::ManglerKind::Escape);
    compiler
        .compile(&module_path(&format!("passes::{}", variant.pass))?)
        .map(|result| result.to_string())
        .map_err(|error| format!("{}: {error}", variant.pass))
}

fn module_path(inside: &str) -> Result<ModulePath, String> {
    format!("package::{inside}").parse().map_err(|error| format!("{inside}: {error}"))
}

fn add_modules<'a>(dir: &Dir<'a>, resolver: &mut VirtualResolver<'a>) -> Result<(), String> {
    for file in dir.files() {
        let inside = file.path().with_extension("");
        let inside = inside.to_str().unwrap_or_default().replace(['/', '\\'], "::");
        let text = file.contents_utf8().ok_or_else(|| format!("{inside} is not UTF-8"))?;
        resolver.add_module(module_path(&inside)?, Cow::Borrowed(text));
    }
    dir.dirs().try_for_each(|sub| add_modules(sub, resolver))
}

/// Parses and validates WGSL with naga, without a device.
pub fn validate(wgsl: &str) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::IMMEDIATES)
        .validate(&module)
        .map_err(|e| e.emit_to_string(wgsl))?;
    Ok(module)
}

#[cfg(test)]
mod tests;
