//! glTF 2.0: metallic-roughness materials, textures, punctual lights, compressed buffer views.

use std::path::Path;

use buffer::Views;
use glam::{Mat3, Mat4, Vec3};
use gltf::khr_lights_punctual::Kind;
use gltf::mesh::{Mode, Semantic};
use material::{Converted, Materials};

use super::light::WIDEST;
use super::mesh::RawMesh;
use super::note::NoteKind;
use super::{Camera, Light, LightKind, SceneError};
use crate::draft::Draft;

mod accessor;
mod buffer;
mod container;
mod material;
mod meshopt;

/// Reads a `.gltf` or `.glb` file.
pub(super) fn load(file: &Path, bytes: &[u8]) -> Result<Draft, SceneError> {
    let container = container::split(file, bytes)?;
    let head: container::Head = container::parse(file, container.json)?;
    head.check(file)?;
    let root: gltf::json::Root = container::parse(file, container.json)?;
    buffer::validate(file, &root)?;
    let views = buffer::load(file, &root, container.binary)?;
    let document = gltf::Document::from_json_without_validation(root);

    let mut draft = Draft::default();
    for name in head.ignored() {
        draft.notes.add(NoteKind::Ignored, "extension", name);
    }
    for animation in document.animations() {
        let name = animation.name().map_or_else(|| animation.index().to_string(), str::to_owned);
        draft.notes.add(NoteKind::Ignored, "animation", name);
    }
    let mut materials = Materials::new(file, &document, &views);
    let mut uv_sets = Vec::new();
    for source in document.materials() {
        let Converted { material, uv_set } = materials.convert(&source, &mut draft.notes)?;
        draft.materials.push(material);
        uv_sets.push(uv_set);
    }
    draft.images = materials.images;
    let mut reader = Reader { file, document: &document, views: &views, uv_sets, draft };
    reader.read_scene()?;
    Ok(reader.draft)
}

struct Reader<'a> {
    file: &'a Path,
    document: &'a gltf::Document,
    views: &'a Views,
    /// Which set of texture coordinates each material needs.
    uv_sets: Vec<u32>,
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
        let mut open: Vec<_> = scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
        open.reverse();
        while let Some((node, parent)) = open.pop() {
            if std::mem::replace(&mut visited[node.index()], true) {
                return Err(SceneError::Invalid {
                    file: self.file.into(),
                    place: format!("nodes[{}]", node.index()),
                    reason: "is reached twice; nodes must form trees".to_owned(),
                });
            }
            let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            if let Some(mesh) = node.mesh() {
                if node.skin().is_some() {
                    self.draft.notes.add(NoteKind::Ignored, "skin", name_of(&mesh));
                }
                for primitive in mesh.primitives() {
                    self.read_primitive(&mesh, &primitive, world)?;
                }
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

    fn read_primitive(
        &mut self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
        world: Mat4,
    ) -> Result<(), SceneError> {
        let mut name = name_of(mesh);
        if mesh.primitives().len() > 1 {
            name = format!("{name}/{}", primitive.index());
        }
        let notes = &mut self.draft.notes;
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
        {
            notes.add(NoteKind::Ignored, "points and lines", name);
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            notes.add(NoteKind::Ignored, "mesh without positions", name);
            return Ok(());
        };
        if primitive.morph_targets().len() > 0 {
            notes.add(NoteKind::Ignored, "morph targets", &name);
        }
        if primitive.get(&Semantic::Colors(0)).is_some() {
            notes.add(NoteKind::Ignored, "vertex colours", &name);
        }
        let material = primitive.material().index().unwrap_or_else(|| self.default_material());
        let uv_set = self.uv_sets.get(material).copied().unwrap_or(0);

        let fault = |accessor: usize, semantic: &str, reason: String| SceneError::Accessor {
            file: self.file.into(),
            mesh: name.clone(),
            accessor,
            semantic: semantic.to_owned(),
            reason,
        };
        let positions = accessor::vectors::<3>(self.views, &positions)
            .map_err(|reason| fault(positions.index(), "POSITION", reason))?;
        let count = positions.len();
        let checked = |semantic: &str, accessor: usize, found: usize| {
            if found == count {
                Ok(())
            } else {
                let reason = format!("has {found} elements for {count} positions");
                Err(fault(accessor, semantic, reason))
            }
        };
        let normals = match primitive.get(&Semantic::Normals) {
            Some(source) => {
                let normals = accessor::vectors::<3>(self.views, &source)
                    .map_err(|reason| fault(source.index(), "NORMAL", reason))?;
                checked("NORMAL", source.index(), normals.len())?;
                normals
            }
            None => Vec::new(),
        };
        let uvs = match primitive.get(&Semantic::TexCoords(uv_set)) {
            Some(source) => {
                let semantic = format!("TEXCOORD_{uv_set}");
                let uvs = accessor::vectors::<2>(self.views, &source)
                    .map_err(|reason| fault(source.index(), &semantic, reason))?;
                checked(&semantic, source.index(), uvs.len())?;
                uvs
            }
            None => Vec::new(),
        };
        let indices = match primitive.indices() {
            Some(source) => {
                let indices = accessor::indices(self.views, &source)
                    .map_err(|reason| fault(source.index(), "indices", reason))?;
                if let Some(&index) = indices.iter().find(|&&index| index as usize >= count) {
                    let reason = format!("vertex {index} is out of range; there are {count}");
                    return Err(fault(source.index(), "indices", reason));
                }
                indices
            }
            None => (0..count as u32).collect(),
        };
        let textured =
            self.draft.materials.get(material).is_some_and(|m| m.textures().next().is_some());
        if textured && uvs.is_empty() {
            let text = "textures of a mesh without texture coordinates are read at (0, 0)";
            self.draft.notes.add(NoteKind::Assumed, text, &name);
        }
        let mut indices = into_list(primitive.mode(), indices);
        let linear = Mat3::from_mat4(world);
        if linear.determinant() < 0.0 {
            indices.as_chunks_mut::<3>().0.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        // The cofactors: the inverse transpose times the determinant, which does not need to exist.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors =
            Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * linear.determinant().signum();
        self.draft.meshes.push(RawMesh {
            name,
            positions: positions
                .into_iter()
                .map(|position| world.transform_point3(position.into()).into())
                .collect(),
            normals: normals
                .into_iter()
                .map(|normal| (cofactors * Vec3::from(normal)).into())
                .collect(),
            uvs,
            indices,
            material,
        });
        Ok(())
    }

    /// The index of the material of meshes without one, made when it is first needed.
    fn default_material(&mut self) -> usize {
        const NAME: &str = "default";
        let materials = &mut self.draft.materials;
        let first = self.uv_sets.len();
        if materials.len() == first {
            // [glTF 2.0, section 3.9.2: white, metallic 1, roughness 1]
            let material = super::Material::diffuse(NAME, [1.0; 3]);
            materials.push(super::Material { metallic: 1.0, dielectric: 0.04, ..material });
        }
        first
    }

    fn read_light(
        &mut self,
        node: &gltf::Node<'_>,
        light: &gltf::khr_lights_punctual::Light<'_>,
        world: Mat4,
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
        self.draft.lights.push(Light {
            name,
            kind,
            position: world.w_axis.truncate().into(),
            direction: (-world.z_axis.truncate()).normalize_or_zero().into(),
            intensity: light.color().map(|channel| channel * light.intensity()),
            range: light.range(),
        });
    }

    fn read_camera(&mut self, index: usize, world: Mat4) {
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
        let forward = (-world.z_axis.truncate()).normalize_or_zero();
        let up = world.y_axis.truncate();
        let position = world.w_axis.truncate().into();
        self.draft.camera = Some(Camera {
            near: Some(perspective.znear),
            far: perspective.zfar,
            ..Camera::along(position, forward, up, perspective.yfov)
        });
    }
}

fn name_of(mesh: &gltf::Mesh<'_>) -> String {
    mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned)
}

/// Strips and fans as lists. [glTF 2.0, section 3.7.2.1]
fn into_list(mode: Mode, indices: Vec<u32>) -> Vec<u32> {
    let pairs = || indices.windows(2).skip(1);
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .flat_map(|(i, corners)| match i % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[0], corners[2], corners[1]],
            })
            .collect(),
        Mode::TriangleFan => pairs().flat_map(|pair| [indices[0], pair[0], pair[1]]).collect(),
        _ => indices,
    }
}
