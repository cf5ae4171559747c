//! Buffers, textures and samplers of a frame, with the views that steps bind.

use std::collections::BTreeSet;

use sglow_graph::description::Filter;
use sglow_graph::frame::{self, Kind, View};

use super::error::Fault;
use super::input::{Inputs, Object};
use crate::names;
use crate::pipeline::checked;

/// What is made here can be filled, read back and bound by the host, too.
const OWN_BUFFER: wgpu::BufferUsages =
    wgpu::BufferUsages::COPY_SRC.union(wgpu::BufferUsages::COPY_DST);
const OWN_TEXTURE: wgpu::TextureUsages = wgpu::TextureUsages::COPY_SRC
    .union(wgpu::TextureUsages::COPY_DST)
    .union(wgpu::TextureUsages::TEXTURE_BINDING);

/// What a group binds: a uniform's slot, a buffer or a sampler, or a view of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    Uniform(usize),
    Resource(usize),
    View(usize),
}

#[derive(Debug)]
struct Resource {
    of: frame::Resource,
    /// How steps use it.
    buffer: wgpu::BufferUsages,
    texture: wgpu::TextureUsages,
    object: Option<Object>,
    /// Whether the host has given another one than in the frame before.
    changed: bool,
    /// Frames since it was new.
    age: u32,
}

/// A view that a step binds.
#[derive(Debug)]
struct Bind {
    view: View,
    dimension: wgpu::TextureViewDimension,
    made: Option<wgpu::TextureView>,
}

/// All resources of a frame.
#[derive(Debug)]
pub(super) struct Resources {
    list: Vec<Resource>,
    views: Vec<Bind>,
}

impl Resources {
    pub(super) fn new(frame: &frame::Frame) -> Self {
        let one = |of: &frame::Resource| Resource {
            of: of.clone(),
            buffer: wgpu::BufferUsages::empty(),
            texture: wgpu::TextureUsages::empty(),
            object: None,
            changed: false,
            age: 0,
        };
        Self { list: frame.resources.iter().map(one).collect(), views: Vec::new() }
    }

    pub(super) fn kind(&self, resource: usize) -> Option<&Kind> {
        self.list.get(resource).map(|one| &one.of.kind)
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
        let same = |known: &Bind| known.view == view && known.dimension == dimension;
        self.views.iter().position(same).unwrap_or_else(|| {
            self.views.push(Bind { view, dimension, made: None });
            self.views.len() - 1
        })
    }

    /// Makes what the host does not supply.
    pub(super) fn make(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        faults: &mut Vec<Fault>,
    ) {
        for one in self.list.iter_mut().filter(|one| !one.of.external) {
            match checked(device, || one.make(device)) {
                Ok(object) => one.object = object,
                Err(message) => faults.push(one.refused(message)),
            }
            one.begin(queue);
            one.changed = true;
        }
        let limit = device.limits().max_storage_buffer_binding_size;
        let over = |r: &&Resource| r.of.external && !r.buffer.is_empty() && r.of.bytes > limit;
        let found = self.list.iter().filter(over);
        faults.extend(found.map(|one| one.refused(format!("it binds up to {limit} bytes"))));
        self.make_views();
    }

    /// Makes the views of what has changed.
    fn make_views(&mut self) {
        for bind in &mut self.views {
            if let Some(one) = self.list.get(bind.view.resource).filter(|one| one.changed) {
                bind.made = one.view(bind.view.level, bind.dimension);
            }
        }
    }

    /// Takes what the host supplies of what is used; whether any of it is another one than in the frame before.
    pub(super) fn take(
        &mut self,
        used: &BTreeSet<usize>,
        inputs: &Inputs<'_>,
        faults: &mut Vec<Fault>,
    ) -> bool {
        for (index, one) in self.list.iter_mut().enumerate() {
            one.changed = false;
            let given = inputs.resources.get(one.of.name.as_str());
            let known = given.is_some() && given == one.object.as_ref();
            if !(one.of.external && used.contains(&index)) || known {
                continue;
            }
            match given.map_or(Some("left out".to_owned()), |given| one.misfit(given)) {
                Some(found) => faults.push(one.fault(found)),
                None => {
                    one.object = given.cloned();
                    one.changed = true;
                }
            }
        }
        self.make_views();
        self.list.iter().any(|one| one.changed)
    }

    /// Whether the host has given another one than in the frame before.
    pub(super) fn has_changed(&self, bound: Bound) -> bool {
        self.of(bound).and_then(|resource| self.list.get(resource)).is_some_and(|one| one.changed)
    }

    /// Says what a binding does not take, and forgets it if it is the host's.
    pub(super) fn refuse(&mut self, bound: Bound, message: String) -> Option<Fault> {
        let of = self.of(bound)?;
        let one = self.list.get_mut(of)?;
        if one.of.external {
            (one.object, one.changed) = (None, true);
        }
        let fault = one.refused(message);
        self.make_views();
        Some(fault)
    }

    /// The resource that is bound.
    pub(super) fn of(&self, bound: Bound) -> Option<usize> {
        match bound {
            Bound::Uniform(_) => None,
            Bound::Resource(resource) => Some(resource),
            Bound::View(view) => self.views.get(view).map(|bind| bind.view.resource),
        }
    }

    /// What a binding takes of a buffer or a sampler.
    pub(super) fn binding(&self, resource: usize) -> Option<wgpu::BindingResource<'_>> {
        match self.list.get(resource)?.object.as_ref()? {
            Object::Buffer(buffer) => Some(buffer.as_entire_binding()),
            Object::Sampler(sampler) => Some(wgpu::BindingResource::Sampler(sampler)),
            Object::Texture(_) | Object::View(_) => None,
        }
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

    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.list.iter().position(|one| one.of.name == name)
    }

    /// The names of what is made here.
    pub(super) fn own(&self) -> impl Iterator<Item = &str> {
        self.list.iter().filter(|one| !one.of.external).map(|one| one.of.name.as_str())
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
                Object::Texture(device.create_texture(&wgpu::TextureDescriptor {
                    label,
                    size: wgpu::Extent3d {
                        width: narrow(*width),
                        height: narrow(*height),
                        depth_or_array_layers: narrow(*layers),
                    },
                    mip_level_count: narrow(*levels),
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: names::texture(format).ok()?,
                    usage: self.texture | OWN_TEXTURE,
                    view_formats: &[],
                }))
            }
            Kind::Sampler(filter) => {
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

    /// A view of one level or of all.
    fn view(
        &self,
        level: Option<u64>,
        dimension: wgpu::TextureViewDimension,
    ) -> Option<wgpu::TextureView> {
        const D2: wgpu::TextureViewDimension = wgpu::TextureViewDimension::D2;
        match (self.object.as_ref()?, &self.of.kind) {
            (Object::View(view), _) => Some(view.clone()),
            (Object::Texture(texture), Kind::Texture { layers, levels, .. }) => {
                Some(texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(dimension),
                    base_mip_level: level.map_or(0, narrow),
                    mip_level_count: Some(level.map_or(narrow(*levels), |_| 1)),
                    array_layer_count: (dimension != D2).then_some(narrow(*layers)),
                    ..Default::default()
                }))
            }
            _ => None,
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

    fn fault(&self, found: String) -> Fault {
        let (name, expected) = (format!("resource `{}`", self.of.name), described(&self.of));
        Fault::Supplied { name, found, expected }
    }

    /// What the device says against it.
    fn refused(&self, message: String) -> Fault {
        if self.of.external {
            return self.fault(format!("refused by the device: {message}"));
        }
        let what = format!("resource `{}`, {},", self.of.name, described(&self.of));
        Fault::Device { what, message }
    }

    /// What was given, if it does not fit. What a view shows of its texture, the device compares with the bindings.
    fn misfit(&self, given: &Object) -> Option<String> {
        match (&self.of.kind, given) {
            (Kind::Buffer { .. }, Object::Buffer(buffer)) => {
                let (bytes, lacks) = (buffer.size(), self.buffer - buffer.usage());
                if bytes < self.of.bytes {
                    Some(format!("a buffer of {bytes} bytes"))
                } else {
                    (!lacks.is_empty()).then(|| format!("a buffer without usage {lacks:?}"))
                }
            }
            (Kind::Texture { .. }, Object::Texture(texture)) => self.misfit_texture(texture),
            (Kind::Texture { layers, levels, .. }, Object::View(view)) => {
                let target = self.texture.contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
                if target || layers * levels > 1 {
                    Some("a view".to_owned())
                } else {
                    self.misfit_texture(view.texture())
                }
            }
            (_, Object::Buffer(_)) => Some("a buffer".to_owned()),
            (_, Object::Texture(_) | Object::View(_)) => Some("a texture".to_owned()),
            (_, Object::Sampler(_)) => Some("a sampler".to_owned()),
        }
    }

    /// What is sampled may be of another format of the same kind, for shaders read floats of any; what is written is of the one.
    fn misfit_texture(&self, given: &wgpu::Texture) -> Option<String> {
        const WRITTEN: wgpu::TextureUsages =
            wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::RENDER_ATTACHMENT);
        let Kind::Texture { format, size, layers, levels } = &self.of.kind else { return None };
        let (own, found) = (names::texture(format).ok()?, given.format());
        let kind = |format: wgpu::TextureFormat| {
            format.sample_type(None, None).as_ref().map(std::mem::discriminant)
        };
        let written = self.texture.intersects(WRITTEN);
        let [width, height] = [given.width(), given.height()];
        let lacks = self.texture - given.usage();
        let all = [
            (given.dimension() != wgpu::TextureDimension::D2)
                .then(|| format!("of dimension {:?}", given.dimension())),
            (*size != [width, height].map(u64::from))
                .then(|| format!("of {width} x {height} texels")),
            (u64::from(given.depth_or_array_layers()) < *layers)
                .then(|| format!("of {} layers", given.depth_or_array_layers())),
            (u64::from(given.mip_level_count()) < *levels)
                .then(|| format!("of {} levels", given.mip_level_count())),
            (given.sample_count() > 1).then(|| format!("of {} samples", given.sample_count())),
            (kind(found) != kind(own) || written && found != own)
                .then(|| format!("of format {found:?}")),
            (!lacks.is_empty()).then(|| format!("without usage {lacks:?}")),
        ];
        let all: Vec<_> = all.into_iter().flatten().collect();
        (!all.is_empty()).then(|| format!("a texture {}", all.join(", ")))
    }
}

/// What exceeds 32 bits exceeds every limit, too.
pub(super) fn narrow(number: u64) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

fn described(resource: &frame::Resource) -> String {
    match &resource.kind {
        Kind::Buffer { .. } => format!("a buffer of {} bytes", resource.bytes),
        Kind::Texture { format, size: [width, height], layers, levels } => {
            let several = |number: &u64, text| if *number > 1 { text } else { String::new() };
            let layers = several(layers, format!(", {layers} layers"));
            let levels = several(levels, format!(", {levels} levels"));
            let other = resource.formats.iter().filter(|case| case.value != *format);
            let other = other.filter_map(|case| Some((&case.value, case.when.as_ref()?)));
            let other: String =
                other.map(|(format, when)| format!("; {format} where {when}")).collect();
            format!("a texture of {width} x {height} texels, {format}{layers}{levels}{other}")
        }
        Kind::Sampler { .. } => "a sampler".to_owned(),
    }
}
