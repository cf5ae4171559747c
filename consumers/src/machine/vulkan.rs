//! The Vulkan loader and the drivers that it would find.
//!
//! This reads files only. A driver that is here may still find no device: what a process really gets is what the
//! runtime enumerates.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use serde::Serialize;

/// What the Vulkan loader would find on this machine.
#[derive(Clone, Debug, Serialize)]
pub struct Vulkan {
    /// The loader, `libvulkan.so.1`.
    pub loader: Option<PathBuf>,
    /// Drivers, sorted by the path of their manifest.
    pub drivers: Vec<Driver>,
    /// The variable that names the drivers, if one does: then the standard places do not count.
    pub variable: Option<String>,
}

/// An installable client driver.
#[derive(Clone, Debug, Serialize)]
pub struct Driver {
    /// Its JSON manifest.
    pub manifest: PathBuf,
    /// The library as the manifest has it.
    pub library: String,
    /// Why it cannot be loaded, if so.
    pub fault: Option<String>,
}

/// The packages of Debian that bring the loader and a software driver.
pub const PACKAGES: [&str; 2] = ["libvulkan1", "mesa-vulkan-drivers"];

impl Vulkan {
    /// Looks where the loader looks.
    pub fn find() -> Self {
        let libraries = Libraries::find();
        let (manifests, variable) = manifests();
        Self {
            loader: libraries.locate("libvulkan.so.1"),
            drivers: manifests
                .into_iter()
                .map(|manifest| Driver::read(manifest, &libraries))
                .collect(),
            variable,
        }
    }

    /// Whether there is a loader and a driver that it can load.
    pub fn usable(&self) -> bool {
        self.loader.is_some() && self.drivers.iter().any(|driver| driver.fault.is_none())
    }
}

impl Driver {
    fn read(manifest: PathBuf, libraries: &Libraries) -> Self {
        match library_path(&manifest) {
            Err(fault) => Self { manifest, library: String::new(), fault: Some(fault) },
            Ok(library) => {
                let found = if library.contains('/') {
                    let folder = manifest.parent().unwrap_or(Path::new("/"));
                    folder.join(&library).exists()
                } else {
                    libraries.locate(&library).is_some()
                };
                Self {
                    fault: (!found).then(|| format!("its library {library} is missing")),
                    manifest,
                    library,
                }
            }
        }
    }
}

/// The library that a driver's manifest names.
fn library_path(manifest: &Path) -> Result<String, String> {
    let text = fs::read_to_string(manifest).map_err(|error| error.to_string())?;
    let json: serde_json::Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let library = json.pointer("/ICD/library_path").and_then(|path| path.as_str());
    library.map(str::to_owned).ok_or_else(|| "it has no ICD.library_path".to_owned())
}

/// The manifests that the loader reads, and the variable that names them, if one does.
fn manifests() -> (BTreeSet<PathBuf>, Option<String>) {
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        if let Some(list) = env::var_os(variable).filter(|list| !list.is_empty()) {
            let mut found = BTreeSet::new();
            for entry in env::split_paths(&list) {
                if entry.is_dir() {
                    found.extend(json_files(&entry));
                } else {
                    found.insert(entry);
                }
            }
            return (found, Some(variable.to_owned()));
        }
    }
    let mut folders = Vec::new();
    let home = env::var_os("HOME").map(PathBuf::from);
    for (one, many, below_home, default) in [
        ("XDG_CONFIG_HOME", "XDG_CONFIG_DIRS", ".config", "/etc/xdg"),
        ("XDG_DATA_HOME", "XDG_DATA_DIRS", ".local/share", "/usr/local/share:/usr/share"),
    ] {
        let own = env::var_os(one).map(PathBuf::from);
        folders.extend(own.or_else(|| home.as_ref().map(|home| home.join(below_home))));
        let shared = env::var_os(many).filter(|list| !list.is_empty());
        folders.extend(env::split_paths(shared.as_deref().unwrap_or(OsStr::new(default))));
    }
    folders.push(PathBuf::from("/etc"));
    let found =
        folders.iter().flat_map(|folder| json_files(&folder.join("vulkan/icd.d"))).collect();
    (found, None)
}

fn json_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths.filter(|path| path.extension() == Some(OsStr::new("json"))).collect()
}

/// The shared libraries that the dynamic linker knows by name.
struct Libraries {
    /// Lines of `ldconfig -p`, as in `libvulkan.so.1 (libc6,x86-64) => /lib/x86_64-linux-gnu/libvulkan.so.1`.
    cache: String,
    folders: Vec<PathBuf>,
}

impl Libraries {
    fn find() -> Self {
        // ldconfig lies in a folder that is on root's path alone.
        let cache = ["ldconfig", "/sbin/ldconfig", "/usr/sbin/ldconfig"]
            .into_iter()
            .find_map(|ldconfig| Command::new(ldconfig).arg("-p").output().ok())
            .map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
        let mut folders: Vec<PathBuf> = env::var_os("LD_LIBRARY_PATH")
            .map(|list| env::split_paths(&list).collect())
            .unwrap_or_default();
        folders.extend(
            ["/lib", "/usr/lib", "/lib64", "/usr/lib64", "/usr/local/lib"].map(PathBuf::from),
        );
        Self { cache: cache.unwrap_or_default(), folders }
    }

    fn locate(&self, name: &str) -> Option<PathBuf> {
        let in_folder = self.folders.iter().map(|folder| folder.join(name));
        let in_cache = self.cache.lines().filter_map(|line| {
            let (library, path) = line.trim().split_once(" => ")?;
            (library.split_whitespace().next() == Some(name)).then(|| PathBuf::from(path))
        });
        in_folder.chain(in_cache).find(|path| path.exists())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_driver_without_its_library_is_at_fault() {
        let folder = tempfile::tempdir().unwrap();
        let libraries = Libraries { cache: String::new(), folders: Vec::new() };
        let manifest = folder.path().join("soft.json");
        fs::write(&manifest, r#"{"ICD": {"library_path": "./libsoft.so"}}"#).unwrap();
        let driver = Driver::read(manifest.clone(), &libraries);
        assert_eq!(driver.fault.as_deref(), Some("its library ./libsoft.so is missing"));
        fs::write(folder.path().join("libsoft.so"), "").unwrap();
        assert_eq!(Driver::read(manifest.clone(), &libraries).fault, None);
        fs::write(&manifest, "{}").unwrap();
        assert!(Driver::read(manifest, &libraries).fault.is_some());
    }

    #[test]
    fn a_library_is_found_by_its_exact_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("libvulkan.so.1");
        fs::write(&path, "").unwrap();
        let libraries = Libraries {
            cache: format!("\tlibvulkan.so.1 (libc6,x86-64) => {}\n", path.display()),
            folders: Vec::new(),
        };
        assert_eq!(libraries.locate("libvulkan.so.1"), Some(path));
        assert_eq!(libraries.locate("libvulkan.so"), None);
    }
}
