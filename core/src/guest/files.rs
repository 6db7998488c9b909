//! What was brought: files by their paths, folders and archives unpacked.

use std::collections::BTreeMap;

use super::zip::{looks_like_zip, unzip};
use super::{GuestError, RobotDescription};

/// Most files that are taken at once.
pub const MAX_FILES: usize = 5_000;
/// Largest single file, bytes.
pub const MAX_FILE_BYTES: u64 = 128 << 20;
/// Most bytes of all files together, unpacked.
pub const MAX_TOTAL_BYTES: u64 = 256 << 20;

/// Files by their paths, `/` between folders.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files {
    by_path: BTreeMap<String, Vec<u8>>,
}

impl Files {
    /// Takes files in; archives among them are unpacked into a folder of their name.
    ///
    /// # Errors
    /// [`GuestError::TooMuch`] beyond the limits, [`GuestError::Zip`] for a broken archive.
    pub fn new(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Result<Self, GuestError> {
        let mut all = Self::default();
        let mut total = 0_u64;
        let mut put = |path: String, bytes: Vec<u8>| -> Result<(), GuestError> {
            total += bytes.len() as u64;
            for (found, limit, limit_name) in [
                (bytes.len() as u64, MAX_FILE_BYTES, "MAX_FILE_BYTES"),
                (total, MAX_TOTAL_BYTES, "MAX_TOTAL_BYTES"),
                (all.by_path.len() as u64 + 1, MAX_FILES as u64, "MAX_FILES"),
            ] {
                if found > limit {
                    return Err(GuestError::TooMuch { thing: path, found, limit, limit_name });
                }
            }
            all.by_path.insert(tidy(&path), bytes);
            Ok(())
        };
        for (path, bytes) in files {
            if looks_like_zip(&bytes) && ends_in(&path, ".zip") {
                let folder = path.rsplit_once('.').map_or(path.as_str(), |(stem, _)| stem).to_owned();
                for (inner, content) in unzip(&path, &bytes)? {
                    put(format!("{folder}/{inner}"), content)?;
                }
            } else {
                put(path, bytes)?;
            }
        }
        Ok(all)
    }

    /// All paths, sorted.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.by_path.keys().map(String::as_str)
    }

    /// Content of the file at a path.
    pub fn get(&self, path: &str) -> Option<&[u8]> {
        self.by_path.get(path).map(Vec::as_slice)
    }

    /// Whether there is a robot among them, or something that is meant as one.
    pub fn has_robot(&self) -> bool {
        self.paths().any(|path| ends_in(path, ".urdf") || ends_in(path, ".xacro"))
    }

    /// The description of a robot among them, with its path.
    ///
    /// # Errors
    /// [`GuestError`] when a file that is meant as one is wrong.
    pub fn description(&self) -> Result<Option<(&str, RobotDescription)>, GuestError> {
        let meant = |(path, bytes): (&String, &Vec<u8>)| {
            let json: serde_json::Value = serde_json::from_slice(bytes).ok()?;
            RobotDescription::is_meant_by(&json).then_some(())?;
            Some((path.clone(), bytes.clone()))
        };
        let Some((path, bytes)) = self.by_path.iter().filter(|(path, _)| ends_in(path, ".json")).find_map(meant) else {
            return Ok(None);
        };
        let description = RobotDescription::parse(&path, &String::from_utf8_lossy(&bytes))?;
        let known = self.by_path.get_key_value(&path).map_or("", |(path, _)| path.as_str());
        Ok(Some((known, description)))
    }

    /// The robot among the files: the one that is named, or the only one.
    ///
    /// # Errors
    /// [`GuestError`] when there is none, or several and none is named.
    pub fn urdf(&self, wanted: Option<&str>) -> Result<&str, GuestError> {
        let mut found: Vec<&str> = self.paths().filter(|path| ends_in(path, ".urdf")).collect();
        if let Some(wanted) = wanted
            && let Some(path) = found.iter().find(|path| **path == wanted || file_name(path) == file_name(wanted))
        {
            return Ok(path);
        }
        // Copies in build folders and the like stand deeper than what is meant.
        let depth = |path: &str| path.matches('/').count();
        let least = found.iter().map(|path| depth(path)).min().unwrap_or(0);
        if found.iter().filter(|path| depth(path) == least).count() == 1 {
            found.retain(|path| depth(path) == least);
        }
        match found.as_slice() {
            [one] => Ok(one),
            [] => match self.paths().find(|path| ends_in(path, ".xacro")) {
                Some(file) => Err(GuestError::Xacro { file: file_name(file).to_owned() }),
                None => {
                    let mut shown: Vec<String> = self.paths().take(5).map(|path| file_name(path).to_owned()).collect();
                    if self.by_path.len() > shown.len() {
                        shown.push("…".to_owned());
                    }
                    Err(GuestError::NoUrdf { count: self.by_path.len(), shown })
                }
            },
            many => Err(GuestError::SeveralUrdfs { found: many.iter().map(|path| (*path).to_owned()).collect() }),
        }
    }

    /// The SRDF beside a URDF: of the same name, or the only one there is.
    pub fn srdf_beside(&self, urdf: &str) -> Option<&str> {
        let stem = |path: &str| file_name(path).rsplit_once('.').map_or("", |(stem, _)| stem).to_owned();
        let all: Vec<&str> = self.paths().filter(|path| ends_in(path, ".srdf")).collect();
        let same = all.iter().find(|path| stem(path) == stem(urdf));
        same.or(if let [only] = all.as_slice() { Some(only) } else { None }).copied()
    }

    /// The file that a URDF means: `package://NAME/…`, `file://…`, or a path relative to the URDF.
    ///
    /// A package is whatever folder of that name was brought, or the top of what was brought; where folders were lost on
    /// the way, the only file of that name will do.
    pub fn resolve(&self, urdf: &str, uri: &str) -> Option<&[u8]> {
        let (_, rest) = uri.split_once("://").unwrap_or(("", uri));
        let rest = tidy(rest);
        let folder = urdf.rsplit_once('/').map_or("", |(folder, _)| folder);
        if !uri.contains("://")
            && let Some(bytes) = self.get(&tidy(&format!("{folder}/{uri}")))
        {
            return Some(bytes);
        }
        // With the package's name, then without it: the nearest file whose path ends so.
        let inside = rest.split_once('/').map_or(rest.as_str(), |(_, inside)| inside);
        for wanted in [rest.as_str(), inside] {
            let ends = |path: &&str| *path == wanted || path.ends_with(&format!("/{wanted}"));
            let near = |path: &&str| std::cmp::Reverse(common_folders(path, urdf));
            if let Some(path) = self.paths().filter(ends).min_by_key(near) {
                return self.get(path);
            }
        }
        let mut of_that_name = self.paths().filter(|path| file_name(path) == file_name(&rest));
        let only = of_that_name.next()?;
        if of_that_name.next().is_some() { None } else { self.get(only) }
    }
}

/// How many folders two paths have in common from the top.
fn common_folders(a: &str, b: &str) -> usize {
    a.split('/').zip(b.split('/')).take_while(|(a, b)| a == b).count()
}

/// The last part of a path.
pub(super) fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// Whether a path ends so, upper and lower case alike.
pub(super) fn ends_in(path: &str, ending: &str) -> bool {
    path.to_ascii_lowercase().ends_with(ending)
}

/// A path without `.`, `..`, empty parts and the system's own separators.
fn tidy(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    let path = path.replace('\\', "/");
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(paths: &[&str]) -> Files {
        Files::new(paths.iter().map(|path| ((*path).to_owned(), path.as_bytes().to_vec()))).unwrap()
    }

    fn found<'f>(files: &'f Files, urdf: &str, uri: &str) -> Option<&'f str> {
        files.resolve(urdf, uri).map(|bytes| std::str::from_utf8(bytes).unwrap())
    }

    #[test]
    fn meshes_are_found_in_packages_beside_the_robot_and_where_folders_were_lost() {
        let all = files(&["ws/my_arm/urdf/arm.urdf", "ws/my_arm/meshes/a.stl", "ws/other/meshes/a.stl"]);
        let urdf = "ws/my_arm/urdf/arm.urdf";
        assert_eq!(found(&all, urdf, "package://my_arm/meshes/a.stl"), Some("ws/my_arm/meshes/a.stl"));
        assert_eq!(found(&all, urdf, "package://other/meshes/a.stl"), Some("ws/other/meshes/a.stl"));
        assert_eq!(found(&all, urdf, "package://renamed/meshes/a.stl"), Some("ws/my_arm/meshes/a.stl"));
        assert_eq!(found(&all, urdf, "../meshes/a.stl"), Some("ws/my_arm/meshes/a.stl"));
        assert_eq!(found(&all, urdf, "package://my_arm/meshes/b.stl"), None);
        assert_eq!(found(&all, urdf, "a.stl"), Some("ws/my_arm/meshes/a.stl"), "the one in its own package");
        let loose = files(&["arm.urdf", "a.stl"]);
        assert_eq!(found(&loose, "arm.urdf", "package://my_arm/meshes/visual/a.stl"), Some("a.stl"));
        assert_eq!(found(&loose, "arm.urdf", "file:///opt/share/a.stl"), Some("a.stl"));
    }

    #[test]
    fn the_robot_among_the_files_is_the_only_one_the_highest_or_the_one_that_is_named() {
        assert_eq!(files(&["a/x.urdf", "a/m.stl"]).urdf(None), Ok("a/x.urdf"));
        assert_eq!(files(&["a/x.urdf", "a/build/x.urdf"]).urdf(None), Ok("a/x.urdf"));
        let two = files(&["x.urdf", "y.urdf"]);
        assert_eq!(two.urdf(Some("y.urdf")), Ok("y.urdf"));
        assert!(two.urdf(None).unwrap_err().to_string().contains("found 2 URDF files (x.urdf, y.urdf)"));
        assert!(matches!(files(&["arm.urdf.xacro"]).urdf(None), Err(GuestError::Xacro { .. })));
        let none = files(&["a.stl", "b.stl"]).urdf(None).unwrap_err().to_string();
        assert_eq!(none, "found no URDF among 2 files (a.stl, b.stl), wanted a file that ends in .urdf");
    }

    #[test]
    fn archives_become_folders() {
        let zip = super::super::zip::zip_of(&[("pkg/arm.urdf", b"<robot/>")], true);
        let all = Files::new([("my.zip".to_owned(), zip)]).unwrap();
        assert_eq!(all.paths().collect::<Vec<_>>(), ["my/pkg/arm.urdf"]);
        assert!(all.has_robot());
    }

    #[test]
    fn paths_never_leave_what_was_brought() {
        assert_eq!(tidy("../../etc/./passwd"), "etc/passwd");
        assert_eq!(tidy("a\\b\\..\\c"), "a/c");
    }
}
