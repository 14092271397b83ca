//! Whether a file has changed on the disk: asked now and then, which works on every file system and needs no thread.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Seconds between looks.
pub const INTERVAL_S: f64 = 0.5;

type Stamp = (SystemTime, u64);

/// One file.
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

    /// The watched file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the file has changed since it was last said so. `now_s` counts up from anywhere.
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

fn stamp(path: &Path) -> Option<Stamp> {
    let data = std::fs::metadata(path).ok()?;
    Some((data.modified().ok()?, data.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_once_and_only_when_it_has_settled() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        std::fs::write(&path, "one").unwrap();
        let mut watch = Watch::new(&path);
        assert!(!watch.changed(0.0));
        std::fs::write(&path, "longer").unwrap();
        assert!(!watch.changed(0.1), "too early to look");
        assert!(!watch.changed(1.0), "seen for the first time");
        assert!(watch.changed(2.0));
        assert!(!watch.changed(3.0));
        std::fs::remove_file(&path).unwrap();
        assert!(!watch.changed(4.0) && !watch.changed(5.0), "a file that is gone is no news");
    }
}
