//! Where flicker comes from: flicker of the default, of wide kernels, of flat lights, 16384 of them as well, and of a cut
//! without visibility, by the size of the map.
//!
//! Prints RMS over the mean, as the report does, for each scene, and the same without the twentieth of the pixels that
//! change most.
//!
//! With values, of the default and of the default with each one, at the first size alone.
//!
//! `cargo run --release -p sglow-measure --example flicker -- cornell columns atrium`
//! `cargo run --release -p sglow-measure --example flicker -- columns lights=448 lights=800 tile=128 near_scale=3`

use std::error::Error;

use sglow_measure::frontier::case::Case;
use sglow_measure::frontier::named::configurations;
use sglow_measure::rivals::flicker::{Contender, flicker};
use sglow_renderer::device::Gpu;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::selection::whole_space;
use sglow_renderer::request::shot::load;
use sglow_results::frontier::promise::named;
use sglow_results::rivals::flicker::Walk;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::Library;

/// Widths and heights of the map.
const MAPS: [u32; 3] = [256, 512, 1024];
/// What is compared.
const NAMES: [&str; 5] = [named::OLD, named::DEFAULT, named::FLAT, named::BARE, named::BARE_16384];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
    let package = whole_space(&Library::load(folder.as_ref())?)?;
    let gpu = Gpu::open(None)?;
    println!("adapter {}, driver {}", gpu.adapter.name, gpu.adapter.driver);
    let (values, names): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument.contains('='));
    if names.is_empty() {
        return Err("name scenes, such as cornell".into());
    }
    for name in names {
        let (scene, _) = load(&name, None, &sglow_scene::Options::default())?;
        let case = Case::new(scene, Library::load(folder.as_ref())?, &Request::of([112, 63]))?;
        let sizes = if values.is_empty() { &MAPS[..] } else { &MAPS[..1] };
        for &map in sizes {
            let walk = Walk { frames: 5, pixels: 400, samples: 512, step: 0.002 };
            let base = &case.derivation.settings;
            let compared = if values.is_empty() {
                let occluders = case.space()?.of_class(&["occluders"])?;
                let named = configurations(base, &occluders).into_iter();
                let shown = named.filter(|(what, _)| NAMES.contains(what));
                shown.map(|(what, settings)| (what.to_owned(), settings)).collect()
            } else {
                with_each(base, &values)?
            };
            let contenders: Vec<Contender> = compared
                .into_iter()
                .map(|(name, settings)| Contender { name, settings: Settings { map, ..settings } })
                .collect();
            let found = flicker(&gpu, &package, &case.scene, &contenders, walk, |_| {})?;
            println!(
                "{name}, map of {map} squared: the reference changes by {:.2} %",
                100.0 * found.reference_change
            );
            for one in found.contenders {
                let [all, trimmed] = [one.flicker, one.trimmed].map(|flicker| 100.0 * flicker);
                println!("  {all:6.2} %, {trimmed:6.2} %  {}", one.name);
            }
        }
    }
    Ok(())
}

/// The default, and the default with each value.
fn with_each(
    base: &Settings,
    values: &[String],
) -> Result<Vec<(String, Settings)>, Box<dyn Error>> {
    let mut all = vec![("default".to_owned(), base.clone())];
    for value in values {
        let mut settings = base.clone();
        let (name, text) = value.split_once('=').unwrap_or((value, ""));
        settings.set(name, text)?;
        all.push((value.clone(), settings));
    }
    Ok(all)
}
