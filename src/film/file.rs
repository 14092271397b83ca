//! Output files that are either whole or absent: written beside their place, then renamed into it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Checks that `path` can be written, so that a long render is not lost at its end; leaves nothing behind.
///
/// An error is bad usage ([`Error::Input`]): the user chose the path.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::input(format!("{} is a folder: give the name of a file in it", path.display())));
    }
    if fs::metadata(path).is_ok_and(|m| m.permissions().readonly()) {
        return Err(Error::input(format!("{} is write-protected: choose another output file", path.display())));
    }
    let temporary = temporary_beside(path);
    match create(&temporary) {
        Ok(_) => fs::remove_file(&temporary).map_err(|e| Error::input(sentence(path, &e))),
        Err(e) => Err(Error::input(sentence(path, &e))),
    }
}

/// Puts `bytes` into the file `path`, replacing what was there only once all of them are on the disk.
///
/// Leaves no temporary file behind, whether it succeeds or not; an error is [`Error::Runtime`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let temporary = temporary_beside(path);
    // Follow a link, so that what it points to is replaced and not the link itself.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let written = create(&temporary)
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
        .and_then(|()| fs::rename(&temporary, &target));
    written.map_err(|e| {
        // The first error is the one to tell; the temporary file may not even exist.
        let _ = fs::remove_file(&temporary);
        Error::runtime(sentence(path, &e))
    })
}

/// A name in the folder of the final file, since a rename works only within one file system.
fn temporary_beside(path: &Path) -> PathBuf {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    target.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}

fn create(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create(true).truncate(true).open(path)
}

fn sentence(path: &Path, error: &io::Error) -> String {
    let shown = path.display();
    let parent = path.parent().filter(|p| *p != Path::new(""));
    let folder = parent.map_or("the current folder".into(), |p| p.display().to_string());
    match error.kind() {
        io::ErrorKind::NotFound if parent.is_some_and(|p| !p.is_dir()) => {
            format!("cannot write {shown}: there is no folder {folder}")
        }
        io::ErrorKind::NotADirectory => format!("cannot write {shown}: {folder} is not a folder"),
        io::ErrorKind::IsADirectory => format!("cannot write {shown}: it is a folder"),
        io::ErrorKind::PermissionDenied => {
            format!("cannot write {shown}: no permission to write in {folder}")
        }
        io::ErrorKind::ReadOnlyFilesystem => {
            format!("cannot write {shown}: {folder} is on a read-only file system")
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            format!("cannot write {shown}: the disk is full, so make room and render again")
        }
        io::ErrorKind::InvalidFilename => {
            format!("cannot write {shown}: the file name is not valid or too long")
        }
        _ => format!("cannot write {shown}: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn replaces_a_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, "old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn says_what_is_wrong_with_a_path() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        for (path, words) in [
            (folder.path().to_path_buf(), "is a folder"),
            (folder.path().join("absent/a.exr"), "there is no folder"),
            (file.join("a.exr"), "is not a folder"),
            (folder.path().join("x".repeat(300)), "name is not valid or too long"),
        ] {
            let error = check_writable(&path).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(error.exit_status(), 2);
            let error = write_whole(&path, b"x").unwrap_err();
            assert_eq!(error.exit_status(), 1, "{error}");
        }
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn follows_a_link_to_the_file_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
