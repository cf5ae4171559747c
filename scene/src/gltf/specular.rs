//! Specular-glossiness as metallic-roughness. [KHR_materials_pbrSpecularGlossiness]

use gltf::material::PbrSpecularGlossiness;

use super::texture::Textures;
use crate::{Image, Material, TextureUse};

/// Which of the texels, in order of their least specular reflectance, is taken for the dielectric: not the least one,
/// for maps have corners that nothing uses.
const QUANTILE: f64 = 0.05;

/// Finds base colour, metallic and dielectric with the same `R_d` and `R_s`: exactly where the specular colour is grey,
/// else with the same mean over the channels.
pub(super) fn of_factors(material: &mut Material, source: &PbrSpecularGlossiness<'_>) {
    let [r, g, b, alpha] = source.diffuse_factor();
    let specular = source.specular_factor();
    material.roughness = 1.0 - source.glossiness_factor();
    material.dielectric = specular.iter().copied().fold(1.0, f32::min);
    let (base, metallic) = metallic_of([r, g, b], specular, material.dielectric);
    material.metallic = metallic;
    material.base_color = [base[0], base[1], base[2], alpha];
}

/// Base colour and metallic of a diffuse and a specular colour, for a dielectric reflectance.
fn metallic_of(diffuse: [f32; 3], specular: [f32; 3], dielectric: f32) -> ([f32; 3], f32) {
    let mean = |color: [f32; 3]| color.iter().sum::<f32>() / 3.0;
    let largest = specular.iter().copied().fold(0.0, f32::max);
    // [KHR_materials_pbrSpecularGlossiness: c_diff = diffuse (1 - max(specular))]
    let diffuse = diffuse.map(|channel| channel * (1.0 - largest));
    if largest - dielectric <= 1e-3 {
        return (diffuse, 0.0);
    }
    // With t = 1 - metallic and d the dielectric, R_d = base t and R_s = d t + base (1 - t), so
    // base = R_d + R_s - d t and d t^2 - (D + S) t + D = 0 for the means D and S; the smaller root,
    // in the form that does not cancel.
    let (d, s) = (mean(diffuse), mean(specular));
    let root = ((d + s) * (d + s) - 4.0 * dielectric * d).max(0.0).sqrt();
    let t = if d > 0.0 { (2.0 * d / (d + s + root)).clamp(0.0, 1.0) } else { 0.0 };
    let base = |i: usize| (diffuse[i] + specular[i] - dielectric * t).clamp(0.0, 1.0);
    ([base(0), base(1), base(2)], 1.0 - t)
}

/// Reads both maps into ours, texel by texel, with one dielectric reflectance for all of the material. The diffuse map,
/// if there is one, is read at the same places.
pub(super) fn of_maps(
    material: &mut Material,
    source: &PbrSpecularGlossiness<'_>,
    textures: &mut Textures<'_>,
    diffuse: Option<TextureUse>,
    specular: TextureUse,
) -> Result<(), String> {
    let image = |usage: TextureUse| textures.images.get(usage.image);
    let (Some(specular_image), diffuse_image) = (image(specular), diffuse.and_then(image)) else {
        return Ok(());
    };
    let width = specular_image.width.max(diffuse_image.map_or(1, |image| image.width));
    let height = specular_image.height.max(diffuse_image.map_or(1, |image| image.height));
    let (needed, left) = (2 * width as usize * height as usize, textures.texels_left());
    if needed > left {
        return Err(format!("takes {needed} texels, more than the {left} left"));
    }
    let factors = (source.diffuse_factor(), source.specular_factor(), source.glossiness_factor());
    let read = |u: f32, v: f32| {
        let [r, g, b, alpha] = diffuse_image.map_or([1.0; 4], |image| image.nearest(u, v));
        let [sr, sg, sb, gloss] = specular_image.nearest(u, v);
        let (diffuse, specular, glossiness) = factors;
        let product = |a: [f32; 3], b: [f32; 3]| [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
        (
            product([r, g, b], [diffuse[0], diffuse[1], diffuse[2]]),
            product([sr, sg, sb], specular),
            gloss * glossiness,
            alpha * diffuse[3],
        )
    };
    // How many texels, and their sum, in each part of the range.
    let mut least = vec![(0_u32, 0.0_f64); 256];
    for texel in 0..specular_image.texels() {
        let (x, y) = (texel as u32 % specular_image.width, texel as u32 / specular_image.width);
        let place = |at: u32, size: u32| (at as f32 + 0.5) / size as f32;
        let (_, [r, g, b], ..) =
            read(place(x, specular_image.width), place(y, specular_image.height));
        // Square roots, for most reflectances are small.
        let value = r.min(g).min(b).clamp(0.0, 1.0);
        let (count, sum) = &mut least[(value.sqrt() * 255.0) as usize];
        *count += 1;
        *sum += f64::from(value);
    }
    let wanted = specular_image.texels() as f64 * QUANTILE;
    let mut below = 0_u32;
    let part = least.iter().find(|(count, _)| {
        below += count;
        f64::from(below) > wanted
    });
    material.dielectric = part.map_or(0.0, |&(count, sum)| (sum / f64::from(count)) as f32);
    let name = specular_image.name.clone();
    let made = |u: f32, v: f32| {
        let (diffuse, specular, glossiness, alpha) = read(u, v);
        let (base, metallic) = metallic_of(diffuse, specular, material.dielectric);
        (base, metallic, 1.0 - glossiness, alpha)
    };
    let color = Image::make(&format!("{name}: base colour"), [width, height], true, |u, v| {
        let ([r, g, b], .., alpha) = made(u, v);
        [r, g, b, alpha]
    });
    let surface =
        Image::make(&format!("{name}: roughness, metallic"), [width, height], false, |u, v| {
            let (_, metallic, roughness, _) = made(u, v);
            [0.0, roughness, metallic, 1.0]
        });
    material.base_color = [1.0; 4];
    (material.roughness, material.metallic) = (1.0, 1.0);
    let [color, surface] = [color, surface].map(|image| textures.push(image));
    let how = diffuse.unwrap_or(specular);
    material.base_color_texture = Some(TextureUse { image: color, ..how });
    material.metallic_roughness_texture = Some(TextureUse { image: surface, ..how });
    Ok(())
}
