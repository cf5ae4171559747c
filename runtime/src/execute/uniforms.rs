//! Uniforms: all in one buffer, whose first part is written anew in every frame.

use std::collections::{BTreeMap, BTreeSet};

use sglow_graph::description::{Number, Table};
use sglow_graph::frame::Value;

use super::error::Fault;
use super::input::{Input, Inputs};
use crate::interface::{Interface, Place, Scalar, Struct};

/// Numbers that a host's input gives to a uniform.
#[derive(Clone, Debug)]
struct Copy {
    /// Index among the needed inputs.
    input: usize,
    /// Of a structure, the member.
    member: Option<String>,
    /// Of an array, which element.
    element: Option<usize>,
    /// Where each number goes: bytes from the start of the uniform, later of the buffer.
    to: Vec<u32>,
    scalar: Scalar,
}

/// An input that the host has to give.
#[derive(Debug)]
struct Needed {
    name: String,
    /// Its type in WGSL, as its first use has it.
    kind: String,
}

/// A uniform as one or more variants lay it out.
#[derive(Debug, Default)]
struct Slot {
    /// Index in the frame, and its layout.
    uniform: usize,
    layout: (Vec<Place>, Vec<String>),
    size: u32,
    constants: Vec<(u32, [u8; 4])>,
    copies: Vec<Copy>,
    /// Where the age of a kept resource goes.
    ages: Vec<(u32, usize)>,
    offset: u64,
}

impl Slot {
    fn is_dynamic(&self) -> bool {
        !(self.copies.is_empty() && self.ages.is_empty())
    }
}

/// All uniforms of a frame.
#[derive(Debug, Default)]
pub(super) struct Uniforms {
    slots: Vec<Slot>,
    needed: Vec<Needed>,
    image: Vec<u8>,
    /// How many of the bytes may change.
    dynamic: usize,
    buffer: Option<wgpu::Buffer>,
}

/// What is wrong with a member: its name, and what.
pub(super) type MemberFault = (String, String);

impl Uniforms {
    /// The slot of a uniform in the layout that a variant has for it.
    pub(super) fn slot(
        &mut self,
        uniform: usize,
        members: &Table<Value>,
        interface: &Interface,
        of: &str,
    ) -> Result<usize, Vec<MemberFault>> {
        let whole = |problem: String| vec![(of.to_owned(), problem)];
        let Some(known) = interface.find_struct(of) else {
            return Err(whole("a uniform has to be a structure".to_owned()));
        };
        let Some((places, size, _)) = interface.places(of, 0) else {
            return Err(whole("holds something else than numbers of 32 bits".to_owned()));
        };
        let names = known.fields.iter().map(|field| field.name.clone()).collect();
        let layout = (places, names);
        let same = |slot: &Slot| slot.uniform == uniform && slot.layout == layout;
        if let Some(found) = self.slots.iter().position(same) {
            return Ok(found);
        }
        let mut slot = Slot { uniform, layout, size, ..Slot::default() };
        let faults = self.fill(&mut slot, known, members, interface);
        if !faults.is_empty() {
            return Err(faults);
        }
        self.slots.push(slot);
        Ok(self.slots.len() - 1)
    }

    fn fill(
        &mut self,
        slot: &mut Slot,
        known: &Struct,
        members: &Table<Value>,
        interface: &Interface,
    ) -> Vec<MemberFault> {
        let mut faults = Vec::new();
        for field in &known.fields {
            let filled = match members.get(&field.name) {
                None => Err("nothing is given for it".to_owned()),
                Some(value) => self.member(slot, value, &field.r#type, field.offset, interface),
            };
            faults.extend(filled.err().map(|problem| (field.name.clone(), problem)));
        }
        faults
    }

    fn member(
        &mut self,
        slot: &mut Slot,
        value: &Value,
        of: &str,
        offset: u32,
        interface: &Interface,
    ) -> Result<(), String> {
        let Some((places, ..)) = interface.places(of, offset) else {
            return Err(format!("no value is known for type {of}"));
        };
        let Value::Input(name, element) = value else {
            return plain(slot, value, &places, of);
        };
        let input = self.need(name, of);
        let element =
            element.map(usize::try_from).transpose().map_err(|error| error.to_string())?;
        let mut copy = |places: Vec<Place>, member: Option<String>| {
            let scalar = places.first().map_or(Scalar::F32, |place| place.1);
            let to = places.into_iter().map(|place| place.0).collect();
            slot.copies.push(Copy { input, member, element, to, scalar });
        };
        match interface.find_struct(of) {
            None => copy(places, None),
            Some(known) => {
                for field in &known.fields {
                    let places = interface.places(&field.r#type, offset + field.offset);
                    copy(places.map(|found| found.0).unwrap_or_default(), Some(field.name.clone()));
                }
            }
        }
        Ok(())
    }

    fn need(&mut self, name: &str, of: &str) -> usize {
        let found = self.needed.iter().position(|needed| needed.name == name);
        found.unwrap_or_else(|| {
            self.needed.push(Needed { name: name.to_owned(), kind: of.to_owned() });
            self.needed.len() - 1
        })
    }

    /// Lays the slots out in one buffer, those that may change first, and writes what never changes.
    pub(super) fn make(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        let align = u64::from(device.limits().min_uniform_buffer_offset_alignment).max(16);
        let mut order: Vec<_> = (0..self.slots.len()).collect();
        order.sort_by_key(|&index| !self.slots[index].is_dynamic());
        let mut end = 0;
        for index in order {
            let slot = &mut self.slots[index];
            slot.offset = end;
            end += u64::from(slot.size).next_multiple_of(align);
            if slot.is_dynamic() {
                self.dynamic = end as usize;
            }
        }
        self.image = vec![0; end as usize];
        for slot in &mut self.slots {
            let moved = |at: &mut u32| *at += slot.offset as u32;
            slot.copies.iter_mut().flat_map(|copy| &mut copy.to).for_each(moved);
            slot.ages.iter_mut().map(|age| &mut age.0).for_each(moved);
            for (at, bytes) in &slot.constants {
                put(&mut self.image, slot.offset as u32 + at, bytes);
            }
        }
        self.buffer = (end > 0)
            .then(|| filled(device, queue, "uniforms", &self.image, wgpu::BufferUsages::UNIFORM));
    }

    /// The binding of a slot.
    pub(super) fn binding(&self, slot: usize) -> Option<wgpu::BindingResource<'_>> {
        let (buffer, slot) = (self.buffer.as_ref()?, self.slots.get(slot)?);
        let size = std::num::NonZeroU64::new(u64::from(slot.size).next_multiple_of(16));
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer,
            offset: slot.offset,
            size,
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
        let slots = || used.iter().filter_map(|&slot| self.slots.get(slot));
        let wanted: BTreeSet<_> =
            slots().flat_map(|slot| &slot.copies).map(|of| of.input).collect();
        let given: Vec<_> =
            self.needed.iter().map(|needed| inputs.values.get(needed.name.as_str())).collect();
        let mut wrong: BTreeMap<usize, Fault> = BTreeMap::new();
        let missing = |one: &(usize, _)| wanted.contains(&one.0) && given[one.0].is_none();
        for (index, needed) in self.needed.iter().enumerate().filter(missing) {
            let (name, kind) = (needed.name.clone(), needed.kind.clone());
            wrong.insert(index, Fault::InputLeftOut { name, kind });
        }
        for slot in slots() {
            for copy in &slot.copies {
                let Some(value) = given[copy.input] else { continue };
                if let Some(bytes) = copy.of(value) {
                    for (at, bytes) in copy.to.iter().zip(bytes.chunks_exact(4)) {
                        put(&mut self.image, *at, bytes);
                    }
                    continue;
                }
                let Needed { name, kind } = &self.needed[copy.input];
                let kind = match (&copy.member, copy.element) {
                    (None, None) => kind.clone(),
                    (None, Some(element)) => format!("array<{kind}>, at least {}", element + 1),
                    (Some(member), _) => format!("{kind} with member {member}"),
                };
                let fault = Fault::Input { name: name.clone(), found: value.kind(), kind };
                wrong.entry(copy.input).or_insert(fault);
            }
            for (at, resource) in &slot.ages {
                let age = ages.get(*resource).copied().unwrap_or_default();
                put(&mut self.image, *at, &age.to_le_bytes());
            }
        }
        faults.extend(wrong.into_values());
    }

    /// Encodes the copy of what was taken. It goes through the encoder, for several frames may be encoded before the first
    /// of them runs.
    pub(super) fn encode(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let (Some(buffer), Some(bytes)) = (&self.buffer, self.image.get(..self.dynamic)) else {
            return;
        };
        if bytes.is_empty() {
            return;
        }
        let usage = wgpu::BufferUsages::COPY_SRC;
        let from = filled(device, queue, "uniforms of a frame", bytes, usage);
        encoder.copy_buffer_to_buffer(&from, 0, buffer, 0, bytes.len() as u64);
    }
}

impl Copy {
    /// The bytes that it takes of an input; nothing if that is something else.
    fn of<'a>(&self, value: &'a Input) -> Option<&'a [u8]> {
        let value = match (&self.member, value) {
            (None, value) => value,
            (Some(member), Input::Members(members)) => members.get(member)?,
            (Some(_), _) => return None,
        };
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

/// A value that is no input: constants, ages and lists of them.
fn plain(slot: &mut Slot, value: &Value, places: &[Place], of: &str) -> Result<(), String> {
    let single = match places {
        [single] => Some(*single),
        _ => None,
    };
    match (value, single) {
        (Value::Number(number), Some((at, scalar))) => {
            slot.constants.push((at, constant(*number, scalar)?));
            Ok(())
        }
        (Value::Age(resource), Some((at, Scalar::U32))) => {
            slot.ages.push((at, *resource));
            Ok(())
        }
        (Value::List(list), _) if !list.is_empty() && places.len().is_multiple_of(list.len()) => {
            let each = places.len() / list.len();
            let mut parts = list.iter().zip(places.chunks_exact(each));
            parts.try_for_each(|(value, places)| plain(slot, value, places, of))
        }
        _ => Err(format!("what is given for it is not of type {of}")),
    }
}

fn constant(number: Number, scalar: Scalar) -> Result<[u8; 4], String> {
    match (number, scalar) {
        #[expect(clippy::cast_possible_truncation, reason = "the shader's precision")]
        (number, Scalar::F32) => Ok((number.real() as f32).to_le_bytes()),
        (Number::Whole(number), Scalar::U32) => u32::try_from(number)
            .map(u32::to_le_bytes)
            .map_err(|_| format!("{number} exceeds 32 bits")),
        (Number::Whole(number), Scalar::I32) => i32::try_from(number)
            .map(i32::to_le_bytes)
            .map_err(|_| format!("{number} exceeds 31 bits")),
        (Number::Real(number), _) if number.fract() == 0.0 && (0.0..4e9).contains(&number) =>
        {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it is whole"
            )]
            constant(Number::Whole(number as u64), scalar)
        }
        (Number::Real(number), _) => Err(format!("{number} is not whole")),
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
