//! Generates every scene of the repository: `cargo run --release --example scenes`.
//! Metres, +y up. The output depends on nothing but this code.

mod ajar;
mod bathroom;
mod checks;
mod cornell;
mod crockery;
mod displaced_wall;
mod fittings;
mod furniture;
mod glb;
mod implicit;
mod kitchen;
mod mesh;
mod mirrors;
mod pool;
mod random;
mod ring;
mod rough_glass;
mod shapes;
mod shards;
mod sky;
mod slit;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scenes = [
        ("scenes/cornell.glb", cornell::build()),
        ("scenes/ajar.glb", ajar::build()),
        ("scenes/shards.glb", shards::build()),
        ("scenes/ring.glb", ring::build()),
        ("scenes/slit.glb", slit::build()),
        ("scenes/mirrors.glb", mirrors::build()),
        ("scenes/rough_glass.glb", rough_glass::build()),
        ("scenes/pool.glb", pool::build(0.004)),
        ("scenes/kitchen.glb", kitchen::build()),
        ("scenes/displaced_wall.glb", displaced_wall::build()),
        ("scenes/bathroom.glb", bathroom::build()),
        ("tests/scenes/coloured_box.glb", checks::coloured_box()),
        ("tests/scenes/pool_wide_lamp.glb", pool::build(0.06)),
        ("tests/scenes/lamp_in_glass.glb", checks::lamp_in_glass()),
        ("tests/scenes/glossy_box.glb", checks::glossy_box()),
        ("tests/scenes/layered_box.glb", checks::layered_box()),
        ("tests/scenes/textured_box.glb", checks::textured_box()),
        ("tests/scenes/furnace.glb", checks::furnace()),
        ("tests/scenes/sphere_over_plane.glb", checks::sphere_over_plane()),
    ];
    for (path, scene) in scenes {
        let triangles = scene.triangles();
        let file = scene.finish();
        println!("{path}: {triangles} triangles, {} bytes", file.len());
        let path = root.join(path);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        std::fs::write(path, file)?;
    }
    let sky = sky::evening().radiance();
    println!("scenes/sky.hdr: {} bytes", sky.len());
    std::fs::write(root.join("scenes/sky.hdr"), sky)
}
