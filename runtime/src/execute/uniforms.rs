//! Uniforms: all in one buffer, which is written anew in every frame.

use std::collections::BTreeSet;

use sglow_graph::description::{Number, Table};
use sglow_graph::frame::Value;

use super::error::Fault;
use super::input::{Input, Inputs};
use crate::interface::{Field, Interface, Place, Scalar};

/// Numbers that a host's input gives to a uniform.
#[derive(Debug)]
struct Copy {
    /// Index among the needed inputs.
    input: usize,
    /// Of an array, which element.
    element: Option<usize>,
    /// Where each number goes: bytes from the start of the buffer.
    to: Vec<u32>,
    scalar: Scalar,
}

/// An input that the host has to give.
#[derive(Debug)]
struct Needed {
    name: String,
    /// Of a structure, the member; else nothing.
    member: String,
    /// Its type in WGSL, as its first use has it.
    kind: String,
    /// Of an array, how many elements are used.
    elements: usize,
}

/// A uniform as one or more variants lay it out.
#[derive(Debug)]
struct Slot {
    /// Index in the frame.
    uniform: usize,
    /// Its members, and where its numbers lie.
    layout: (Vec<Field>, Vec<Place>),
    offset: u32,
    size: u32,
    copies: Vec<Copy>,
    /// Where the age of a kept resource goes.
    ages: Vec<(u32, usize)>,
}

/// All uniforms of a frame.
#[derive(Debug, Default)]
pub(super) struct Uniforms {
    slots: Vec<Slot>,
    needed: Vec<Needed>,
    image: Vec<u8>,
    buffer: Option<wgpu::Buffer>,
}

impl Uniforms {
    /// The slot of a uniform in the layout that a variant has for it; or the members that are at fault.
    pub(super) fn slot(
        &mut self,
        device: &wgpu::Device,
        uniform: usize,
        members: &Table<Value>,
        interface: &Interface,
        of: &str,
    ) -> Result<usize, Vec<String>> {
        let (Some(known), Some((places, size))) =
            (interface.find_struct(of), interface.places(of, 0))
        else {
            return Err(vec![format!("{of} is no structure of numbers of 32 bits")]);
        };
        let layout = (known.fields.clone(), places);
        let same = |slot: &Slot| slot.uniform == uniform && slot.layout == layout;
        if let Some(found) = self.slots.iter().position(same) {
            return Ok(found);
        }
        let align = device.limits().min_uniform_buffer_offset_alignment.max(16);
        let offset = (self.image.len() as u32).next_multiple_of(align);
        let size = size.next_multiple_of(16);
        self.image.resize((offset + size) as usize, 0);
        let (copies, ages) = (Vec::new(), Vec::new());
        let mut slot = Slot { uniform, layout, offset, size, copies, ages };
        let mut faults = Vec::new();
        for field in &known.fields {
            let filled = match members.get(&field.name) {
                None => Err("nothing is given for it".to_owned()),
                Some(value) => self.member(&mut slot, value, field, interface),
            };
            faults.extend(filled.err().map(|text| format!("member `{}`: {text}", field.name)));
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        self.slots.push(slot);
        Ok(self.slots.len() - 1)
    }

    fn member(
        &mut self,
        slot: &mut Slot,
        value: &Value,
        Field { r#type: of, offset, .. }: &Field,
        interface: &Interface,
    ) -> Result<(), String> {
        let at = slot.offset + offset;
        let places = |of: &str, at| interface.places(of, at).map_or(Vec::new(), |found| found.0);
        let Value::Input(name, element) = value else {
            return self.plain(slot, value, &places(of, at), of);
        };
        let element =
            element.map(usize::try_from).transpose().map_err(|error| error.to_string())?;
        let mut copy = |member: &str, of: &str, at| {
            let places = places(of, at);
            let scalar = places.first().map_or(Scalar::F32, |place| place.1);
            let to = places.into_iter().map(|place| place.0).collect();
            let input = self.need(name, member, of, element);
            slot.copies.push(Copy { input, element, to, scalar });
        };
        match interface.find_struct(of) {
            None => copy("", of, at),
            Some(known) => {
                for field in &known.fields {
                    copy(&field.name, &field.r#type, at + field.offset);
                }
            }
        }
        Ok(())
    }

    fn need(&mut self, name: &str, member: &str, kind: &str, element: Option<usize>) -> usize {
        let same = |needed: &Needed| needed.name == name && needed.member == member;
        let index = self.needed.iter().position(same).unwrap_or_else(|| {
            let [name, member, kind] = [name, member, kind].map(str::to_owned);
            self.needed.push(Needed { name, member, kind, elements: 0 });
            self.needed.len() - 1
        });
        let elements = &mut self.needed[index].elements;
        *elements = element.map_or(0, |element| element + 1).max(*elements);
        index
    }

    /// A value that is no input: constants, ages and lists of them.
    fn plain(
        &mut self,
        slot: &mut Slot,
        value: &Value,
        places: &[Place],
        of: &str,
    ) -> Result<(), String> {
        match (value, places) {
            (Value::Number(number), [(at, scalar)]) => {
                put(&mut self.image, *at, &constant(*number, *scalar)?);
                Ok(())
            }
            (Value::Age(resource), [(at, Scalar::U32)]) => {
                slot.ages.push((*at, *resource));
                Ok(())
            }
            (Value::List(list), _)
                if !list.is_empty() && places.len().is_multiple_of(list.len()) =>
            {
                let mut parts = list.iter().zip(places.chunks_exact(places.len() / list.len()));
                parts.try_for_each(|(value, places)| self.plain(slot, value, places, of))
            }
            _ => Err(format!("what is given for it is not of type {of}")),
        }
    }

    /// Makes the buffer.
    pub(super) fn make(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        let usage = wgpu::BufferUsages::UNIFORM;
        self.buffer =
            (!self.image.is_empty()).then(|| filled(device, queue, "uniforms", &self.image, usage));
    }

    /// The binding of a slot.
    pub(super) fn binding(&self, slot: usize) -> Option<wgpu::BindingResource<'_>> {
        let (buffer, slot) = (self.buffer.as_ref()?, self.slots.get(slot)?);
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer,
            offset: slot.offset.into(),
            size: u64::from(slot.size).try_into().ok(),
        }))
    }

    /// Takes what the host gives and the ages of resources, for the slots that are used.
    pub(super) fn take(
        &mut self,
        used: &BTreeSet<usize>,
        inputs: &Inputs<'_>,
        ages: &[u32],
        faults: &mut Vec<Fault>,
    ) {
        let needed = self.needed.iter();
        let keys = needed.map(|needed| (needed.name.as_str(), needed.member.as_str()));
        let given: Vec<_> = keys.map(|key| inputs.values.get(&key)).collect();
        for slot in used.iter().filter_map(|&slot| self.slots.get(slot)) {
            for copy in &slot.copies {
                let value = given[copy.input];
                match value.and_then(|value| copy.of(value)) {
                    Some(bytes) => {
                        for (at, bytes) in copy.to.iter().zip(bytes.chunks_exact(4)) {
                            put(&mut self.image, *at, bytes);
                        }
                    }
                    None => faults.push(self.needed[copy.input].fault(value)),
                }
            }
            for (at, resource) in &slot.ages {
                let age = ages.get(*resource).copied().unwrap_or_default();
                put(&mut self.image, *at, &age.to_le_bytes());
            }
        }
    }

    /// Encodes the copy of what was taken. It goes through the encoder, for several frames may be encoded before the first
    /// of them runs.
    pub(super) fn encode(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        if let Some(buffer) = &self.buffer {
            let usage = wgpu::BufferUsages::COPY_SRC;
            let from = filled(device, queue, "uniforms of a frame", &self.image, usage);
            encoder.copy_buffer_to_buffer(&from, 0, buffer, 0, buffer.size());
        }
    }
}

impl Needed {
    fn fault(&self, value: Option<&Input>) -> Fault {
        let Self { name, member, kind, elements } = self;
        let dot = if member.is_empty() { "" } else { "." };
        Fault::Supplied {
            name: format!("input `{name}{dot}{member}`"),
            found: value.map_or("left out".to_owned(), Input::kind),
            expected: match elements {
                0 => format!("of type {kind}"),
                _ => format!("of type array<{kind}>, at least {elements}"),
            },
        }
    }
}

impl Copy {
    /// The bytes that it takes of an input; nothing if that is something else.
    fn of<'a>(&self, value: &'a Input) -> Option<&'a [u8]> {
        let (bytes, own) = (value.bytes(self.scalar)?, 4 * self.to.len());
        match self.element {
            None => (bytes.len() == own).then_some(bytes),
            Some(element) if bytes.len().is_multiple_of(own) => {
                bytes.get(element * own..(element + 1) * own)
            }
            Some(_) => None,
        }
    }
}

/// A number in the type of its place, if that holds it.
fn constant(number: Number, scalar: Scalar) -> Result<[u8; 4], String> {
    let real = number.real();
    let within =
        |minimum: f64, maximum: f64| real.fract() == 0.0 && (minimum..=maximum).contains(&real);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is in range")]
    match scalar {
        Scalar::F32 => Ok((real as f32).to_le_bytes()),
        Scalar::U32 if within(0.0, u32::MAX.into()) => Ok((real as u32).to_le_bytes()),
        Scalar::I32 if within(i32::MIN.into(), i32::MAX.into()) => Ok((real as i32).to_le_bytes()),
        Scalar::U32 | Scalar::I32 => Err(format!("{number} is no whole number of 32 bits")),
    }
}

/// A buffer of bytes. The queue fills it: what is mapped by creation cannot be on a device that is lost.
fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}

fn put(image: &mut [u8], at: u32, bytes: &[u8]) {
    let at = at as usize;
    if let Some(to) = image.get_mut(at..at + bytes.len()) {
        to.copy_from_slice(bytes);
    }
}
