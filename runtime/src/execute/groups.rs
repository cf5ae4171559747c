//! Bind groups, each made once; those that touch what the host supplies again when that has changed.

use super::error::Fault;
use super::resources::{Bound, Resources};
use super::uniforms::Uniforms;
use crate::pipeline::checked;

/// An entry of a layout, and what is bound to it.
pub(super) type Entry = (wgpu::BindGroupLayoutEntry, Bound);

#[derive(Debug)]
struct Group {
    layout: wgpu::BindGroupLayout,
    entries: Vec<Entry>,
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
    pub(super) fn group(&mut self, layout: &wgpu::BindGroupLayout, entries: Vec<Entry>) -> usize {
        let same = |known: &Group| known.layout == *layout && known.entries == entries;
        // From the end, for what is shared was mostly used a moment ago.
        self.list.iter().rposition(same).unwrap_or_else(|| {
            self.list.push(Group { layout: layout.clone(), entries, made: None });
            self.list.len() - 1
        })
    }

    /// Makes what is not made yet or binds what has changed, as far as everything that it binds is there. What of the host's
    /// a group does not take is a fault, and forgotten.
    pub(super) fn make(
        &mut self,
        device: &wgpu::Device,
        resources: &mut Resources,
        uniforms: &Uniforms,
        any_changed: bool,
        faults: &mut Vec<Fault>,
    ) {
        for group in &mut self.list {
            let changed = |(_, bound): &Entry| resources.has_changed(*bound);
            if group.made.is_some() && !(any_changed && group.entries.iter().any(changed)) {
                continue;
            }
            group.made = None;
            let layout = &group.layout;
            match bind_group(device, layout, &group.entries, resources, uniforms) {
                None => {}
                Some(Ok(made)) => {
                    group.made = Some(made);
                    self.made += 1;
                }
                Some(Err(message)) => {
                    let before = faults.len();
                    for entry in &group.entries {
                        let alone = alone(device, *entry, resources, uniforms);
                        faults.extend(alone.and_then(|problem| resources.refuse(entry.1, problem)));
                    }
                    if faults.len() == before {
                        faults.push(Fault::Device { what: "a bind group".to_owned(), message });
                    }
                }
            }
        }
    }

    pub(super) fn get(&self, group: usize) -> Option<&wgpu::BindGroup> {
        self.list.get(group)?.made.as_ref()
    }

    /// How many bind groups were made.
    pub(super) fn made(&self) -> u64 {
        self.made
    }
}

/// A bind group, or what the device says against it; nothing while something is not there.
fn bind_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    entries: &[Entry],
    resources: &Resources,
    uniforms: &Uniforms,
) -> Option<Result<wgpu::BindGroup, String>> {
    let entry = |(entry, bound): &Entry| {
        let resource = match *bound {
            Bound::Uniform(slot) => uniforms.binding(slot)?,
            Bound::Resource(resource) => resources.binding(resource)?,
            Bound::View(view) => wgpu::BindingResource::TextureView(resources.texture_view(view)?),
        };
        Some(wgpu::BindGroupEntry { binding: entry.binding, resource })
    };
    let entries: Vec<_> = entries.iter().map(entry).collect::<Option<_>>()?;
    let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
    Some(checked(device, || device.create_bind_group(&descriptor)))
}

/// What the device says against one entry by itself.
fn alone(
    device: &wgpu::Device,
    entry: Entry,
    resources: &Resources,
    uniforms: &Uniforms,
) -> Option<String> {
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[entry.0],
    });
    let message = bind_group(device, &layout, &[entry], resources, uniforms)?.err()?;
    // The last line is the cause of those before it.
    message.lines().map(str::trim).rfind(|line| !line.is_empty()).map(str::to_owned)
}
