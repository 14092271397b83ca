// A picture, as it is, over the whole viewport: egui's own shader would work through a software filter for every pixel on
// drivers that do not branch.

struct Part {
    // Of the texture, in [0, 1]: what is at the viewport's upper left corner, and what its width and height show.
    corner: vec2<f32>,
    extent: vec2<f32>,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var filtered: sampler;
@group(0) @binding(2) var<uniform> part: Part;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

// One triangle that covers the viewport.
@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let at = vec2<f32>(f32(index & 1u), f32(index >> 1u)) * 2.0;
    let position = vec4<f32>(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0);
    return Corner(position, part.corner + at * part.extent);
}

@fragment
fn color(in: Corner) -> @location(0) vec4<f32> {
    return textureSample(picture, filtered, in.uv);
}
