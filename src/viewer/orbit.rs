//! The camera under the hand: a turntable around a point, or one of the file's cameras as it is.

use glam::{DVec3, Vec3};

use crate::scene::{Camera, Lens};

/// Steepest view from the horizon, in radians: straight up and down there is no upright image.
const STEEPEST: f64 = 1.55;

/// A camera that can be moved.
#[derive(Debug, Clone)]
pub struct Orbit {
    /// One of the file's cameras: the name, the field of view, and the place until it is moved.
    base: Camera,
    eye: DVec3,
    /// What it turns around.
    target: DVec3,
    moved: bool,
}

impl Orbit {
    /// Begins at a camera of the file; turns around the point before it that is nearest to the scene's middle.
    /// `sphere` is the scene's centre and radius.
    pub fn new(base: Camera, (centre, radius): (Vec3, f32)) -> Self {
        let eye = DVec3::from(Vec3::from(base.world_from_camera.translation));
        let forward = -DVec3::from(Vec3::from(base.world_from_camera.matrix3.z_axis)).normalize();
        let distance = (DVec3::from(centre) - eye).dot(forward).max(0.05 * f64::from(radius));
        Self { base, eye, target: eye + distance * forward, moved: false }
    }

    /// Puts it somewhere, looking at `target`.
    pub fn place(&mut self, eye: Vec3, target: Vec3) {
        (self.eye, self.target, self.moved) = (eye.into(), target.into(), true);
    }

    /// Where it stands and what it looks at, once it has been moved; single precision, as the command line has it.
    pub fn look(&self) -> Option<(Vec3, Vec3)> {
        self.moved.then(|| (self.eye.as_vec3(), self.target.as_vec3()))
    }

    /// What it sees through.
    pub fn lens(&self) -> Option<Lens> {
        self.base.lens
    }

    /// The name of the file's camera it began at.
    pub fn name(&self) -> &str {
        &self.base.name
    }

    /// The camera to render with.
    pub fn camera(&self) -> Camera {
        let moved = self.look().and_then(|(eye, target)| self.base.looking(eye, target));
        moved.unwrap_or_else(|| self.base.clone())
    }

    /// Turns around the target: to the right and up, in radians.
    pub fn turn(&mut self, right: f64, up: f64) {
        let arm = self.eye - self.target;
        let radius = arm.length();
        let (azimuth, elevation) = (arm.x.atan2(arm.z), (arm.y / radius).clamp(-1.0, 1.0).asin());
        let (azimuth, elevation) = (azimuth + right, (elevation + up).clamp(-STEEPEST, STEEPEST));
        let level = DVec3::new(azimuth.sin(), 0.0, azimuth.cos());
        self.eye = self.target + radius * (elevation.cos() * level + elevation.sin() * DVec3::Y);
        self.moved = true;
    }

    /// Moves sideways: right and up, in image heights at the target.
    pub fn pan(&mut self, right: f64, up: f64) {
        let height = self.base.orthographic_height.map_or_else(
            || 2.0 * (self.eye - self.target).length() * (0.5 * f64::from(self.base.vertical_fov)).tan(),
            f64::from,
        );
        let frame = self.camera().world_from_camera.matrix3;
        let [x, y] = [frame.x_axis, frame.y_axis].map(|axis| DVec3::from(Vec3::from(axis)));
        let by = height * (right * x + up * y);
        self.eye += by;
        self.target += by;
        self.moved = true;
    }

    /// Goes towards the target: the distance is multiplied by `factor`, above 0.
    pub fn dolly(&mut self, factor: f64) {
        self.eye = self.target + factor * (self.eye - self.target);
        self.moved = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;

    fn orbit() -> Orbit {
        let world_from_camera = Affine3A::from_translation(Vec3::new(0.0, 0.0, 4.0));
        let base = Camera {
            name: "Main".into(),
            world_from_camera,
            vertical_fov: 1.0,
            orthographic_height: None,
            lens: None,
            aspect: None,
        };
        Orbit::new(base, (Vec3::ZERO, 1.0))
    }

    #[test]
    fn unmoved_it_is_the_camera_of_the_file() {
        let orbit = orbit();
        assert_eq!(orbit.camera(), orbit.base);
        assert_eq!(orbit.look(), None);
    }

    #[test]
    fn a_quarter_turn_looks_along_x() {
        let mut orbit = orbit();
        orbit.turn(std::f64::consts::FRAC_PI_2, 0.0);
        let camera = orbit.camera().world_from_camera;
        assert!((Vec3::from(camera.translation) - Vec3::new(4.0, 0.0, 0.0)).length() < 1e-6);
        assert!((Vec3::from(camera.matrix3.z_axis) - Vec3::X).length() < 1e-6);
        assert!((Vec3::from(camera.matrix3.y_axis) - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn it_stays_upright_and_away_from_the_poles() {
        let mut orbit = orbit();
        orbit.turn(0.3, 9.0);
        assert!(orbit.camera().world_from_camera.matrix3.y_axis.y > 0.0);
        orbit.dolly(0.5);
        let (eye, target) = orbit.look().unwrap();
        assert!((eye.distance(target) - 2.0).abs() < 1e-5);
    }

    #[test]
    fn panning_moves_eye_and_target_alike() {
        let mut orbit = orbit();
        orbit.pan(0.5, 0.0);
        let (eye, target) = orbit.look().unwrap();
        assert!((eye - target - Vec3::new(0.0, 0.0, 4.0)).length() < 1e-5);
        assert!((eye.x - 4.0 * 0.5f32.tan()).abs() < 1e-5);
    }
}
