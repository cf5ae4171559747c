//! The reference with visibility: a scene's triangles and materials as the oracle's paths meet them.

use glam::Vec3;
use sglow_oracle::Vector3;
use sglow_oracle::brdf;
use sglow_oracle::estimate::Estimate;
use sglow_oracle::light::Light;
use sglow_oracle::path::{MAP, Materials, Paths};
use sglow_oracle::surface::{self, Crossing, Facet, SceneError};

use super::{MapLights, growing, ndf, texels, vector};
use crate::frame::Surfaces;
use sglow_runtime::light::LightView;
use sglow_runtime::settings::Settings;
use sglow_scene::{Filter, Image, Material, Mesh, Scene, TextureUse, Wrap};

/// The triangles of a scene, mesh by mesh.
pub fn facets(scene: &Scene) -> Vec<Facet> {
    let mut facets = Vec::with_capacity(scene.triangle_count());
    for mesh in &scene.meshes {
        for corners in mesh.indices.as_chunks::<3>().0 {
            let corners = corners.map(|index| index as usize);
            facets.push(Facet {
                triangle: surface::Triangle {
                    positions: corners.map(|index| vector(mesh.positions[index])),
                    normals: corners.map(|index| vector(mesh.normals[index])),
                    material: mesh.material as u32,
                },
                uvs: corners
                    .map(|index| mesh.uvs.get(index).copied().unwrap_or_default().map(f64::from)),
                double_sided: scene.materials[mesh.material].double_sided,
            });
        }
    }
    facets
}

/// The materials of a scene, by the meaning of `shaders/src/surface/material.wesl`.
///
/// Textures are read bilinearly (or at the nearest texel where a material says so) on their finest level: a ray has no
/// pixel whose footprint would choose a mip level. What the rasteriser shows of a texture seen from afar is smoother.
#[derive(Clone, Debug)]
pub struct SceneMaterials<'a> {
    scene: &'a Scene,
    /// The number of the first triangle of each mesh.
    firsts: Vec<usize>,
}

impl Materials for SceneMaterials<'_> {
    fn material(&self, crossing: &Crossing) -> brdf::Material {
        let material = self.of(crossing);
        let read = |texture: &Option<TextureUse>| self.read(material, texture, crossing);
        let base_color = read(&material.base_color_texture);
        let of_vertices = self.color(crossing);
        let [r, g, b] = [0, 1, 2].map(|channel| {
            base_color[channel] * f64::from(material.base_color[channel]) * of_vertices[channel]
        });
        // glTF keeps roughness in green and metallic in blue.
        let [_, green, blue, _] = read(&material.metallic_roughness_texture);
        let roughness = f64::from(material.roughness) * green;
        brdf::Material::of_base_color(
            Vector3::new(r, g, b),
            f64::from(material.metallic) * blue,
            f64::from(material.dielectric),
            roughness * roughness,
        )
    }

    fn counts(&self, crossing: &Crossing) -> bool {
        let material = self.of(crossing);
        let Some(cutoff) = material.alpha_cutoff else { return true };
        let [.., of_vertices] = self.color(crossing);
        // An untextured material has one opacity; a mask then keeps all of it.
        if material.textures().next().is_none() && of_vertices >= 1.0 {
            return true;
        }
        let [.., alpha] = self.read(material, &material.base_color_texture, crossing);
        alpha * f64::from(material.base_color[3]) * of_vertices >= f64::from(cutoff)
    }

    fn normal(&self, crossing: &Crossing) -> Vector3 {
        let (hit, material) = (&crossing.hit, self.of(crossing));
        let (Some(map), Some((mesh, corners))) = (&material.normal_texture, self.place(crossing))
        else {
            return hit.normal;
        };
        let weights = hit.weights;
        let Some([tx, ty, tz, sign]) = mixed(&mesh.detail.tangents, corners, weights) else {
            return hit.normal;
        };
        let normals = corners.map(|corner| vector(mesh.normals[corner]));
        let normal = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
        let tangent = Vector3::new(tx, ty, tz);
        let texel = self.read(material, &Some(*map), crossing).map(|channel| 2.0 * channel - 1.0);
        let scale = f64::from(material.normal_scale);
        // [glTF 2.0, section 3.9.3]
        let mapped = tangent * (scale * texel[0])
            + normal.cross(tangent) * (sign * scale * texel[1])
            + normal * texel[2];
        let mapped = mapped.normalized();
        if normal.dot(hit.normal) < 0.0 { -mapped } else { mapped }
    }
}

/// An attribute interpolated between three vertices; none where the mesh lacks it.
fn mixed<const N: usize>(
    list: &[[f32; N]],
    corners: [usize; 3],
    weights: [f64; 3],
) -> Option<[f64; N]> {
    let mut sum = [0.0; N];
    for (corner, weight) in corners.into_iter().zip(weights) {
        for (sum, &part) in sum.iter_mut().zip(list.get(corner)?) {
            *sum += weight * f64::from(part);
        }
    }
    Some(sum)
}

impl<'a> SceneMaterials<'a> {
    /// Those of a scene whose triangles are [`facets`].
    pub fn new(scene: &'a Scene) -> Self {
        let mut next = 0;
        let first = |mesh: &Mesh| {
            let first = next;
            next += mesh.triangle_count();
            first
        };
        Self { scene, firsts: scene.meshes.iter().map(first).collect() }
    }

    fn of(&self, crossing: &Crossing) -> &Material {
        &self.scene.materials[crossing.hit.material as usize]
    }

    /// The mesh of a triangle and its three vertices.
    fn place(&self, crossing: &Crossing) -> Option<(&Mesh, [usize; 3])> {
        let triangle = crossing.hit.triangle;
        let after = self.firsts.partition_point(|&first| first <= triangle);
        let mesh = after.checked_sub(1)?;
        let (mesh, first) = (self.scene.meshes.get(mesh)?, self.firsts.get(mesh)?);
        let corners = mesh.indices.as_chunks::<3>().0.get(triangle - first)?;
        Some((mesh, corners.map(|corner| corner as usize)))
    }

    /// Colour and opacity of the vertices, white where they have none.
    fn color(&self, crossing: &Crossing) -> [f64; 4] {
        let found = self
            .place(crossing)
            .and_then(|(mesh, corners)| mixed(&mesh.detail.colors, corners, crossing.hit.weights));
        found.unwrap_or([1.0; 4])
    }

    /// The texture coordinates that a texture is read at.
    fn uv(&self, texture: &TextureUse, crossing: &Crossing) -> [f64; 2] {
        if !texture.second {
            return crossing.uv;
        }
        let found = self
            .place(crossing)
            .and_then(|(mesh, corners)| mixed(&mesh.detail.uvs, corners, crossing.hit.weights));
        found.unwrap_or_default()
    }

    /// A texture at a place, white if there is none; all textures of a material are read as its first one is.
    fn read(
        &self,
        material: &Material,
        texture: &Option<TextureUse>,
        crossing: &Crossing,
    ) -> [f64; 4] {
        let white = [1.0; 4];
        let (Some(texture), Some(first)) = (texture, material.textures().next()) else {
            return white;
        };
        let Some(image) = self.scene.images.get(texture.image) else { return white };
        let uv = self.uv(texture, crossing);
        let at = texture
            .transform
            .rows()
            .map(|[a, b, c]| f64::from(a) * uv[0] + f64::from(b) * uv[1] + f64::from(c));
        sample(image, first, at)
    }
}

/// The texel of a coordinate on an axis of `size` texels.
fn wrapped(coordinate: f64, size: u32, wrap: Wrap) -> u32 {
    let size_f = f64::from(size);
    let inside = match wrap {
        Wrap::Clamp => coordinate.clamp(0.0, size_f - 1.0),
        Wrap::Repeat => coordinate.rem_euclid(size_f),
        Wrap::Mirror => {
            let twice = coordinate.rem_euclid(2.0 * size_f);
            if twice < size_f { twice } else { 2.0 * size_f - 1.0 - twice }
        }
    };
    (inside as u32).min(size - 1)
}

/// The finest level of an image at texture coordinates, of linear light.
fn sample(image: &Image, how: &TextureUse, at: [f64; 2]) -> [f64; 4] {
    let size = [image.width, image.height];
    let texel = |x: f64, y: f64| {
        let [x, y] = [(0, x), (1, y)].map(|(axis, part)| wrapped(part, size[axis], how.wrap[axis]));
        let first = 4 * (y as usize * image.width as usize + x as usize);
        [0, 1, 2, 3].map(|channel| linear(image, channel, image.rgba8[first + channel]))
    };
    // What is no number reads the first texel.
    let at = at.map(|part| if part.is_finite() { part } else { 0.0 });
    let place = [0, 1].map(|axis| at[axis] * f64::from(size[axis]));
    if how.magnify == Filter::Nearest {
        return texel(place[0].floor(), place[1].floor());
    }
    let [x, y] = place.map(|part| (part - 0.5).floor());
    let [right, below] = [place[0] - 0.5 - x, place[1] - 0.5 - y];
    let corners = [texel(x, y), texel(x + 1.0, y), texel(x, y + 1.0), texel(x + 1.0, y + 1.0)];
    let weights = [
        (1.0 - right) * (1.0 - below),
        right * (1.0 - below),
        (1.0 - right) * below,
        right * below,
    ];
    [0, 1, 2, 3].map(|channel| {
        corners.iter().zip(weights).map(|(corner, weight)| corner[channel] * weight).sum()
    })
}

fn linear(image: &Image, channel: usize, value: u8) -> f64 {
    let value = f64::from(value) / 255.0;
    if !image.srgb || channel == 3 { value } else { sglow_oracle::flip::decoded(value) }
}

/// The indirect light of a frame by `samples` paths of one bounce per pixel and light, in f64, with exact visibility: see
/// [`sglow_oracle::path`]. Lights add up. The same `seed` gives the same numbers.
///
/// `progress` gets how many of the pixels are done, from several threads, and says whether to go on; the result is
/// `None` if it said no.
///
/// # Errors
/// [`SceneError`] names a triangle that is not finite.
#[expect(clippy::too_many_arguments, reason = "what a frame consists of, and how many paths")]
pub fn paths(
    view: &LightView,
    settings: &Settings,
    scene: &Scene,
    gbuffer: &Surfaces,
    eye: Vec3,
    samples: u32,
    seed: u64,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Result<Option<Vec<Estimate>>, SceneError> {
    let halves = path_halves(view, settings, scene, gbuffer, eye, samples, seed, progress)?;
    Ok(halves.map(|halves| halves.iter().map(Estimate::mean_of).collect()))
}

/// The same as two independent references of each pixel, of half the samples each: their mean is what [`paths`] gives.
///
/// # Errors
/// [`SceneError`] names a triangle that is not finite.
#[expect(clippy::too_many_arguments, reason = "what a frame consists of, and how many paths")]
pub fn path_halves(
    view: &LightView,
    settings: &Settings,
    scene: &Scene,
    gbuffer: &Surfaces,
    eye: Vec3,
    samples: u32,
    seed: u64,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Result<Option<Vec<[Estimate; 2]>>, SceneError> {
    let triangles = &surface::Scene::new(facets(scene))?;
    let receivers = texels(gbuffer);
    let count = view.each().len();
    let progress = growing(receivers.len(), progress);
    Ok(of_each_light(view, |number, light| {
        let paths = Paths {
            scene: triangles,
            materials: &SceneMaterials::new(scene),
            light,
            ndf: ndf(settings.ndf),
            samples,
            map: MAP,
            // Noise of its own for each light; that of the first is the seed's.
            seed: seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)),
        };
        let report = |done| progress((number * receivers.len() + done) / count);
        paths.halves(&receivers, vector(eye), &report)
    }))
}

/// What comes of each light of a view, added up: light is linear. Nothing if nothing comes of one of them.
pub fn of_each_light(
    view: &LightView,
    mut of: impl FnMut(usize, &Light) -> Option<Vec<[Estimate; 2]>>,
) -> Option<Vec<[Estimate; 2]>> {
    let lights = MapLights::of(view).each;
    let mut sums: Option<Vec<[Estimate; 2]>> = None;
    for (number, light) in lights.iter().enumerate() {
        let found = of(number, light)?;
        let sum = |([a, b], [c, d]): ([Estimate; 2], [Estimate; 2])| [a + c, b + d];
        sums = Some(match sums {
            None => found,
            Some(sums) => sums.into_iter().zip(found).map(sum).collect(),
        });
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use sglow_scene::UvTransform;

    fn image(srgb: bool) -> Image {
        let rgba8 = vec![
            0, 0, 0, 255, 255, 128, 0, 255, //
            255, 255, 255, 0, 0, 255, 128, 255,
        ];
        Image { name: "squares".to_owned(), width: 2, height: 2, rgba8, srgb }
    }

    fn near(found: [f64; 4], expected: [f64; 4]) -> bool {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12)
    }

    #[test]
    fn textures_are_read_as_a_sampler_reads_them() {
        let use_with =
            |wrap, magnify| TextureUse { wrap: [wrap; 2], magnify, ..TextureUse::repeating(0) };
        let linear = use_with(Wrap::Clamp, Filter::Linear);
        let plain = image(false);
        assert!(near(sample(&plain, &linear, [0.25, 0.25]), [0.0, 0.0, 0.0, 1.0]));
        let middle = [0.5, (128.0 / 255.0 + 2.0) / 4.0, (1.0 + 128.0 / 255.0) / 4.0, 0.75];
        assert!(near(sample(&plain, &linear, [0.5, 0.5]), middle));
        // Outside: the edge, the other side, the mirror image.
        let right = [1.0, 128.0 / 255.0, 0.0, 1.0];
        for (wrap, expected) in
            [(Wrap::Clamp, right), (Wrap::Repeat, [0.0, 0.0, 0.0, 1.0]), (Wrap::Mirror, right)]
        {
            for magnify in [Filter::Linear, Filter::Nearest] {
                let found = sample(&plain, &use_with(wrap, magnify), [1.25, 0.25]);
                assert!(near(found, expected), "{wrap:?} {magnify:?} {found:?}");
            }
        }
        let repeated = sample(&plain, &use_with(Wrap::Repeat, Filter::Linear), [0.0, 0.25]);
        assert!(near(repeated, [0.5, 64.0 / 255.0, 0.0, 1.0]), "{repeated:?}");
        // sRGB is decoded before it is filtered, opacity never is.
        let bright = sample(&image(true), &linear, [0.75, 0.25]);
        assert!((bright[1] - 0.215_860_5).abs() < 1e-6 && (bright[0], bright[3]) == (1.0, 1.0));
        // Coordinates that are no numbers read some texel.
        assert!(sample(&plain, &linear, [f64::NAN, 1e300])[0].is_finite());
    }

    #[test]
    fn a_scene_gives_its_factors_its_textures_and_its_holes() {
        let mut scene = Scene::builtin("cornell").unwrap();
        let found = facets(&scene);
        assert_eq!(found.len(), scene.triangle_count());
        assert!(found.iter().all(|facet| !facet.double_sided));
        scene.images.push(image(false));
        let texture = TextureUse { magnify: Filter::Nearest, ..TextureUse::repeating(0) };
        let material = &mut scene.materials[0];
        material.base_color = [0.5, 1.0, 1.0, 0.8];
        (material.roughness, material.metallic, material.dielectric) = (0.5, 0.6, 0.04);
        material.base_color_texture = Some(texture);
        // Upside down: the lower row is read.
        let down = UvTransform { offset: [0.0, 0.5], ..UvTransform::default() };
        material.metallic_roughness_texture = Some(TextureUse { transform: down, ..texture });
        let at = |uv: [f64; 2]| {
            let facet = found.iter().find(|facet| facet.triangle.material == 0).unwrap();
            Crossing {
                hit: surface::Hit {
                    distance: 1.0,
                    position: Vector3::zero(),
                    normal: Vector3::new(0.0, 1.0, 0.0),
                    weights: [1.0, 0.0, 0.0],
                    triangle: 0,
                    material: facet.triangle.material,
                },
                uv,
                side: Vector3::new(0.0, 1.0, 0.0),
            }
        };
        let read = SceneMaterials::new(&scene).material(&at([0.75, 0.25]));
        let color = [0.5, 128.0 / 255.0, 0.0];
        let metallic = f64::from(0.6_f32) * 128.0 / 255.0;
        assert!((read.alpha - 0.25).abs() < 1e-12);
        for (channel, (diffuse, specular)) in
            read.diffuse.to_array().into_iter().zip(read.specular.to_array()).enumerate()
        {
            assert!((diffuse - color[channel] * (1.0 - metallic)).abs() < 1e-7);
            let expected = f64::from(0.04_f32) * (1.0 - metallic) + color[channel] * metallic;
            assert!((specular - expected).abs() < 1e-7);
        }
        // The texel below has no opacity; without a mask it is there nevertheless.
        let hole = at([0.25, 0.75]);
        assert!(SceneMaterials::new(&scene).counts(&hole));
        scene.materials[0].alpha_cutoff = Some(0.5);
        assert!(!SceneMaterials::new(&scene).counts(&hole));
        assert!(SceneMaterials::new(&scene).counts(&at([0.75, 0.25])));
        scene.materials[0].alpha_cutoff = Some(0.9);
        assert!(
            !SceneMaterials::new(&scene).counts(&at([0.75, 0.25])),
            "the factor of opacity counts"
        );
    }
}
