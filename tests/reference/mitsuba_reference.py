#!/usr/bin/env python3
"""Renders a .glb with Mitsuba 3: reference images, and a fourth row in equal-time comparisons.

Needs `pip install mitsuba numpy`; the LLVM variant also needs libLLVM (else scalar_rgb is used).

    mitsuba_reference.py SCENE.glb -o OUT.exr [--size WxH] [--spp N | --time S] [--batches B]
                         [--max-depth K] [--camera NAME] [--aperture DIAMETER --focus DISTANCE] [--seed N]
    mitsuba_reference.py --check-metal | --check-rough-glass

OUT.exr (32-bit float) has R, G, B: the mean over independent batches, and Variance.R, .G, .B: the
variance OF THAT MEAN, estimated from the spread of the batches. --spp is the total over all batches;
--time stops after the batch that passes S seconds (at least two; kernel compilation is not counted).

What is mapped, and to what (DESIGN.md, radiometry):
    Lambert (metallic 0, specularFactor 0)   twosided diffuse
    metal (metallic 1), alpha >= 1e-3        principled, metallic 1 (--check-metal compares it with glTF's formula)
    smooth white metal                       conductor without material, a perfect mirror
    glass (transmission 1, roughness 0)      dielectric, ior outside 1, base colour = transmittance per interface
    glass of roughness > 0, alpha >= 1e-3    roughdielectric, GGX, separable Smith, exact Fresnel; reflection untinted
                                             (--check-rough-glass compares it with Walter et al. 2007)
    emission                                 area emitter on the front side
    textures of base colour (Lambert, metal),
    of metallicRoughness (metal; its blue is
    to be 1) and of emission                 bitmap of the decoded texels times the factor, same filter and wrap
Everything else is refused rather than approximated. Path length: Mitsuba's max_depth counts edges from
the camera to the light, as emlt's --max-depth does (1 = only lights seen directly). No Russian roulette,
no clamping, box filter one pixel wide.
"""

import argparse
import json
import os
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

from exr_writer import write_exr

DELTA_ALPHA = 1e-3
COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def start_mitsuba():
    import mitsuba as mi

    # An LLVM that is missing instructions aborts the process, so the first try is a child's.
    # (Mitsuba 3.7 works from LLVM 15 on; 3.9 wants 17 or newer.)
    probe = ("import mitsuba as mi, drjit as dr; mi.set_variant('llvm_ad_rgb');"
             "dr.eval(dr.maximum(dr.opaque(mi.Float, 1.0), 0.5) + dr.opaque(mi.Float, 1.0))")
    works = subprocess.run([sys.executable, "-c", probe], capture_output=True, check=False).returncode == 0
    if not works:
        print("the LLVM variant does not work here: going on with scalar_rgb, which is slower", file=sys.stderr)
    mi.set_variant("llvm_ad_rgb" if works else "scalar_rgb")
    return mi


class Gltf:
    """As much of a glTF binary as the scenes use."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        magic, version, _ = struct.unpack_from("<III", data)
        if magic != 0x46546C67 or version != 2:
            sys.exit(f"{path} is no glTF 2.0 binary")
        self.json, self.binary, offset = None, b"", 12
        while offset < len(data):
            length, kind = struct.unpack_from("<II", data, offset)
            chunk = data[offset + 8 : offset + 8 + length]
            if kind == 0x4E4F534A:
                self.json = json.loads(chunk)
            elif kind == 0x004E4942:
                self.binary = chunk
            offset += 8 + length

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        shape, strides = (accessor["count"], width), (stride, kind.itemsize)
        return np.ndarray(shape, kind, self.binary, start, strides).copy()

    def nodes(self):
        """Every node of the scene with its world matrix."""
        scene = self.json["scenes"][self.json.get("scene", 0)]
        todo = [(i, np.eye(4)) for i in scene["nodes"]]
        while todo:
            index, parent = todo.pop(0)
            node = self.json["nodes"][index]
            world = parent @ local_matrix(node)
            yield node, world
            todo.extend((child, world) for child in node.get("children", []))


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


def texture_of(mi, gltf, info, decode):
    """A texture of what `decode` makes of texels in [0, 1], or an exit where Mitsuba has none like it."""
    if info.get("texCoord", 0) != 0 or "extensions" in info:
        sys.exit("only plain textures of the first coordinates are mapped")
    texture = gltf.json["textures"][info["index"]]
    sampler = gltf.json["samplers"][texture["sampler"]]
    view = gltf.json["bufferViews"][gltf.json["images"][texture["source"]]["bufferView"]]
    start = view.get("byteOffset", 0)
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        file.write(gltf.binary[start : start + view["byteLength"]])
        file.flush()
        texels = np.array(mi.Bitmap(file.name), np.float64)[..., :3] / 255.0
    if sampler["wrapS"] != sampler["wrapT"]:
        sys.exit("a texture wraps otherwise along than across, which is not mapped")
    # Raw: decoded here, before the filter, as glTF wants it.
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(decode(texels), np.float32)), "raw": True,
            "filter_type": {9728: "nearest", 9729: "bilinear"}[sampler["magFilter"]],
            "wrap_mode": WRAPS[sampler["wrapS"]]}


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def bsdf_of(mi, gltf, material):
    """The BSDF that equals a glTF material exactly, or an exit that says why there is none."""
    name = material.get("name", "without a name")
    base = material.get("pbrMetallicRoughness", {})
    color = base.get("baseColorFactor", [1, 1, 1, 1])[:3]
    metallic, roughness = base.get("metallicFactor", 1.0), base.get("roughnessFactor", 1.0)
    extensions = material.get("extensions", {})
    if "normalTexture" in material:
        sys.exit(f"material {name}: textures of normals are not mapped")
    painted = "baseColorTexture" in base or "metallicRoughnessTexture" in base
    tint = rgb(color)
    if "baseColorTexture" in base:
        tint = texture_of(mi, gltf, base["baseColorTexture"], lambda t: linear(t) * color)
    uneven = float(roughness)
    if "metallicRoughnessTexture" in base:
        # Mitsuba squares the roughness after the filter, as emlt does.
        uneven = texture_of(mi, gltf, base["metallicRoughnessTexture"], lambda t: t[..., 1:2] * roughness)
    if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0) > 0.0:
        if painted:
            sys.exit(f"material {name}: textures of glass are not mapped")
        thick = extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0.0) > 0.0
        whole = extensions["KHR_materials_transmission"]["transmissionFactor"] == 1.0
        if not thick or not whole or 0.0 < roughness**2 < DELTA_ALPHA or metallic > 0.0:
            sys.exit(f"material {name}: only solid, fully transmitting glass, smooth or of alpha >= 1e-3, is mapped")
        return glass(color, roughness, extensions.get("KHR_materials_ior", {}).get("ior", 1.5))
    if metallic == 1.0 and roughness**2 >= DELTA_ALPHA:
        return twosided(metal(tint, uneven))
    if metallic == 1.0 and not painted and color == [1, 1, 1]:
        return twosided({"type": "conductor", "material": "none"})
    if metallic == 0.0 and extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0) == 0.0:
        return twosided({"type": "diffuse", "reflectance": tint})
    sys.exit(f"material {name}: neither Lambertian, metal nor glass, so it has no exact counterpart")


def metal(tint, roughness):
    return {"type": "principled", "base_color": tint, "metallic": 1.0, "roughness": roughness}


def glass(color, roughness, ior):
    kind = {"type": "dielectric"}
    if roughness > 0.0:
        # Drawing from the visible normals changes the noise, not the BSDF.
        kind = {"type": "roughdielectric", "distribution": "ggx", "alpha": float(roughness**2), "sample_visible": True}
    return kind | {"int_ior": ior, "ext_ior": 1.0, "specular_transmittance": rgb(color),
                   "specular_reflectance": rgb([1, 1, 1])}


def twosided(bsdf):
    return {"type": "twosided", "bsdf": bsdf}


def emission_of(material):
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    return np.array(material.get("emissiveFactor", [0, 0, 0]), float) * strength


def write_ply(path, positions, normals, coordinates, triangles):
    fields = ["x", "y", "z"] + (["nx", "ny", "nz"] if normals is not None else [])
    fields += ["u", "v"] if coordinates is not None else []
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    header += [f"property float {field}" for field in fields]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    vertices = np.hstack([part for part in (positions, normals, coordinates) if part is not None])
    faces = np.zeros(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    with open(path, "wb") as file:
        file.write("\n".join(header).encode())
        file.write(vertices.astype("<f4").tobytes())
        file.write(faces.tobytes())


def shapes_of(mi, gltf, folder):
    """One Mitsuba shape per glTF primitive, in world space."""
    shapes = {}
    for node, world in gltf.nodes():
        if "mesh" not in node:
            continue
        normal_matrix = np.linalg.inv(world[:3, :3]).T
        for primitive in gltf.json["meshes"][node["mesh"]]["primitives"]:
            if primitive.get("mode", 4) != 4:
                sys.exit("only triangles are mapped")
            material = gltf.json["materials"][primitive["material"]]
            attributes = primitive["attributes"]
            positions = gltf.array(attributes["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            triangles = gltf.array(primitive["indices"]).reshape(-1, 3).astype(np.int64)
            emission = emission_of(material)
            # A light's front is that of its triangles, whatever its shading normals say.
            smooth = "NORMAL" in attributes and not emission.any()
            normals = None
            if smooth:
                normals = gltf.array(attributes["NORMAL"]) @ normal_matrix.T
                normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            name = f"shape_{len(shapes):04d}"
            path = os.path.join(folder, name + ".ply")
            coordinates = gltf.array(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None
            write_ply(path, positions, normals, coordinates, triangles)
            shapes[name] = {"type": "ply", "filename": path, "face_normals": not smooth, "bsdf": bsdf_of(mi, gltf, material)}
            if emission.any():
                if material.get("doubleSided"):
                    sys.exit("lights that shine on both sides are not mapped")
                radiance = rgb(emission)
                if "emissiveTexture" in material:
                    radiance = texture_of(mi, gltf, material["emissiveTexture"], lambda t: linear(t) * emission)
                shapes[name]["emitter"] = {"type": "area", "radiance": radiance}
    return shapes


def sensor_of(mi, gltf, name, size, lens=None):
    for node, world in gltf.nodes():
        if "camera" not in node:
            continue
        camera = gltf.json["cameras"][node["camera"]]
        if name in (None, node.get("name"), camera.get("name")):
            # glTF's camera looks along -z with +x to the right, Mitsuba's along +z with +x to the left.
            turned = world @ np.diag([-1.0, 1.0, -1.0, 1.0])
            opening = {"type": "perspective"}
            if lens:
                opening = {"type": "thinlens", "aperture_radius": 0.5 * lens[0], "focus_distance": lens[1]}
            return opening | {
                "fov_axis": "y",
                "fov": float(np.degrees(camera["perspective"]["yfov"])),
                "near_clip": 1e-3,
                "to_world": mi.ScalarTransform4f(turned.tolist()),
                "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "component_format": "float32",
                         "pixel_format": "rgb", "rfilter": {"type": "box"}},
                "sampler": {"type": "independent"},
            }
    sys.exit(f"no camera called {name}" if name else "the scene has no camera")


def load(mi, path, size, max_depth, camera, lens=None):
    gltf = Gltf(path)
    with tempfile.TemporaryDirectory() as folder:
        scene = {"type": "scene", "sensor": sensor_of(mi, gltf, camera, size, lens)}
        scene["integrator"] = {"type": "path", "max_depth": max_depth, "rr_depth": 1_000_000, "hide_emitters": False}
        scene.update(shapes_of(mi, gltf, folder))
        return mi.load_dict(scene)


def render(mi, scene, spp, seconds, batches, seed):
    """Mean and variance of the mean per pixel and channel, batches, samples per batch, seconds."""
    width, height = scene.sensors()[0].film().size()
    # One launch has at most about four million paths, which bounds the memory.
    room = max(1, 4_000_000 // (width * height))
    if seconds is None:
        batches = max(batches, -(-spp // room))
        per_batch = max(1, -(-spp // batches))
    else:
        per_batch = max(1, min(room, spp)) if spp else max(1, room // 4)
    image = lambda i: np.array(mi.render(scene, spp=per_batch, seed=seed * 1_000_003 + i), np.float64)  # noqa: E731
    image(2**20)  # Compiles; its samples are thrown away.
    started, done = time.perf_counter(), 0
    total, squares = np.zeros((height, width, 3)), np.zeros((height, width, 3))
    while done < batches if seconds is None else done < 2 or time.perf_counter() - started < seconds:
        batch = image(done)
        total += batch
        squares += batch**2
        done += 1
    elapsed = time.perf_counter() - started
    mean = total / done
    spread = np.maximum(squares / done - mean**2, 0.0) * done / max(done - 1, 1)
    return mean, spread / done, done, per_batch, elapsed


def tile_error(mean, variance, tile=8):
    """Relative standard error of the luminance of tiles, channels taken as fully correlated."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    height, width = (n - n % tile for n in mean.shape[:2])
    cut = lambda a: a[:height, :width].reshape(height // tile, tile, width // tile, tile)  # noqa: E731
    level = cut(mean @ weights).mean((1, 3))
    error = np.sqrt(cut((np.sqrt(variance) @ weights) ** 2).sum((1, 3))) / tile**2
    return error / np.maximum(level, 1e-9)


def evaluated(mi, bsdf, wi, wo):
    """The BSDF times the cosine to wo for every pair of local directions."""
    bsdf, si, values = mi.load_dict(bsdf), mi.SurfaceInteraction3f(), np.zeros((len(wi), 3))
    for i in range(len(wi)) if mi.variant().startswith("scalar") else [slice(None)]:
        si.wi = mi.Vector3f(*np.ascontiguousarray(wi[i].T))
        values[i] = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*np.ascontiguousarray(wo[i].T)))).T
    return values


def directions(random, n):
    w = random.normal(size=(n, 3))
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def ggx(a2, cosine):
    return a2 / (np.pi * (cosine**2 * (a2 - 1) + 1) ** 2)


def smith(a2, cosine):
    return 2 * cosine / (cosine + np.sqrt(a2 + (1 - a2) * cosine**2))


def check_metal(mi):
    """Largest relative deviation of the metal's BSDF from glTF 2.0, appendix B (separable Smith)."""
    random, worst = np.random.default_rng(1), 0.0
    for color, roughness in (([0.95, 0.7, 0.4], 0.2), ([0.9, 0.6, 0.45], 0.45), ([0.5, 0.9, 0.2], 1.0)):
        wi, wo = (directions(random, 4096) for _ in range(2))
        wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
        half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        a2, nl, nv = roughness**4, wo[:, 2], wi[:, 2]
        schlick = (1 - (wi * half).sum(1, keepdims=True)) ** 5
        fresnel = np.array(color) + (1 - np.array(color)) * schlick
        expected = fresnel * (ggx(a2, half[:, 2]) * smith(a2, nl) * smith(a2, nv) / (4 * nv))[:, None]
        deviation = np.abs(evaluated(mi, twosided(metal(rgb(color), roughness)), wi, wo) - expected)
        deviation = (deviation / expected.max(1, keepdims=True)).max()
        print(f"metal, roughness {roughness}: largest relative deviation {deviation:.2e}")
        worst = max(worst, deviation)
    return worst


def check_rough_glass(mi):
    """The same for rough glass: Walter et al. 2007 for radiance, which is carried from wo (light) to wi (camera)."""
    random, worst, color = np.random.default_rng(1), 0.0, np.array([0.9, 0.6, 0.3])
    for roughness, ior in ((0.25, 1.5), (0.5, 1.5), (0.8, 1.33)):
        wi, wo = directions(random, 20000), directions(random, 20000)
        nc, nl = (np.where(w[:, 2] > 0, 1.0, ior) for w in (wi, wo))
        m = nc[:, None] * wi + nl[:, None] * wo
        # Where both are on one side this is the half vector; else minus or plus it, and its length is the Jacobian's.
        length = np.linalg.norm(m, axis=1)
        m *= (np.sign(m[:, 2]) / length)[:, None]
        cm, lm = (wi * m).sum(1), (wo * m).sum(1)
        # The floor keeps single precision's cancellation out of the comparison.
        fits = (cm * wi[:, 2] > 0.02) & (lm * wo[:, 2] > 0.02) & (length > 0.2)
        reflects = wi[:, 2] * wo[:, 2] > 0
        far = np.where(cm > 0, ior, 1.0)  # Index beyond the microfacet as wi sees it.
        sin2 = (1 - cm**2) * (nc / far) ** 2
        ct = np.sqrt(np.maximum(1 - sin2, 0.0))
        c = np.abs(cm)
        s, p = (nc * c - far * ct) / (nc * c + far * ct), (far * c - nc * ct) / (far * c + nc * ct)
        fresnel = np.where(sin2 >= 1, 1.0, 0.5 * (s**2 + p**2))
        a2 = roughness**4
        dg = ggx(a2, m[:, 2]) * smith(a2, np.abs(wi[:, 2])) * smith(a2, np.abs(wo[:, 2])) / np.abs(wi[:, 2])
        through = (1 - fresnel) * dg * np.abs(cm * lm) * nc**2 / length**2
        expected = np.where(reflects, fresnel * dg / 4, through)[:, None] * np.where(reflects[:, None], 1.0, color)
        actual = evaluated(mi, glass(color, roughness, ior), wi, wo)
        deviation = (np.abs(actual - expected) / np.maximum(expected.max(1, keepdims=True), 1e-4))[fits].max()
        print(f"rough glass, roughness {roughness}: largest relative deviation {deviation:.2e} in {fits.sum()} pairs, "
              f"{(fits & ~reflects).sum()} of them refractions")
        worst = max(worst, deviation)
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene", nargs="?")
    parser.add_argument("-o", "--output")
    parser.add_argument("--size", default="96x72", help="WxH in pixels")
    parser.add_argument("--spp", type=int, help="samples per pixel, all batches together (with --time: per batch)")
    parser.add_argument("--time", type=float, help="seconds of rendering")
    parser.add_argument("--batches", type=int, default=64)
    parser.add_argument("--max-depth", type=int, default=12, help="path edges from camera to light")
    parser.add_argument("--camera")
    parser.add_argument("--aperture", type=float, help="diameter of a thin lens, in the scene's units")
    parser.add_argument("--focus", type=float, help="distance along the viewing axis of the plane in focus")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--check-metal", action="store_true")
    parser.add_argument("--check-rough-glass", action="store_true")
    options = parser.parse_args()
    mi = start_mitsuba()
    for wanted, check in ((options.check_metal, check_metal), (options.check_rough_glass, check_rough_glass)):
        if wanted:
            sys.exit(0 if check(mi) < 1e-3 else 1)
    if not options.scene or not options.output:
        parser.error("a scene and -o OUT.exr are needed")
    size = tuple(int(n) for n in options.size.split("x"))
    if (options.aperture is None) != (options.focus is None):
        parser.error("--aperture and --focus come together")
    lens = options.aperture and (options.aperture, options.focus)
    scene = load(mi, options.scene, size, options.max_depth, options.camera, lens)
    spp = options.spp if options.spp or options.time else 1024
    mean, variance, batches, per_batch, elapsed = render(
        mi, scene, spp, options.time, max(2, options.batches), options.seed)
    facts = {"spp": batches * per_batch, "batches": batches, "maxDepth": options.max_depth, "seed": options.seed,
             "seconds": round(elapsed, 1), **({"aperture": lens[0], "focus": lens[1]} if lens else {}), "renderer": f"Mitsuba {mi.__version__} {mi.variant()}, path"}
    layers = {name: mean[..., i] for i, name in enumerate("RGB")}
    layers.update({f"Variance.{name}": variance[..., i] for i, name in enumerate("RGB")})
    write_exr(options.output, layers, facts)
    errors = tile_error(mean, variance)
    facts["mean"] = round(float((mean @ [0.2126, 0.7152, 0.0722]).mean()), 5)
    facts["tile error % (median, 90 %, largest)"] = [
        round(100 * float(np.quantile(errors, q)), 3) for q in (0.5, 0.9, 1.0)]
    print(os.path.basename(options.scene), json.dumps(facts))


if __name__ == "__main__":
    main()
