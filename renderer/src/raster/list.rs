//! A scene's draws as a frame takes them that is data.

use std::collections::{BTreeMap, BTreeSet};

use super::kind::Kind;
use super::{Draw, Raster, shared_layout};
use sglow_runtime::execute::{DrawKind, DrawList};

/// Draws of a scene, sorted by kind.
pub struct SceneDraws<'a> {
    raster: &'a Raster,
    draws: Vec<&'a Draw>,
    kinds: Vec<Kind>,
}

impl Raster {
    /// All surfaces.
    pub fn surfaces(&self) -> SceneDraws<'_> {
        SceneDraws::new(self, self.draws.iter().collect())
    }

    /// Those that emit.
    pub fn emitters(&self) -> SceneDraws<'_> {
        SceneDraws::new(self, self.draws.iter().filter(|draw| draw.emits).collect())
    }
}

impl<'a> SceneDraws<'a> {
    fn new(raster: &'a Raster, draws: Vec<&'a Draw>) -> Self {
        let mut kinds: Vec<_> = draws.iter().map(|draw| draw.kind).collect();
        kinds.dedup();
        Self { raster, draws, kinds }
    }

    /// The values of axes that occur.
    pub fn axes(&self) -> BTreeSet<BTreeMap<String, String>> {
        self.kinds.iter().map(|kind| kind.named()).collect()
    }
}

impl Kind {
    fn named(self) -> BTreeMap<String, String> {
        let named = |axis: &str, value: String| (axis.to_owned(), value);
        BTreeMap::from([
            named("material", self.material.to_string()),
            named("opacity", self.opacity().to_string()),
        ])
    }
}

impl DrawList for SceneDraws<'_> {
    fn kinds(&self) -> Vec<DrawKind> {
        let kind = |kind: &Kind| DrawKind {
            axes: kind.named(),
            primitive: wgpu::PrimitiveState {
                cull_mode: (!kind.double_sided).then_some(wgpu::Face::Back),
                ..Default::default()
            },
            groups: vec![(1, shared_layout(&self.raster.device, kind.material, 1))],
        };
        self.kinds.iter().map(kind).collect()
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &[wgpu::RenderPipeline]) {
        let raster = self.raster;
        pass.set_vertex_buffer(0, raster.vertices.slice(..));
        pass.set_index_buffer(raster.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut kinds = self.kinds.iter().zip(pipelines).peekable();
        for draw in &self.draws {
            while kinds.next_if(|(kind, _)| **kind < draw.kind).is_some() {}
            let Some((_, pipeline)) = kinds.peek() else { return };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, &raster.materials[draw.material], &[]);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
    }
}
