//! The committed package: it is what the sources make, and its texts, manifest and bindings change in the open.

use std::collections::BTreeSet;
use std::path::Path;

use sglow_runtime::package::{Package, PackageError};
use sglow_seal::Error::{Changed, Unreadable};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{Change, Error, Options, generate, verify_hashes};
use sglow_shaders::shade::Shade;
use sglow_shaders::{Diffuse, Emitter, Lobes, Ndf, Output, Specular, Visibility, bind_groups};

use crate::common::{copy, reseal};

const LIBRARY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");

fn read(folder: &Path, path: &str) -> String {
    std::fs::read_to_string(folder.join(path)).unwrap()
}

#[test]
fn the_committed_package_is_what_the_sources_make() {
    let folder = Path::new(LIBRARY).join("packages/sglow");
    let mut options = Options::new(&folder);
    options.check = true;
    // To the byte, made elsewhere: the same sources give the same package.
    generate(LIBRARY.as_ref(), &options, &mut |_| {}).unwrap();
    let sums = read(&folder, "SHA256SUMS");
    assert!(sums.lines().count() > 140, "{} files", sums.lines().count());
}

fn emitters_and_visibilities() -> impl Iterator<Item = (Emitter, Visibility)> {
    let all = |emitter| Visibility::ALL.map(|visibility| (emitter, visibility));
    Emitter::ALL.into_iter().flat_map(all)
}

#[test]
fn the_bindings_exclude_what_the_library_excludes() {
    let library = Library::load(LIBRARY.as_ref()).unwrap();
    let excluded: BTreeSet<String> =
        library.excluded().into_iter().map(|excluded| excluded.variant.id()).collect();
    let legal: BTreeSet<String> =
        library.variants().into_iter().map(|variant| variant.id()).collect();
    let committed: BTreeSet<String> =
        library.selected().into_iter().map(|variant| variant.id()).collect();
    for diffuse in Diffuse::ALL {
        for specular in Specular::ALL {
            for (ndf, lobes) in
                Ndf::ALL.into_iter().flat_map(|ndf| Lobes::ALL.map(|lobes| (ndf, lobes)))
            {
                for (emitter, visibility) in emitters_and_visibilities() {
                    for output in Output::ALL {
                        let of = Shade { emitter, diffuse, specular, ndf, ..Shade::default() };
                        let shade = Shade { lobes, visibility, output, ..of };
                        let id = shade.id().to_string();
                        assert_eq!(shade.excluded().is_some(), excluded.contains(&id), "{id}");
                        assert_eq!(shade.excluded().is_none(), legal.contains(&id), "{id}");
                        assert_eq!(committed.contains(&id), bind_groups(&id).is_some(), "{id}");
                    }
                }
            }
        }
    }
    // Of every precision, and no more of them.
    let of_library: BTreeSet<String> =
        legal.iter().filter(|id| id.starts_with("shade-")).cloned().collect();
    let of_bindings: Vec<String> = Shade::all().into_iter().map(Shade::id).collect();
    assert_eq!(of_bindings.len(), of_library.len(), "none is listed twice");
    assert_eq!(of_bindings.into_iter().collect::<BTreeSet<_>>(), of_library);
}

/// Of the committed package, which is what the sources make.
#[test]
fn snapshots() {
    let folder = Path::new(LIBRARY).join("packages/sglow");
    let mut settings = insta::Settings::clone_current();
    settings.set_omit_expression(true);
    settings.set_prepend_module_to_snapshot(false);
    settings.bind(|| {
        let manifest: serde_json::Value =
            serde_json::from_str(&read(&folder, "manifest.json")).unwrap();
        let variants = manifest["variants"].as_array().unwrap();
        for id in [
            "compose-diffuse-none",
            "mip-r32float-three",
            "moments-point-both-f0-exact-f32",
            "moments-point-both-f0-exact-f16",
            "sample-warped-modified-bracketed-exact-trace-exact-both-f16",
            "sample-warped-modified-bracketed-exact-trace-exact-both-f32",
            "sample-warped-previous-none-hardware-trace-exact-diffuse-f32",
            "shade-lobe-constant-none-none-diffuse-f32-none",
            "shade-cosine-fitted-asg-ggx-both-f16-none",
            "shade-cosine-fitted-ndf_filtered-ggx-both-f32-none",
            "surface-textured-cutout",
        ] {
            let variant = variants.iter().find(|variant| variant["id"] == id).unwrap();
            let file = variant["files"].as_array().unwrap().iter();
            let file = file.clone().find(|file| file["target"] == "wgsl").unwrap();
            let path = file["path"].as_str().unwrap();
            let stem = path.trim_start_matches("wgsl/").trim_end_matches(".wgsl");
            insta::assert_snapshot!(format!("wgsl__{stem}"), read(&folder, path));
        }
        for id in [
            "sample-warped-modified-bracketed-exact-trace-exact-both-f32",
            "shade-lobe-constant-none-none-diffuse-f32-none",
        ] {
            let variant = variants.iter().find(|variant| variant["id"] == id).unwrap();
            let text = serde_json::to_string_pretty(variant).unwrap();
            insta::assert_snapshot!(format!("manifest__{id}"), text);
        }
        // The axes and the structs; the tables of variants between them only repeat the manifest.
        let bindings = read(&folder, "rust/lib.rs");
        let slice = |from: &str, to: &str| {
            let start = bindings.find(from).unwrap();
            let end = start + bindings[start..].find(to).unwrap();
            bindings[start..end].to_owned()
        };
        insta::assert_snapshot!("rust__kernel", slice("pub enum Kernel", "pub enum Light"));
        insta::assert_snapshot!("rust__mip", slice("pub mod mip", "pub mod sample"));
        insta::assert_snapshot!(
            "rust__vsgl",
            slice("pub struct SglowVsglBoth", "pub struct SglowVsglDiffuse")
        );
    });
}

#[test]
fn what_was_changed_by_hand_is_named() {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(LIBRARY).join("packages/sglow"), folder.path());
    Package::load(folder.path()).unwrap();
    assert!(verify_hashes(folder.path()).unwrap().is_empty());
    let shader = folder.path().join("wgsl/mip-texel_r32float.wgsl");
    let text = std::fs::read_to_string(&shader).unwrap();
    std::fs::write(&shader, text.replace("0.25", "0.26")).unwrap();

    let errors = Package::load(folder.path()).unwrap_err();
    let [PackageError::File(Changed { path, .. })] = &errors[..] else { panic!("{errors:?}") };
    assert_eq!(*path, shader);
    let differences = verify_hashes(folder.path()).unwrap();
    assert_eq!(differences.len(), 1);
    assert_eq!(differences[0].path, "wgsl/mip-texel_r32float.wgsl");
    let mut options = Options::new(folder.path());
    options.check = true;
    let checked = generate(LIBRARY.as_ref(), &options, &mut |_| {});
    let Err(Error::Differs(differences)) = checked else { panic!("{checked:?}") };
    assert!(differences.iter().any(|one| one.change == Change::ByHand), "{differences:?}");

    std::fs::write(folder.path().join("manifest.json"), "{").unwrap();
    let errors = Package::load(folder.path()).unwrap_err();
    assert!(errors[0].to_string().contains("manifest.json"), "{errors:?}");
    std::fs::remove_file(folder.path().join("manifest.json")).unwrap();
    let errors = Package::load(folder.path()).unwrap_err();
    assert!(matches!(errors[..], [PackageError::File(Unreadable(_))]), "{errors:?}");
}

/// The errors of loading a copy of the committed package after `change`; if `sealed`, with new hashes of all its files.
fn after(sealed: bool, change: impl FnOnce(&Path)) -> String {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(LIBRARY).join("packages/sglow"), folder.path());
    change(folder.path());
    if sealed {
        reseal(folder.path());
    }
    match Package::load(folder.path()) {
        Ok(_) => String::new(),
        Err(errors) => errors.iter().map(|error| format!("{error}\n")).collect(),
    }
}

/// Replaces text of a package's manifest.
fn edit(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) {
    let mut manifest = serde_json::from_str(&read(folder, "manifest.json")).unwrap();
    change(&mut manifest);
    std::fs::write(folder.join("manifest.json"), manifest.to_string()).unwrap();
}

fn files<'a>(manifest: &'a mut serde_json::Value, id: &str) -> &'a mut serde_json::Value {
    let variants = manifest["variants"].as_array_mut().unwrap();
    &mut variants.iter_mut().find(|variant| variant["id"] == id).unwrap()["files"]
}

#[test]
fn a_package_is_sealed() {
    assert_eq!(after(false, |_| ()), "");
    let append = |folder: &Path, name: &str| {
        let text = read(folder, name) + "\n";
        std::fs::write(folder.join(name), text).unwrap();
    };
    for name in ["README.md", "rust/lib.rs", "wgsl/lib/sg.wesl", "wgsl/mip.wgsl", "manifest.json"] {
        let said = after(false, |folder| append(folder, name));
        assert!(said.contains(&format!("{name}: was changed")), "{said}");
        // Negative control: what is sealed again is another package, and in order.
        assert_eq!(after(true, |folder| append(folder, name)), "");
        let said = after(false, |folder| std::fs::remove_file(folder.join(name)).unwrap());
        assert!(said.contains(&format!("{name}: is missing")), "{said}");
    }
    let said = after(false, |folder| std::fs::remove_file(folder.join("SHA256SUMS")).unwrap());
    assert!(said.contains("SHA256SUMS: is missing"), "{said}");
    let said = after(false, |folder| append(folder, "SHA256SUMS"));
    assert!(said.contains("SHA256SUMS: line"), "{said}");
}

#[test]
fn a_manifest_fits_its_texts_whatever_its_hash() {
    let (one, other) = ("mip-r32float-three", "mip-rgba32float-three");
    let swap = |folder: &Path| {
        edit(folder, |manifest| {
            let first = files(manifest, one).take();
            let second = std::mem::replace(files(manifest, other), first);
            *files(manifest, one) = second;
        });
    };
    assert!(after(false, swap).contains("manifest.json: was changed"));
    // Passes, whose entry points and bindings differ.
    let said = after(true, |folder| {
        edit(folder, |manifest| {
            let (one, other) = (one, "compose-both-none");
            let first = files(manifest, one).take();
            let second = std::mem::replace(files(manifest, other), first);
            *files(manifest, one) = second;
        });
    });
    for id in [one, "compose-both-none"] {
        assert!(said.contains(&format!("variant '{id}' has no entry point")), "{said}");
    }
    for path in ["../mip.wgsl", "/etc/hostname", "wgsl/../wgsl/mip.wgsl", "wgsl/none.wgsl"] {
        let said = after(true, |folder| {
            edit(folder, |manifest| files(manifest, one)[0]["path"] = path.into());
        });
        assert!(said.contains(&format!("'{one}' has no WGSL file of its own")), "{path}: {said}");
    }
    let said = after(true, |folder| {
        edit(folder, |manifest| *files(manifest, one) = files(manifest, other).clone());
    });
    assert!(said.contains("has no WGSL file of its own"), "{said}");
    let said = after(true, |folder| {
        edit(folder, |manifest| {
            let variants = manifest["variants"].as_array_mut().unwrap();
            let again = variants[0].clone();
            variants.push(again);
        });
    });
    assert!(said.contains("twice"), "{said}");
    let said = after(true, |folder| {
        let text = read(folder, "wgsl/mip.wgsl");
        let text =
            text.replace("@binding(2) var sglow_mip_second", "@binding(4) var sglow_mip_second");
        std::fs::write(folder.join("wgsl/mip.wgsl"), text).unwrap();
    });
    assert!(said.contains("has no binding 'sglow_mip_second'"), "{said}");
    let assume = |fact: &str| {
        let assumed = serde_json::json!([{ "rule": "x", "fact": fact, "holds": false }]);
        let made_for = serde_json::json!({ "assumed": assumed, "chosen": {} });
        after(true, |folder| edit(folder, |manifest| manifest["made_for"] = made_for))
    };
    assert!(assume("colourful").contains("'colourful', which is no known fact"));
    assert_eq!(assume("specular"), "");
}
