//! Vessels for the table, standing on y = 0, spouts to +x.

use crate::implicit::{blend, chain, ellipsoid, surface};
use crate::mesh::Mesh;
use crate::shapes::{self, lathe, rod, smooth_profile, spline};
use glam::{Vec2, Vec3};

/// A round teapot of about 30 cm, one closed skin from smooth distance functions.
pub fn teapot(cell: f32) -> Mesh {
    let spout = spline(
        &[
            [0.060, 0.050, 0.0, 0.028],
            [0.112, 0.072, 0.0, 0.019],
            [0.134, 0.112, 0.0, 0.0125],
            [0.160, 0.142, 0.0, 0.0105],
        ],
        6,
    );
    let handle = spline(
        &[
            [-0.075, 0.118, 0.0, 0.010],
            [-0.118, 0.139, 0.0, 0.009],
            [-0.152, 0.121, 0.0, 0.0085],
            [-0.152, 0.084, 0.0, 0.0085],
            [-0.122, 0.056, 0.0, 0.009],
            [-0.080, 0.050, 0.0, 0.011],
        ],
        6,
    );
    let distance = move |p: Vec3| {
        let body = ellipsoid(p, Vec3::new(0.0, 0.078, 0.0), Vec3::new(0.096, 0.073, 0.096));
        let lid = ellipsoid(p, Vec3::new(0.0, 0.142, 0.0), Vec3::new(0.050, 0.018, 0.050));
        let knob = chain(p, &[[0.0, 0.155, 0.0, 0.007], [0.0, 0.168, 0.0, 0.007]]);
        let knob = blend(knob, p.distance(Vec3::new(0.0, 0.178, 0.0)) - 0.0125, 0.008);
        let foot = Vec2::new(Vec2::new(p.x, p.z).length() - 0.050, (p.y - 0.007).abs() - 0.003);
        let foot = foot.max(Vec2::ZERO).length() + foot.max_element().min(0.0) - 0.004;
        let pot = blend(blend(body, foot, 0.010), blend(lid, knob, 0.010), 0.006);
        blend(pot, blend(chain(p, &spout), chain(p, &handle), 0.004), 0.016)
    };
    surface(Vec3::new(-0.18, -0.01, -0.11), Vec3::new(0.19, 0.21, 0.11), cell, distance)
}

/// The hollow of the same teapot when it is glass: faces into the cavity, which is out of the glass.
pub fn teapot_hollow() -> Mesh {
    shapes::ellipsoid(Vec3::new(0.0905, 0.066, 0.0905), 4).flipped().at(0.0, 0.0785, 0.0)
}

/// A waisted jug of 30 cm with a handle.
pub fn jug() -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.056, 0.0],
            [0.064, 0.008],
            [0.078, 0.04],
            [0.092, 0.095],
            [0.082, 0.150],
            [0.056, 0.205],
            [0.050, 0.245],
            [0.062, 0.288],
            [0.063, 0.294],
            [0.058, 0.294],
            [0.045, 0.245],
            [0.048, 0.205],
            [0.060, 0.12],
            [0.0, 0.06],
        ],
        6,
    );
    let handle = spline(
        &[
            [-0.052, 0.262, 0.0, 0.008],
            [-0.098, 0.285, 0.0, 0.008],
            [-0.138, 0.245, 0.0, 0.0085],
            [-0.135, 0.180, 0.0, 0.0085],
            [-0.086, 0.120, 0.0, 0.0085],
        ],
        8,
    );
    Mesh::joined(&[lathe(&profile, 64), rod(&handle, 16)])
}

/// A bellied pot with a narrow rim, 20 cm high.
pub fn pot() -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.048, 0.0],
            [0.056, 0.006],
            [0.088, 0.055],
            [0.098, 0.105],
            [0.075, 0.158],
            [0.045, 0.180],
            [0.050, 0.200],
            [0.052, 0.204],
            [0.046, 0.204],
            [0.038, 0.182],
            [0.060, 0.150],
            [0.070, 0.100],
            [0.0, 0.03],
        ],
        6,
    );
    lathe(&profile, 64)
}

/// A tumbler: a thick base and a wall of 3 mm, one closed skin.
pub fn tumbler() -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.026, 0.0],
            [0.0295, 0.003],
            [0.0315, 0.03],
            [0.0345, 0.07],
            [0.0375, 0.108],
            [0.0374, 0.1105],
            [0.0352, 0.1105],
            [0.0345, 0.108],
            [0.0315, 0.07],
            [0.0285, 0.032],
            [0.024, 0.0165],
            [0.0, 0.014],
        ],
        5,
    );
    lathe(&profile, 56)
}
