//! Whether files, or anything in a folder, have changed on the disk: asked now and then, which works on every file system
//! and needs no thread.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Seconds between looks.
pub const INTERVAL_S: f64 = 0.5;

/// Last change and bytes; none of what is not there.
type Stamp = Option<(SystemTime, u64)>;

/// A file or folder, and other files that belong to it.
#[derive(Debug)]
pub struct Watch {
    /// The first is what the others belong to.
    paths: Vec<PathBuf>,
    known: Vec<Stamp>,
    /// What the last look saw: a change counts once two looks agree, so that a file that is being written is left alone.
    seen: Vec<Stamp>,
    next_s: f64,
}

impl Watch {
    pub fn new(path: &Path) -> Self {
        Self::of_all(vec![path.to_path_buf()])
    }

    /// Of a file, which comes first, and those that belong to it.
    pub fn of_all(paths: Vec<PathBuf>) -> Self {
        let stamps: Vec<Stamp> = paths.iter().map(|path| stamp(path)).collect();
        Self { paths, known: stamps.clone(), seen: stamps, next_s: 0.0 }
    }

    /// What is watched.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Whether it, or what belongs to it, has changed since it was last said so. `now_s` counts up from anywhere.
    pub fn changed(&mut self, now_s: f64) -> bool {
        if now_s < self.next_s {
            return false;
        }
        self.next_s = now_s + INTERVAL_S;
        let stamps: Vec<Stamp> = self.paths.iter().map(|path| stamp(path)).collect();
        let settled = stamps[0].is_some() && stamps == self.seen && stamps != self.known;
        if settled {
            self.known.clone_from(&stamps);
        }
        self.seen = stamps;
        settled
    }
}

/// Of a folder, over all that is in it.
fn stamp(path: &Path) -> Stamp {
    let data = fs::metadata(path).ok()?;
    if !data.is_dir() {
        return Some((data.modified().ok()?, data.len()));
    }
    let entries = fs::read_dir(path).ok()?.flatten();
    let within = entries.filter_map(|entry| stamp(&entry.path()));
    // An empty folder has no files whose change could matter.
    within.reduce(|a, b| (a.0.max(b.0), a.1 + b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_once_and_only_when_it_has_settled() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        fs::write(&path, "one").unwrap();
        let mut watch = Watch::new(&path);
        assert!(!watch.changed(0.0));
        fs::write(&path, "longer").unwrap();
        assert!(!watch.changed(0.1), "too early to look");
        assert!(!watch.changed(1.0), "seen for the first time");
        assert!(watch.changed(2.0));
        assert!(!watch.changed(3.0));
        fs::remove_file(&path).unwrap();
        assert!(!watch.changed(4.0) && !watch.changed(5.0), "a file that is gone is no news");
    }

    #[test]
    fn a_folder_changes_with_any_file_in_it() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("inside")).unwrap();
        fs::write(folder.path().join("inside/a.wesl"), "one").unwrap();
        let mut watch = Watch::new(folder.path());
        assert!(!watch.changed(0.0));
        fs::write(folder.path().join("inside/a.wesl"), "longer").unwrap();
        assert!(!watch.changed(1.0) && watch.changed(2.0) && !watch.changed(3.0));
    }

    #[test]
    fn a_file_changes_with_what_belongs_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, image] = ["a.gltf", "a.png"].map(|name| folder.path().join(name));
        fs::write(&scene, "one").unwrap();
        fs::write(&image, "one").unwrap();
        let mut watch = Watch::of_all(vec![scene.clone(), image.clone()]);
        assert!(!watch.changed(0.0));
        fs::write(&image, "longer").unwrap();
        assert!(!watch.changed(1.0) && watch.changed(2.0) && !watch.changed(3.0));
        assert_eq!(watch.paths()[0], scene);
        // The scene may have stopped using it.
        fs::remove_file(&image).unwrap();
        assert!(!watch.changed(4.0) && watch.changed(5.0) && !watch.changed(6.0));
    }
}
