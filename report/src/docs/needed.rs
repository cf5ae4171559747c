//! What leaving out saves on each scene, as a table of `docs/results.md`.

use sglow_results::frontier::document::{Pruned, SceneReport};

use crate::docs::marks;
use crate::failure::Result;

/// Bytes and time with everything and with what each scene needs, and the axes on which both differ: the mark `needed`.
///
/// # Errors
///
/// When the document lacks the mark.
pub fn written(document: &str, name: &str, scenes: &[SceneReport], how: &str) -> Result<String> {
    let measured: Vec<(&str, &Pruned)> = scenes
        .iter()
        .filter_map(|scene| Some((scene.scene.as_str(), scene.pruned.as_ref()?)))
        .collect();
    let size = measured.first().map_or([0, 0], |(_, pruned)| pruned.size);
    let mut text = format!(
        "Measured by `{how}`, {} x {} pixels, medians in turns.\n\n| scene | textures, MB | shading, ms | frame, ms | numbers that differ | axes that differ |\n\
         |---|---|---|---|---|---|\n",
        size[0], size[1]
    );
    for (scene, pruned) in measured {
        let Pruned { full, needed, .. } = pruned;
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        let axes: Vec<String> = pruned.axes.keys().map(|axis| format!("`{axis}`")).collect();
        text.push_str(&format!(
            "| `{scene}` | {:.1} to {:.1} | {:.1} to {:.1} | {:.1} to {:.1} | {} | {} |\n",
            megabytes(full.texture_bytes),
            megabytes(needed.texture_bytes),
            full.shade_time.median,
            needed.shade_time.median,
            full.time.median,
            needed.time.median,
            pruned.differing,
            if axes.is_empty() { "none".to_owned() } else { axes.join(", ") },
        ));
    }
    marks::replaced(document, name, "needed", &text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::report::made_up;

    #[test]
    fn a_scene_has_what_is_left_out_of_it() {
        let scenes: Vec<SceneReport> =
            made_up::scenes().into_iter().map(|scene| scene.measured).collect();
        let (name, pruned) = scenes
            .iter()
            .find_map(|scene| Some((&scene.scene, scene.pruned.as_ref()?)))
            .expect("a made-up scene has it");
        let real = include_str!("../../../docs/results.md");
        let text = written(real, "docs/results.md", &scenes, "cargo xtask report").unwrap();
        let row = text
            .lines()
            .find(|line| line.starts_with(&format!("| `{name}` |")) && line.contains(" to "))
            .unwrap();
        let megabytes = format!("{:.1}", pruned.needed.texture_bytes as f64 / 1e6);
        assert!(row.contains(&megabytes), "{row}");
        assert!(pruned.axes.keys().all(|axis| row.contains(&format!("`{axis}`"))), "{row}");
        assert!(written("", "", &scenes, "").is_err());
    }
}
