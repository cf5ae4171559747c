//! Whether a shader has the entry points and bindings of its manifest entry.

/// The first entry point or binding (group, number, name) that a text in WGSL lacks.
pub fn missing<'a>(
    text: &str,
    entry_points: &[String],
    mut bindings: impl Iterator<Item = (u32, u32, &'a str)>,
) -> Option<String> {
    let text: String = text.split_whitespace().collect();
    let is_missing = |name: &&String| !text.contains(&format!("fn{name}("));
    if let Some(name) = entry_points.iter().find(is_missing) {
        return Some(format!("entry point '{name}'"));
    }
    // `@group(0) @binding(1) var<storage> name: …`, its attributes in any order.
    let is_missing = |(group, number, name): &(u32, u32, &str)| {
        let attributes = [format!("@group({group})"), format!("@binding({number})")];
        let names = [">", "var"].map(|before| format!("{before}{name}:"));
        !text.split(';').any(|part| {
            attributes.iter().all(|attribute| part.contains(attribute))
                && names.iter().any(|name| part.contains(name))
        })
    };
    bindings.find(is_missing).map(|(_, _, name)| format!("binding '{name}'"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entry_points_and_bindings_have_their_names_and_numbers() {
        let text = "// a; b\n@group(0) @binding(1)\nvar<storage, read> lights: array<u32>;\n\
            @binding(2) @group(0) var map: texture_2d<f32>;\n@compute @workgroup_size(1)\nfn main() {}\n";
        let said = |entry: &str, binding: (u32, u32, &str)| {
            missing(text, &[entry.to_owned()], [binding].into_iter())
        };
        assert_eq!(said("main", (0, 1, "lights")), None);
        assert_eq!(said("main", (0, 2, "map")), None);
        assert_eq!(said("mains", (0, 1, "lights")), Some("entry point 'mains'".to_owned()));
        for wrong in [(0, 2, "lights"), (1, 1, "lights"), (0, 1, "light"), (0, 1, "map")] {
            assert_eq!(said("main", wrong), Some(format!("binding '{}'", wrong.2)), "{wrong:?}");
        }
    }
}
