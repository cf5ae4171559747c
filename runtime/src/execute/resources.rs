//! Buffers, textures and samplers of a frame, with the views that steps bind.

use std::collections::BTreeSet;

use sglow_graph::description::Filter;
use sglow_graph::frame::{self, Kind, View};

use super::error::Fault;
use super::input::{External, Inputs};
use super::names;
use crate::pipeline::guarded;

/// What is made here can be filled, read back and bound by the host, too.
const OWN_BUFFER: wgpu::BufferUsages =
    wgpu::BufferUsages::COPY_SRC.union(wgpu::BufferUsages::COPY_DST);
const OWN_TEXTURE: wgpu::TextureUsages = wgpu::TextureUsages::COPY_SRC
    .union(wgpu::TextureUsages::COPY_DST)
    .union(wgpu::TextureUsages::TEXTURE_BINDING);

/// What a resource is on the device.
#[derive(Clone, Debug)]
enum Object {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

#[derive(Debug)]
struct Resource {
    of: frame::Resource,
    /// How steps use it.
    buffer: wgpu::BufferUsages,
    texture: wgpu::TextureUsages,
    object: Option<Object>,
    /// Frames since it was new.
    age: u32,
}

/// A view that a step binds.
#[derive(Debug)]
struct Bound {
    view: View,
    dimension: wgpu::TextureViewDimension,
    made: Option<wgpu::TextureView>,
}

/// All resources of a frame.
#[derive(Debug)]
pub(super) struct Resources {
    list: Vec<Resource>,
    views: Vec<Bound>,
    /// Which of them the host has changed in this frame.
    changed: Vec<bool>,
}

impl Resources {
    pub(super) fn new(frame: &frame::Frame) -> Self {
        let one = |of: &frame::Resource| Resource {
            of: of.clone(),
            buffer: wgpu::BufferUsages::empty(),
            texture: wgpu::TextureUsages::empty(),
            object: None,
            age: 0,
        };
        let list: Vec<_> = frame.resources.iter().map(one).collect();
        Self { changed: vec![false; list.len()], list, views: Vec::new() }
    }

    pub(super) fn kind(&self, resource: usize) -> Option<&Kind> {
        self.list.get(resource).map(|one| &one.of.kind)
    }

    pub(super) fn is_external(&self, resource: usize) -> bool {
        self.list.get(resource).is_some_and(|one| one.of.external)
    }

    pub(super) fn use_buffer(&mut self, resource: usize, usage: wgpu::BufferUsages) {
        if let Some(one) = self.list.get_mut(resource) {
            one.buffer |= usage;
        }
    }

    /// The number of a view.
    pub(super) fn view(
        &mut self,
        view: View,
        dimension: wgpu::TextureViewDimension,
        usage: wgpu::TextureUsages,
    ) -> usize {
        if let Some(one) = self.list.get_mut(view.resource) {
            one.texture |= usage;
        }
        let same = |known: &Bound| known.view == view && known.dimension == dimension;
        self.views.iter().position(same).unwrap_or_else(|| {
            self.views.push(Bound { view, dimension, made: None });
            self.views.len() - 1
        })
    }

    /// What is larger than a device allows, the host's own as well.
    pub(super) fn too_large(&self, device: &wgpu::Device) -> Vec<Fault> {
        let limits = device.limits();
        let fault = |one: &Resource| {
            let limit = one.exceeded(&limits)?;
            Some(Fault::Limit { name: one.of.name.clone(), kind: described(&one.of), limit })
        };
        self.list.iter().filter_map(fault).collect()
    }

    /// Makes what the host does not supply.
    pub(super) fn make(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Vec<Fault> {
        let mut faults = Vec::new();
        for one in self.list.iter_mut().filter(|one| !one.of.external) {
            let made = guarded(device, &one.of.name, || one.make(device));
            match made {
                Ok(object) => one.object = object,
                Err(error) => faults.push(Fault::of_device(&one.of.name, error)),
            }
            one.begin(queue);
        }
        for bound in &mut self.views {
            let object = self.list.get(bound.view.resource).and_then(|one| one.object.as_ref());
            bound.make(object);
        }
        faults
    }

    /// Takes what the host supplies of what is used.
    pub(super) fn take(
        &mut self,
        used: &BTreeSet<usize>,
        inputs: &Inputs<'_>,
        faults: &mut Vec<Fault>,
    ) {
        for (index, one) in self.list.iter_mut().enumerate() {
            if let Some(changed) = self.changed.get_mut(index) {
                *changed = false;
            }
            if !(one.of.external && used.contains(&index)) {
                continue;
            }
            let (name, kind) = (one.of.name.clone(), described(&one.of));
            let Some(given) = inputs.resources.get(one.of.name.as_str()) else {
                faults.push(Fault::ResourceLeftOut { name, kind });
                continue;
            };
            let same = match (given, &one.object) {
                (External::Texture(new), Some(Object::Texture(old))) => new == old,
                (External::View(new), Some(Object::View(old))) => new == old,
                (External::Buffer(new), Some(Object::Buffer(old))) => new == old,
                _ => false,
            };
            if same {
                continue;
            }
            if let Some(found) = one.misfit(given) {
                faults.push(Fault::Resource { name, found, kind });
                continue;
            }
            one.object = Some(match given {
                External::Texture(texture) => Object::Texture(texture.clone()),
                External::View(view) => Object::View(view.clone()),
                External::Buffer(buffer) => Object::Buffer(buffer.clone()),
            });
            if let Some(changed) = self.changed.get_mut(index) {
                *changed = true;
            }
        }
        for bound in &mut self.views {
            let resource = bound.view.resource;
            if self.changed.get(resource) == Some(&true)
                && let Some(one) = self.list.get(resource)
            {
                bound.make(one.object.as_ref());
                if bound.made.is_none() {
                    faults.push(Fault::Resource {
                        name: one.of.name.clone(),
                        found: "a view".to_owned(),
                        kind: format!("{}, whose levels are bound one by one", described(&one.of)),
                    });
                }
            }
        }
    }

    /// Whether the host has given another one than in the frame before.
    pub(super) fn has_changed(&self, resource: usize) -> bool {
        self.changed.get(resource) == Some(&true)
    }

    /// The resource of a view.
    pub(super) fn of_view(&self, view: usize) -> Option<usize> {
        self.views.get(view).map(|bound| bound.view.resource)
    }

    pub(super) fn texture_view(&self, view: usize) -> Option<&wgpu::TextureView> {
        self.views.get(view)?.made.as_ref()
    }

    pub(super) fn buffer(&self, resource: usize) -> Option<&wgpu::Buffer> {
        match self.list.get(resource)?.object.as_ref()? {
            Object::Buffer(buffer) => Some(buffer),
            _ => None,
        }
    }

    pub(super) fn texture(&self, resource: usize) -> Option<&wgpu::Texture> {
        match self.list.get(resource)?.object.as_ref()? {
            Object::Texture(texture) => Some(texture),
            Object::View(view) => Some(view.texture()),
            _ => None,
        }
    }

    pub(super) fn sampler(&self, resource: usize) -> Option<&wgpu::Sampler> {
        match self.list.get(resource)?.object.as_ref()? {
            Object::Sampler(sampler) => Some(sampler),
            _ => None,
        }
    }

    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.list.iter().position(|one| one.of.name == name)
    }

    /// Bytes of what is made here, by name.
    pub(super) fn bytes(&self) -> impl Iterator<Item = (&str, u64)> {
        let own = self.list.iter().filter(|one| !one.of.external);
        own.filter_map(|one| Some((one.of.name.as_str(), one.object.as_ref()?.bytes())))
    }

    /// How many frames ago each was new.
    pub(super) fn ages(&self) -> Vec<u32> {
        self.list.iter().map(|one| one.age).collect()
    }

    pub(super) fn is_new(&self, resource: usize) -> bool {
        self.list.get(resource).is_some_and(|one| one.age == 0)
    }

    /// What was used has grown older by a frame.
    pub(super) fn grow_older(&mut self, used: &BTreeSet<usize>) {
        for (_, one) in self.list.iter_mut().enumerate().filter(|one| used.contains(&one.0)) {
            one.age = one.age.saturating_add(1);
        }
    }

    /// Lets kept resources begin again.
    pub(super) fn restart(&mut self, queue: &wgpu::Queue) {
        for one in &mut self.list {
            one.age = 0;
            one.begin(queue);
        }
    }
}

impl Resource {
    fn make(&self, device: &wgpu::Device) -> Option<Object> {
        let label = Some(self.of.name.as_str());
        Some(match &self.of.kind {
            Kind::Buffer { .. } => Object::Buffer(device.create_buffer(&wgpu::BufferDescriptor {
                label,
                // A buffer of no bytes cannot be bound.
                size: self.of.bytes.max(4).next_multiple_of(4),
                usage: self.buffer | OWN_BUFFER,
                mapped_at_creation: false,
            })),
            Kind::Texture { format, size: [width, height], layers, levels } => {
                let side = |side: &u64| u32::try_from(*side).unwrap_or(u32::MAX);
                Object::Texture(device.create_texture(&wgpu::TextureDescriptor {
                    label,
                    size: wgpu::Extent3d {
                        width: side(width),
                        height: side(height),
                        depth_or_array_layers: side(layers),
                    },
                    mip_level_count: side(levels),
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: names::texture(format)?,
                    usage: self.texture | OWN_TEXTURE,
                    view_formats: &[],
                }))
            }
            Kind::Sampler { filter } => {
                let (filter, mipmap_filter) = match filter {
                    Filter::Nearest => (wgpu::FilterMode::Nearest, wgpu::MipmapFilterMode::Nearest),
                    Filter::Linear => (wgpu::FilterMode::Linear, wgpu::MipmapFilterMode::Linear),
                };
                Object::Sampler(device.create_sampler(&wgpu::SamplerDescriptor {
                    label,
                    mag_filter: filter,
                    min_filter: filter,
                    mipmap_filter,
                    ..Default::default()
                }))
            }
        })
    }

    /// The limit that it exceeds, in words.
    fn exceeded(&self, limits: &wgpu::Limits) -> Option<String> {
        match &self.of.kind {
            Kind::Buffer { .. } => {
                let most = if self.buffer.contains(wgpu::BufferUsages::STORAGE) {
                    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
                } else {
                    limits.max_buffer_size
                };
                (self.of.bytes > most).then(|| format!("buffers of at most {most} bytes"))
            }
            Kind::Texture { size, layers, .. } => {
                let side = u64::from(limits.max_texture_dimension_2d);
                let most = u64::from(limits.max_texture_array_layers);
                if size.iter().any(|one| *one > side) {
                    Some(format!("textures of at most {side} texels each way"))
                } else {
                    (*layers > most).then(|| format!("textures of at most {most} layers"))
                }
            }
            Kind::Sampler { .. } => None,
        }
    }

    /// Writes the words that it begins with.
    fn begin(&self, queue: &wgpu::Queue) {
        if let (Kind::Buffer { initial, .. }, Some(Object::Buffer(buffer))) =
            (&self.of.kind, &self.object)
            && !initial.is_empty()
        {
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(initial));
        }
    }
}

impl Object {
    /// The bytes that it has on the device.
    fn bytes(&self) -> u64 {
        let texture = match self {
            Self::Buffer(buffer) => return buffer.size(),
            Self::Texture(texture) => texture,
            Self::View(_) | Self::Sampler(_) => return 0,
        };
        let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(0));
        let texels = (0..texture.mip_level_count()).map(|level| {
            let side = |size: u32| u64::from((size >> level).max(1));
            side(texture.width()) * side(texture.height())
        });
        texels.sum::<u64>() * u64::from(texture.depth_or_array_layers()) * texel
    }
}

impl Bound {
    fn make(&mut self, object: Option<&Object>) {
        self.made = match object {
            Some(Object::Texture(texture)) => {
                let level = self.view.level.and_then(|level| u32::try_from(level).ok());
                Some(texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(self.dimension),
                    base_mip_level: level.unwrap_or(0),
                    mip_level_count: level.map(|_| 1),
                    ..Default::default()
                }))
            }
            Some(Object::View(view)) => {
                let whole = self.view.level.is_none() || view.texture().mip_level_count() == 1;
                whole.then(|| view.clone())
            }
            _ => None,
        };
    }
}

fn described(resource: &frame::Resource) -> String {
    match &resource.kind {
        Kind::Buffer { .. } => format!("a buffer of {} bytes", resource.bytes),
        Kind::Texture { format, size: [width, height], .. } => {
            let other = resource.other_formats.iter().map(|other| format!("; {other}"));
            format!("a texture of {width} x {height} texels, {format}{}", other.collect::<String>())
        }
        Kind::Sampler { .. } => "a sampler".to_owned(),
    }
}

impl Resource {
    /// What was given, if it does not fit.
    fn misfit(&self, given: &External) -> Option<String> {
        match (&self.of.kind, given) {
            (Kind::Buffer { .. }, External::Buffer(buffer)) => {
                let (bytes, lacks) = (buffer.size(), self.buffer - buffer.usage());
                if bytes < self.of.bytes {
                    Some(format!("a buffer of {bytes} bytes"))
                } else {
                    (!lacks.is_empty()).then(|| format!("a buffer without usage {lacks:?}"))
                }
            }
            (Kind::Texture { format, size, .. }, External::Texture(given)) => {
                self.misfit_texture(given, format, size)
            }
            (Kind::Texture { format, size, .. }, External::View(given)) => {
                self.misfit_texture(given.texture(), format, size)
            }
            (_, External::Buffer(_)) => Some("a buffer".to_owned()),
            (_, External::Texture(_) | External::View(_)) => Some("a texture".to_owned()),
        }
    }

    /// What is sampled may be of another format, for shaders read floats of any; what is written is of the one.
    fn misfit_texture(
        &self,
        texture: &wgpu::Texture,
        format: &str,
        size: &[u64; 2],
    ) -> Option<String> {
        const WRITTEN: wgpu::TextureUsages =
            wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::RENDER_ATTACHMENT);
        if self.texture.intersects(WRITTEN) && names::texture(format) != Some(texture.format()) {
            return Some(format!("a texture of format {:?}", texture.format()));
        }
        let found = [texture.width(), texture.height()];
        let fits = found.iter().zip(size).all(|(found, wanted)| u64::from(*found) == *wanted);
        let lacks = self.texture - texture.usage();
        if !fits {
            Some(format!("a texture of {} x {} texels", found[0], found[1]))
        } else {
            (!lacks.is_empty()).then(|| format!("a texture without usage {lacks:?}"))
        }
    }
}
