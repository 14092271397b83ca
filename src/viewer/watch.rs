//! Whether a file, or anything in a folder, has changed on the disk: asked now and then, which works on every file system and needs no thread.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Seconds between looks.
pub const INTERVAL_S: f64 = 0.5;

type Stamp = (SystemTime, u64);

/// One file or folder.
#[derive(Debug)]
pub struct Watch {
    path: PathBuf,
    known: Option<Stamp>,
    /// What the last look saw: a change counts once two looks agree, so that a file that is being written is left alone.
    seen: Option<Stamp>,
    next_s: f64,
}

impl Watch {
    pub fn new(path: &Path) -> Self {
        let stamp = stamp(path);
        Self { path: path.to_path_buf(), known: stamp, seen: stamp, next_s: 0.0 }
    }

    /// What is watched.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it has changed since it was last said so. `now_s` counts up from anywhere.
    pub fn changed(&mut self, now_s: f64) -> bool {
        if now_s < self.next_s {
            return false;
        }
        self.next_s = now_s + INTERVAL_S;
        let stamp = stamp(&self.path);
        let settled = stamp.is_some() && stamp == self.seen && stamp != self.known;
        self.seen = stamp;
        if settled {
            self.known = stamp;
        }
        settled
    }
}

/// Last change and bytes; of a folder, over all that is in it.
fn stamp(path: &Path) -> Option<Stamp> {
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
}
