//! Which pipelines a material is drawn with.

use sglow_scene::Traits;
use sglow_shaders::{Material as MaterialAxis, Opacity};

/// Which pipelines a material is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    /// What is read beside the material itself.
    pub(super) material: MaterialAxis,
    cutout: bool,
    pub(super) double_sided: bool,
}

impl Kind {
    /// What a material needs, and no more.
    pub(super) fn of(material: &sglow_scene::Material, traits: &Traits) -> Self {
        let (read, opacity) = axes(traits);
        let cutout = opacity == Opacity::Cutout;
        Self { material: read, cutout, double_sided: material.double_sided }
    }

    pub(super) fn opacity(self) -> Opacity {
        if self.cutout { Opacity::Cutout } else { Opacity::Opaque }
    }
}

/// The values of the axes that a material is drawn with.
pub(crate) fn axes(traits: &Traits) -> (MaterialAxis, Opacity) {
    let material = match *traits {
        Traits { detailed: true, .. } => MaterialAxis::Detailed,
        Traits { textured: true, .. } => MaterialAxis::Textured,
        _ => MaterialAxis::Constant,
    };
    (material, if traits.cutout { Opacity::Cutout } else { Opacity::Opaque })
}
