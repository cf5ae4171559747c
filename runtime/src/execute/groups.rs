//! Bind groups, each made once; those that touch what the host supplies again when that has changed.

use super::resources::Resources;
use super::steps::Uses;
use super::uniforms::Uniforms;

/// What an entry of a group is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    Uniform(usize),
    Buffer(usize),
    Sampler(usize),
    View(usize),
}

#[derive(Debug)]
struct Group {
    layout: wgpu::BindGroupLayout,
    entries: Vec<(u32, Bound)>,
    /// The host's resources among them.
    external: Vec<usize>,
    made: Option<wgpu::BindGroup>,
}

/// All bind groups of a frame.
#[derive(Debug, Default)]
pub(super) struct Groups {
    list: Vec<Group>,
    made: u64,
}

impl Groups {
    /// The number of a group.
    pub(super) fn group(
        &mut self,
        layout: &wgpu::BindGroupLayout,
        entries: Vec<(u32, Bound)>,
        resources: &Resources,
    ) -> usize {
        let same = |known: &Group| known.layout == *layout && known.entries == entries;
        // From the end, for what is shared was mostly used a moment ago.
        if let Some(found) = self.list.iter().rposition(same) {
            return found;
        }
        let of = |(_, bound): &(u32, Bound)| match *bound {
            Bound::Uniform(_) => None,
            Bound::Buffer(resource) | Bound::Sampler(resource) => Some(resource),
            Bound::View(view) => resources.of_view(view),
        };
        let external =
            entries.iter().filter_map(of).filter(|&resource| resources.is_external(resource));
        let external = external.collect();
        self.list.push(Group { layout: layout.clone(), entries, external, made: None });
        self.list.len() - 1
    }

    /// Makes what is not made yet or has changed, as far as everything that it binds is there.
    pub(super) fn make(
        &mut self,
        device: &wgpu::Device,
        resources: &Resources,
        uniforms: &Uniforms,
    ) {
        for group in &mut self.list {
            let stale = group.external.iter().any(|&resource| resources.has_changed(resource));
            if group.made.is_some() && !stale {
                continue;
            }
            let entry = |(binding, bound): &(u32, Bound)| {
                let resource = match *bound {
                    Bound::Uniform(slot) => uniforms.binding(slot)?,
                    Bound::Buffer(resource) => resources.buffer(resource)?.as_entire_binding(),
                    Bound::Sampler(resource) => {
                        wgpu::BindingResource::Sampler(resources.sampler(resource)?)
                    }
                    Bound::View(view) => {
                        wgpu::BindingResource::TextureView(resources.texture_view(view)?)
                    }
                };
                Some(wgpu::BindGroupEntry { binding: *binding, resource })
            };
            let entries: Option<Vec<_>> = group.entries.iter().map(entry).collect();
            let Some(entries) = entries else { continue };
            group.made = Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &group.layout,
                entries: &entries,
            }));
            self.made += 1;
        }
    }

    pub(super) fn get(&self, group: usize) -> Option<&wgpu::BindGroup> {
        self.list.get(group)?.made.as_ref()
    }

    /// Adds what a group binds.
    pub(super) fn add_uses(&self, group: usize, resources: &Resources, uses: &mut Uses) {
        for (_, bound) in self.list.get(group).into_iter().flat_map(|group| &group.entries) {
            match *bound {
                Bound::Uniform(slot) => {
                    uses.uniforms.insert(slot);
                }
                Bound::Buffer(resource) | Bound::Sampler(resource) => {
                    uses.resources.insert(resource);
                }
                Bound::View(view) => uses.resources.extend(resources.of_view(view)),
            }
        }
    }

    /// How many bind groups were made.
    pub(super) fn made(&self) -> u64 {
        self.made
    }
}
