//! A room of matt surfaces, smooth glass and mirrors in f64, written from METHOD.md (sections 0 and 2) apart from the
//! shaders: what contributes how much along a sweep.

use emlt::gpu::scene::SceneData;
use emlt::scene::{LUMINANCE, Material, Scene};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

pub const DIFFUSE: u32 = 0;
const REFLECT: u32 = 1;

/// A point of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    pub triangle: usize,
    pub position: DVec3,
    pub ng: DVec3,
    pub ns: DVec3,
    pub material: usize,
}

struct Triangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normals: [DVec3; 3],
    material: usize,
}

/// A path whose ends a kernel keeps: its vertices from the light, and the classes of their scattering.
pub struct Held {
    pub tags: Vec<u32>,
    pub points: Vec<Point>,
    pub pixel: DVec2,
}

impl Held {
    pub fn edges(&self) -> usize {
        self.points.len()
    }

    pub fn direction(&self, from: usize, to: usize) -> DVec3 {
        (self.points[to].position - self.points[from].position).normalize()
    }
}

pub struct Room {
    triangles: Vec<Triangle>,
    materials: Vec<Material>,
    eye: DVec3,
    /// Right, up, back.
    axes: [DVec3; 3],
    film: DVec2,
    pixels_per_unit: f64,
}

/// Any orthonormal pair for a unit vector.
fn frame(n: DVec3) -> [DVec3; 2] {
    let helper = if n.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let tangent = n.cross(helper).normalize();
    [tangent, n.cross(tangent)]
}

/// The direction with Lambert's azimuthal coordinates `t` about `w`: |t| is the distance of the two, and areas in t are
/// solid angles.
pub fn turned(w: DVec3, t: DVec2) -> DVec3 {
    let [a, b] = frame(w);
    let t2 = t.length_squared();
    ((1.0 - 0.5 * t2) * w + (1.0 - 0.25 * t2).max(0.0).sqrt() * (t.x * a + t.y * b)).normalize()
}

/// The coordinates of `there` about `w`.
pub fn turn_to(w: DVec3, there: DVec3) -> DVec2 {
    let [a, b] = frame(w);
    DVec2::new(there.dot(a), there.dot(b)) * (2.0 / (w + there).length().max(1e-9))
}

fn decoded(word: u32) -> DVec3 {
    let [x, y] = [word as u16 as i16, (word >> 16) as u16 as i16].map(|s| f64::from(s) / 32767.0);
    let mut v = DVec3::new(x, y, 1.0 - x.abs() - y.abs());
    let t = (-v.z).max(0.0);
    v.x += if v.x >= 0.0 { -t } else { t };
    v.y += if v.y >= 0.0 { -t } else { t };
    v.normalize()
}

fn double([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

/// Whether both normals see `w` on one side.
fn agrees(p: &Point, w: DVec3) -> bool {
    w.dot(p.ng) * w.dot(p.ns) > 0.0
}

fn colour(c: glam::Vec3) -> DVec3 {
    DVec3::from(c)
}

impl Room {
    /// The scene as the device has it.
    pub fn new(scene: &Scene, data: &SceneData) -> Self {
        for m in &scene.materials {
            let plain = m.roughness == 0.0 || m.roughness == 1.0 && m.specular == 0.0 && m.metallic == 0.0;
            assert!(plain && m.is_plain(), "{} is not matt, smooth glass or a mirror", m.name);
        }
        let rows = |i: usize| [0, 1, 2].map(|k| double(data.triangles[3 * i + k][..3].try_into().unwrap()));
        let triangle = |(i, shading): (usize, &[u32; 4])| {
            let [corner, first, second] = rows(i);
            let normals = [0, 1, 2].map(|k| decoded(shading[k]));
            Triangle { corner, edges: [first, second], normals, material: shading[3] as usize }
        };
        let u = &data.uniform;
        Self {
            triangles: data.shading.iter().enumerate().map(triangle).collect(),
            materials: scene.materials.clone(),
            eye: double(u.camera_position),
            axes: [u.camera_right, u.camera_up, u.camera_back].map(double),
            film: DVec2::new(u.film_width.into(), u.film_height.into()),
            pixels_per_unit: u.pixels_per_unit.into(),
        }
    }

    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    pub fn towards_eye(&self, p: &Point) -> DVec3 {
        (self.eye - p.position).normalize()
    }

    pub fn point(&self, triangle: usize, u: f64, v: f64) -> Point {
        let t = &self.triangles[triangle];
        let ns = (1.0 - u - v) * t.normals[0] + u * t.normals[1] + v * t.normals[2];
        Point {
            triangle,
            position: t.corner + u * t.edges[0] + v * t.edges[1],
            ng: t.edges[0].cross(t.edges[1]).normalize(),
            ns: ns.normalize(),
            material: t.material,
        }
    }

    /// Where a ray meets triangle `i`: distance and barycentrics.
    fn meets(&self, i: usize, origin: DVec3, direction: DVec3) -> Option<[f64; 3]> {
        let t = &self.triangles[i];
        let p = direction.cross(t.edges[1]);
        let determinant = t.edges[0].dot(p);
        let s = (origin - t.corner) / determinant;
        let u = s.dot(p);
        let q = s.cross(t.edges[0]);
        let v = direction.dot(q);
        (determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| [t.edges[1].dot(q), u, v])
    }

    fn hit(&self, origin: DVec3, direction: DVec3, skip: Option<usize>) -> Option<Point> {
        let mut nearest: Option<(usize, [f64; 3])> = None;
        for i in (0..self.triangles.len()).filter(|i| Some(*i) != skip) {
            if let Some(met) = self.meets(i, origin, direction)
                && met[0] > 1e-7
                && nearest.is_none_or(|(_, n)| met[0] < n[0])
            {
                nearest = Some((i, met));
            }
        }
        nearest.map(|(i, [_, u, v])| self.point(i, u, v))
    }

    fn sees(&self, a: DVec3, b: DVec3, ends: [Option<usize>; 2]) -> bool {
        let blocks = |i: usize| self.meets(i, a, b - a).is_some_and(|[t, ..]| t > 1e-7 && t < 1.0 - 1e-7);
        !(0..self.triangles.len()).any(|i| !ends.contains(&Some(i)) && blocks(i))
    }

    fn camera_direction(&self, pixel: DVec2) -> DVec3 {
        let film = (pixel - 0.5 * self.film) / self.pixels_per_unit;
        (film.x * self.axes[0] - film.y * self.axes[1] - self.axes[2]).normalize()
    }

    pub fn on_film(&self, pixel: DVec2) -> bool {
        pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(self.film).all()
    }

    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        let depth = -direction.dot(self.axes[2]);
        let film = DVec2::new(direction.dot(self.axes[0]), -direction.dot(self.axes[1])) / depth;
        let pixel = film * self.pixels_per_unit + 0.5 * self.film;
        (depth > 0.0 && self.on_film(pixel)).then_some(pixel)
    }

    /// A matt surface's BSDF; zero where there is none, or the directions lie on two sides.
    fn matt(&self, p: &Point, a: DVec3, b: DVec3) -> DVec3 {
        let m = &self.materials[p.material];
        let one_side = agrees(p, a) && agrees(p, b) && a.dot(p.ns) * b.dot(p.ns) > 0.0;
        let share = f64::from((1.0 - m.metallic) * (1.0 - m.transmission));
        if one_side { colour(m.base_color) * (share / PI) } else { DVec3::ZERO }
    }

    pub fn emitted(&self, p: &Point, w: DVec3) -> DVec3 {
        let m = &self.materials[p.material];
        if m.double_sided || w.dot(p.ng) > 0.0 { colour(m.emission) } else { DVec3::ZERO }
    }

    /// What a vertex of class `tag` has of colour, whatever the directions.
    fn tint(&self, p: &Point, tag: u32) -> DVec3 {
        let m = &self.materials[p.material];
        if tag == REFLECT && m.metallic == 0.0 { DVec3::ONE } else { colour(m.base_color) }
    }

    /// Where light goes on that came along -`w`, how much of it, and the index there over that here.
    fn specular(&self, p: &Point, w: DVec3, tag: u32) -> Option<(DVec3, DVec3, f64)> {
        let m = &self.materials[p.material];
        if m.roughness != 0.0 || !agrees(p, w) {
            return None;
        }
        let n = if w.dot(p.ns) > 0.0 { p.ns } else { -p.ns };
        let cosine = w.dot(n);
        let eta = if w.dot(p.ng) > 0.0 { f64::from(m.ior) } else { 1.0 / f64::from(m.ior) };
        let sin2 = (1.0 - cosine * cosine) / (eta * eta);
        let there = (1.0 - sin2).max(0.0).sqrt();
        let parallel = (eta * cosine - there) / (eta * cosine + there);
        let across = (cosine - eta * there) / (cosine + eta * there);
        let fresnel = if sin2 >= 1.0 { 1.0 } else { 0.5 * (parallel * parallel + across * across) };
        let (out, amount, eta) = if tag == REFLECT {
            let glass = f64::from(m.transmission) * fresnel;
            (2.0 * cosine * n - w, if m.metallic > 0.0 { DVec3::ONE } else { DVec3::splat(glass) }, 1.0)
        } else {
            let amount = f64::from((1.0 - m.metallic) * m.transmission) * (1.0 - fresnel);
            ((cosine / eta - there) * n - w / eta, colour(m.base_color) * amount, eta)
        };
        (agrees(p, out) && amount.max_element() > 0.0).then_some((out.normalize(), amount, eta))
    }

    /// Of the vertices before `end`: the light's colour and all tints.
    fn tints(&self, held: &Held, end: usize) -> DVec3 {
        let light = colour(self.materials[held.points[0].material].emission);
        (1..end).fold(light, |c, i| c * self.tint(&held.points[i], held.tags[i]))
    }

    /// C of a sweep from the camera to vertex `j` (METHOD.md 2.3, 2.5), but for what x and y share: through `pixel`, turned
    /// by `turns` at matt vertices on the way.
    pub fn camera_sweep(&self, held: &Held, j: usize, pixel: DVec2, turns: &[DVec2]) -> f64 {
        self.camera_sweep_colour(held, j, pixel, turns).map_or(0.0, |c| c.dot(LUMINANCE))
    }

    fn camera_sweep_colour(&self, held: &Held, j: usize, pixel: DVec2, turns: &[DVec2]) -> Option<DVec3> {
        let (mut origin, mut skip) = (self.eye, None);
        let mut direction = self.on_film(pixel).then(|| self.camera_direction(pixel))?;
        let mut c = DVec3::ONE;
        let mut turns = turns.iter();
        for i in (j + 1..held.edges()).rev() {
            let p = self.hit(origin, direction, skip)?;
            let w = if held.tags[i] == DIFFUSE {
                let w = turned(held.direction(i, i - 1), *turns.next()?);
                c *= self.matt(&p, w, -direction) * w.dot(p.ns).abs();
                w
            } else {
                let (w, amount, eta) = self.specular(&p, -direction, held.tags[i])?;
                // Radiance: (n on the camera's side over n on the light's)^2.
                c *= amount / (eta * eta);
                w
            };
            (origin, direction, skip) = (p.position, w, Some(p.triangle));
        }
        let y = self.hit(origin, direction, skip)?;
        if j == 0 {
            return Some(c * self.emitted(&y, -direction));
        }
        let kept = &held.points[j - 1];
        let way = y.position - kept.position;
        let w = way.normalize();
        let source = if j == 1 {
            self.emitted(kept, w)
        } else {
            self.tints(held, j - 1) * self.matt(kept, held.direction(j - 1, j - 2), w)
        };
        let g = w.dot(kept.ng).abs() * w.dot(y.ns).abs() / way.length_squared();
        let clear = self.sees(kept.position, y.position, [Some(kept.triangle), Some(y.triangle)]);
        clear.then(|| c * source * self.matt(&y, -w, -direction) * g)
    }

    /// C of a sweep from vertex `l` towards the camera with its first direction turned (METHOD.md 2.4), likewise.
    pub fn light_sweep(&self, held: &Held, l: usize, turn: DVec2) -> f64 {
        self.light_sweep_colour(held, l, turn).map_or(0.0, |c| c.dot(LUMINANCE))
    }

    fn light_sweep_colour(&self, held: &Held, l: usize, turn: DVec2) -> Option<DVec3> {
        let start = &held.points[l];
        let mut w = turned(held.direction(l, l + 1), turn);
        let source = if l == 0 {
            self.emitted(start, w)
        } else {
            self.tints(held, l) * self.matt(start, held.direction(l, l - 1), w)
        };
        let mut c = source * w.dot(start.ng).abs();
        let (mut origin, mut skip) = (start.position, start.triangle);
        for i in l + 1..held.edges() {
            let p = self.hit(origin, w, Some(skip))?;
            c *= w.dot(p.ns).abs() / w.dot(p.ng).abs();
            if i + 1 == held.edges() {
                let way = self.eye - p.position;
                let onward = way.normalize();
                self.pixel_of(-onward)?;
                let cosine = onward.dot(self.axes[2]);
                let g = onward.dot(p.ng).abs() / (way.length_squared() * cosine.powi(3));
                let clear = self.sees(p.position, self.eye, [Some(p.triangle), None]);
                return clear.then(|| c * self.matt(&p, -w, onward) * g);
            }
            let (out, amount, _) = self.specular(&p, -w, held.tags[i])?;
            c *= amount * (out.dot(p.ng).abs() / out.dot(p.ns).abs());
            (origin, w, skip) = (p.position, out, p.triangle);
        }
        None
    }

    /// f of matt vertices `between` two kept ones of `held`, `before` and `after`, over that of the path itself.
    pub fn stretch(&self, held: &Held, before: usize, after: usize, between: &[Point]) -> f64 {
        let way_of = |between: &[Point]| [&held.points[before..=before], between, &held.points[after..=after]].concat();
        let way = way_of(between);
        let clear = |a: &Point, b: &Point| self.sees(a.position, b.position, [Some(a.triangle), Some(b.triangle)]);
        if !way.windows(2).all(|pair| clear(&pair[0], &pair[1])) {
            return 0.0;
        }
        self.along(held, before, after, &way)
            / self.along(held, before, after, &way_of(&held.points[before + 1..after]))
    }

    /// f of a path that goes the `way` from vertex `before` to vertex `after`, but for what the rest has besides colour.
    fn along(&self, held: &Held, before: usize, after: usize, way: &[Point]) -> f64 {
        let light = colour(self.materials[held.points[0].material].emission);
        let rest = (1..held.edges()).filter(|i| *i < before || *i > after);
        let mut c = rest.fold(light, |c, i| c * self.tint(&held.points[i], held.tags[i]));
        let beyond = held.points.get(after + 1).map_or(self.eye, |p| p.position);
        for (n, p) in way.iter().enumerate() {
            let back = if n == 0 { held.points[before - 1].position } else { way[n - 1].position };
            let onward = way.get(n + 1).map_or(beyond, |p| p.position);
            c *= self.matt(p, (back - p.position).normalize(), (onward - p.position).normalize());
            if n > 0 {
                let edge = p.position - back;
                let w = edge.normalize();
                c *= way[n - 1].ng.dot(w).abs() * p.ns.dot(w).abs() / edge.length_squared();
            }
        }
        c.dot(LUMINANCE)
    }

    /// A point that a ray from `p` finds, its direction drawn by the cosine on the side of `w`; with its density per area.
    pub fn scattered(&self, p: &Point, w: DVec3, u: [f64; 2]) -> Option<(Point, f64)> {
        let n = if w.dot(p.ns) > 0.0 { p.ns } else { -p.ns };
        let [a, b] = frame(n);
        let (r, phi) = (u[0].sqrt(), 2.0 * PI * u[1]);
        let out = r * phi.cos() * a + r * phi.sin() * b + (1.0 - u[0]).sqrt() * n;
        let found = self.hit(p.position, out, Some(p.triangle))?;
        let way = found.position - p.position;
        Some((found, out.dot(n) / PI * out.dot(found.ng).abs() / way.length_squared()))
    }
}
