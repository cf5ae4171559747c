//! glTF 2.0: metallic-roughness and specular-glossiness materials, textures, punctual lights, copies of meshes,
//! compressed buffer views.

use glam::{DMat4, DVec3};
use gltf::khr_lights_punctual::Kind;

use super::files::Files;
use super::light::WIDEST;
use super::note::NoteKind;
use super::{Camera, Light, LightKind, SceneError};
use crate::draft::Draft;
use crate::origin::Placed;
use buffer::Views;
use material::Converted;
use texture::Textures;

mod accessor;
mod buffer;
mod container;
mod instances;
mod material;
mod meshopt;
mod node;
mod primitive;
mod specular;
mod texture;

/// Reads a `.gltf` or `.glb` file.
pub(super) fn load(files: &Files<'_>, bytes: &[u8]) -> Result<Draft, SceneError> {
    let file = files.scene;
    let container = container::split(file, bytes)?;
    let head: container::Head = container::parse(file, container.json)?;
    head.check(file)?;
    let root: gltf::json::Root = container::parse(file, container.json)?;
    buffer::validate(file, &root)?;
    let node::Nodes { nodes } = container::parse(file, container.json)?;
    let views = Views::load(files, &root, container.binary);
    let document = gltf::Document::from_json_without_validation(root);

    let mut draft = Draft::default();
    for name in head.ignored() {
        draft.notes.add(NoteKind::Ignored, "extension", name);
    }
    for animation in document.animations() {
        let name = animation.name().map_or_else(|| animation.index().to_string(), str::to_owned);
        draft.notes.add(NoteKind::Ignored, "animation", name);
    }
    let mut textures = Textures::new(*files, &document, &views);
    let mut materials = Vec::new();
    for source in document.materials() {
        let converted = material::convert(&source, &mut textures, &mut draft.notes);
        draft.materials.push(converted.material.clone());
        materials.push(converted);
    }
    draft.images = textures.images;
    let transforms = nodes.iter().map(node::Node::transform).collect();
    let mut reader =
        Reader { files, document: &document, views: &views, transforms, materials, draft };
    reader.read_scene()?;
    Ok(reader.draft)
}

struct Reader<'a> {
    files: &'a Files<'a>,
    document: &'a gltf::Document,
    views: &'a Views<'a>,
    /// Of each node, to its parent.
    transforms: Vec<DMat4>,
    materials: Vec<Converted>,
    draft: Draft,
}

impl Reader<'_> {
    /// Walks the nodes of the default scene, parents before children, in the file's order.
    fn read_scene(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            return Ok(());
        };
        if document.scenes().len() > 1 {
            let text = "scenes other than the default one";
            self.draft.notes.add(NoteKind::Ignored, text, "");
        }
        let mut visited = vec![false; document.nodes().len()];
        let mut open: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        open.reverse();
        while let Some((node, parent)) = open.pop() {
            if std::mem::replace(&mut visited[node.index()], true) {
                return Err(SceneError::Invalid {
                    file: self.files.scene.into(),
                    place: format!("nodes[{}]", node.index()),
                    reason: "is reached twice; nodes must form trees".to_owned(),
                });
            }
            let own = self.transforms.get(node.index()).copied().unwrap_or_default();
            let world = parent * own;
            if let Some(mesh) = node.mesh() {
                if node.skin().is_some() {
                    self.draft.notes.add(
                        NoteKind::Ignored,
                        "skin: the mesh keeps its shape",
                        name_of(&mesh),
                    );
                }
                self.read_mesh(&node, &mesh, world)?;
            }
            if let Some(light) = node.light() {
                self.read_light(&node, &light, world);
            }
            if let Some(camera) = node.camera() {
                self.read_camera(camera.index(), world);
            }
            let first = open.len();
            open.extend(node.children().map(|child| (child, world)));
            open[first..].reverse();
        }
        Ok(())
    }

    /// Reads a node's mesh, once for each of its copies.
    fn read_mesh(
        &mut self,
        node: &gltf::Node<'_>,
        mesh: &gltf::Mesh<'_>,
        world: DMat4,
    ) -> Result<(), SceneError> {
        let copies = instances::transforms(self.files, self.document, self.views, node)?;
        for primitive in mesh.primitives() {
            let mut name = name_of(mesh);
            if mesh.primitives().len() > 1 {
                name = format!("{name}/{}", primitive.index());
            }
            let count = copies.as_ref().map_or(1, Vec::len);
            let draft = &mut self.draft;
            let (files, views, materials) = (self.files, self.views, &self.materials);
            let read = primitive::read(files, views, materials, name, &primitive, count, draft)?;
            let Some(mesh) = read else { continue };
            let copies = copies.as_deref().unwrap_or(&[DMat4::IDENTITY]);
            draft.meshes.push(primitive::placed(&mesh, world, copies));
        }
        Ok(())
    }

    fn read_light(
        &mut self,
        node: &gltf::Node<'_>,
        light: &gltf::khr_lights_punctual::Light<'_>,
        world: DMat4,
    ) {
        let name = light.name().or(node.name());
        let name = name.map_or_else(|| format!("light {}", light.index()), str::to_owned);
        let kind = match light.kind() {
            Kind::Directional => LightKind::Directional,
            Kind::Point => LightKind::Point,
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                if outer_cone_angle > WIDEST {
                    let text = "cone narrowed to 89 degrees from its axis";
                    self.draft.notes.add(NoteKind::Assumed, text, &name);
                }
                let outer = outer_cone_angle.min(WIDEST);
                // A hard edge is allowed there, a cone that ends where it starts is not here.
                LightKind::Spot { inner: inner_cone_angle.min(outer * 0.999), outer }
            }
        };
        let light = Light {
            name,
            kind,
            position: [0.0; 3],
            direction: (-world.z_axis.truncate()).normalize_or_zero().as_vec3().into(),
            intensity: light.color().map(|channel| channel * light.intensity()),
            range: light.range(),
            map_share: 1.0,
        };
        self.draft.lights.push(Placed::at(world.w_axis.truncate(), light));
    }

    fn read_camera(&mut self, index: usize, world: DMat4) {
        let json = &self.document.as_json().cameras[index];
        let name = json.name.clone().unwrap_or_else(|| index.to_string());
        let Some(perspective) = &json.perspective else {
            self.draft.notes.add(NoteKind::Ignored, "orthographic camera", name);
            return;
        };
        if self.draft.camera.is_some() {
            self.draft.notes.add(NoteKind::Ignored, "camera besides the first", name);
            return;
        }
        let unit = |axis: DVec3| axis.normalize_or_zero().as_vec3();
        let (forward, up) = (unit(-world.z_axis.truncate()), unit(world.y_axis.truncate()));
        let camera = Camera {
            near: Some(perspective.znear),
            far: perspective.zfar,
            ..Camera::along([0.0; 3], forward, up, perspective.yfov)
        };
        self.draft.camera = Some(Placed::at(world.w_axis.truncate(), camera));
    }
}

fn name_of(mesh: &gltf::Mesh<'_>) -> String {
    mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned)
}
