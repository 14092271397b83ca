//! Shaders with a line changed: broken twins of what has no flag for one.

use std::fs;
use std::path::Path;

use emlt::gpu::shader::Sources;

/// The sources with `from`, which is once in `module` (a path under shaders), made `to`. `name` is a folder's.
pub fn changed_sources(name: &str, module: &str, from: &str, to: &str) -> Sources {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    copy(&root.join("shaders"), &folder);
    let module = folder.join(module);
    let text = fs::read_to_string(&module).unwrap();
    assert_eq!(text.matches(from).count(), 1, "{from}");
    fs::write(&module, text.replace(from, to)).unwrap();
    Sources::read(&folder).unwrap()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}
