//! Robots on the disk: a URDF with the meshes that it names, a folder, an archive.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use endcomfort_core::guest::{Files, MAX_FILE_BYTES, MAX_FILES};
use endcomfort_core::robot::read_urdf;

/// Folders are entered this deep.
const DEEPEST: usize = 12;

/// Whether a path names a robot that could be brought: a folder, an archive, a URDF, or the description of one.
pub fn is_robot(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    path.is_dir() || [".urdf", ".xacro", ".zip", ".robot.json"].into_iter().any(|ending| name.ends_with(ending))
}

/// The files that belong to a robot.
///
/// Of a folder all files, of an archive what is in it. Of a URDF itself, the SRDF and the description of the same name
/// beside it, and the meshes that it names: relative to it, or in a package whose folder is somewhere above it.
///
/// # Errors
/// A sentence with the path of what cannot be read.
pub fn robot_files(path: &Path) -> Result<Files, String> {
    let name = name_of(path);
    let mut files = Vec::new();
    if path.is_dir() {
        walk(path, &name, 0, &mut files)?;
        return Files::new(files).map_err(|error| error.to_string());
    }
    let lower = name.to_ascii_lowercase();
    let bytes = read(path)?;
    if lower.ends_with(".robot.json") {
        let urdf = serde_json::from_slice::<serde_json::Value>(&bytes).ok();
        let urdf = urdf.as_ref().and_then(|json| json.get("urdf")?.as_str());
        let urdf = urdf.ok_or_else(|| format!("{}: found no \"urdf\", wanted the URDF's name", path.display()))?;
        add_urdf(&path.with_file_name(urdf), &mut files)?;
    } else if lower.ends_with(".urdf") {
        add_urdf(path, &mut files)?;
        let description = path.with_extension("robot.json");
        if description.is_file() {
            files.push((name_of(&description), read(&description)?));
        }
    }
    if !lower.ends_with(".urdf") {
        files.push((name, bytes));
    }
    Files::new(files).map_err(|error| error.to_string())
}

/// All files of a folder by their paths, its own name first; for a file itself.
///
/// # Errors
/// A sentence with the path of what cannot be read, or with the limit that is passed.
pub fn all_files(path: &Path) -> Result<Vec<(String, Vec<u8>)>, String> {
    let mut files = Vec::new();
    if path.is_dir() {
        walk(path, &name_of(path), 0, &mut files)?;
    } else {
        files.push((name_of(path), read(path)?));
    }
    Ok(files)
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| "robot".to_owned(), |name| name.to_string_lossy().into_owned())
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let size = std::fs::metadata(path).map_err(failed)?.len();
    if size > MAX_FILE_BYTES {
        return Err(format!("{}: found {size} bytes, at most {MAX_FILE_BYTES} are read", path.display()));
    }
    std::fs::read(path).map_err(failed)
}

/// A URDF, the SRDF beside it, and its meshes, under the paths that the URDF gives them.
fn add_urdf(path: &Path, files: &mut Vec<(String, Vec<u8>)>) -> Result<(), String> {
    let bytes = read(path)?;
    let wanted = RefCell::new(BTreeSet::new());
    let note = |uri: &str| {
        wanted.borrow_mut().insert(uri.to_owned());
        None
    };
    // What is wrong with it is said by whoever reads it next.
    let _robot = read_urdf(&String::from_utf8_lossy(&bytes), &note);
    files.push((name_of(path), bytes));
    let srdf = path.with_extension("srdf");
    if srdf.is_file() {
        files.push((name_of(&srdf), read(&srdf)?));
    }
    let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
    for uri in wanted.into_inner() {
        if let Some(found) = find(&folder, &uri) {
            let (_, inside) = uri.split_once("://").unwrap_or(("", &uri));
            files.push((inside.to_owned(), read(&found)?));
        }
    }
    Ok(())
}

/// The mesh that a URDF in a folder means.
fn find(folder: &Path, uri: &str) -> Option<PathBuf> {
    let (scheme, rest) = uri.split_once("://").unwrap_or(("", uri));
    if scheme != "package" {
        let path = if scheme == "file" { PathBuf::from(rest) } else { folder.join(rest) };
        return path.is_file().then_some(path);
    }
    let inside = rest.split_once('/').map_or(rest, |(_, inside)| inside);
    // A package is rooted at some folder above the URDF: the nearest one that holds the file is taken.
    let above = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let candidates = above.ancestors().flat_map(|root| [root.join(rest), root.join(inside)]).collect::<Vec<_>>();
    candidates.into_iter().find(|path| path.is_file())
}

/// Files of a folder and the folders in it, in the order of their names; hidden ones are left out.
fn walk(folder: &Path, name: &str, depth: usize, files: &mut Vec<(String, Vec<u8>)>) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut entries = std::fs::read_dir(folder).map_err(failed)?.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let inside = entry.file_name().to_string_lossy().into_owned();
        if inside.starts_with('.') {
            continue;
        }
        let inside = format!("{name}/{inside}");
        if path.is_dir() && depth < DEEPEST {
            walk(&path, &inside, depth + 1, files)?;
        } else if path.is_file() {
            if files.len() >= MAX_FILES {
                return Err(format!("{}: found more than {MAX_FILES} files", folder.display()));
            }
            files.push((inside, read(&path)?));
        }
    }
    Ok(())
}
