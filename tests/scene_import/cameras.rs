//! Cameras of the file and the made one.

use super::*;

#[test]
fn cameras_keep_the_rigid_part_of_their_node() {
    let mut doc = triangle();
    for name in [json!("shot"), json!("shot"), Value::Null] {
        let mut camera =
            json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5 } });
        if !name.is_null() {
            camera["name"] = name;
        }
        let camera = doc.push("cameras", camera);
        doc.root(json!({ "camera": camera, "scale": [-2, 3, 4], "translation": [1, 2, 3] }));
    }
    let flat = json!({ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 1.5, "znear": 0, "zfar": 1 } });
    let flat = doc.push("cameras", flat);
    doc.root(json!({ "camera": flat, "scale": [2, 2, 2] }));
    let scene = doc.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["shot", "shot 2", "camera 2", "camera 3"]);
    let camera = &scene.cameras[0];
    assert_eq!((camera.vertical_fov, camera.aspect), (0.5, Some(1.5)));
    assert!(camera.world_from_camera.abs_diff_eq(glam::Affine3A::from_translation(vec3(1.0, 2.0, 3.0)), 1e-6));
    assert_eq!((camera.orthographic_height, scene.cameras[3].orthographic_height), (None, Some(6.0)));
    assert_eq!(scene.cameras[3].aspect, Some(2.0));
}

#[test]
fn degenerate_cameras_are_errors() {
    let mut doc = triangle();
    doc.push("cameras", json!({ "name": "shot", "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    let node = doc.root(json!({ "camera": 0 }));
    doc.scene();
    for yfov in [0.0, -1.0, 3.2] {
        doc.json["cameras"][0]["perspective"]["yfov"] = json!(yfov);
        let error = doc.error();
        assert!(error.contains("cameras[0] ('shot'): its yfov is"), "{error}");
    }
    doc.json["cameras"][0]["perspective"]["yfov"] = json!(0.5);
    doc.json["nodes"][node]["scale"] = json!([1, 1, 0]);
    assert!(doc.error().contains("cameras[0] ('shot'): its node's scale is zero"));
    doc.json["nodes"][node]["scale"] = json!([1e39, 1, 1]);
    assert!(doc.error().contains("nodes[1] has a transform that is not finite"));
    doc.json["nodes"][node] = json!({ "camera": 7 });
    assert!(doc.error().contains("cameras[7] does not exist"));
}

#[test]
fn the_made_camera_sees_the_whole_scene() {
    let quad = |doc: &mut Doc, x: [f32; 3], y: [f32; 3]| {
        let sum = [x[0] + y[0], x[1] + y[1], x[2] + y[2]];
        let positions = doc.vectors(&[[0.0; 3], x, sum, y]);
        doc.show(json!({ "attributes": { "POSITION": positions }, "mode": 6 }));
    };
    let flat: [([f32; 3], [f32; 3], Vec3); 4] = [
        ([2.0, 0.0, 0.0], [0.0, 1.0, 0.0], Vec3::Z),
        ([0.0, 1.0, 0.0], [2.0, 0.0, 0.0], -Vec3::Z),
        ([0.0, 0.0, -2.0], [0.0, 1.0, 0.0], Vec3::X),
        ([2.0, 0.0, 0.0], [0.0, 0.0, -1.0], Vec3::Y),
    ];
    let mut scenes = Vec::new();
    for (x, y, back) in flat {
        let mut doc = Doc::new();
        quad(&mut doc, x, y);
        let scene = doc.scene();
        assert!(Vec3::from(scene.cameras[0].world_from_camera.matrix3.z_axis).abs_diff_eq(back, 1e-6));
        scenes.push(scene);
    }
    let mut doc = Doc::new();
    quad(&mut doc, [200.0, 0.0, 0.0], [0.0, 0.0, -300.0]);
    quad(&mut doc, [0.0, 0.0, -20.0], [0.0, 50.0, 0.0]);
    let scene = doc.scene();
    let up = scene.cameras[0].world_from_camera.matrix3.y_axis;
    let eye = scene.cameras[0].world_from_camera.translation;
    assert!(up.y > 0.8 && eye.y > 50.0);
    scenes.push(scene);
    for scene in scenes {
        let camera = &scene.cameras[0];
        assert_eq!(camera.name, "default");
        assert!((camera.vertical_fov.to_degrees() - 40.0).abs() < 1e-4);
        // Every vertex is inside a square image, and they fill it from side to side one way or the other.
        let camera_from_world = camera.world_from_camera.inverse();
        let half = (0.5 * camera.vertical_fov).tan();
        let (mut low, mut high) = (glam::Vec2::INFINITY, glam::Vec2::NEG_INFINITY);
        for position in &scene.positions {
            let seen = camera_from_world.transform_point3(*position);
            assert!(seen.z < 0.0);
            let place = seen.truncate() / (-seen.z * half);
            (low, high) = (low.min(place), high.max(place));
        }
        assert!(low.min_element() > -0.92 && high.max_element() < 0.92, "{low} {high}");
        let filled = (high - low).max_element();
        assert!(filled > 1.8, "{low} {high}");
        assert!(warned(&scene, "has no camera"));
    }
}
