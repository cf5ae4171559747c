//! What a host gives for a frame: numbers, resources, draws.

use std::collections::BTreeMap;

use crate::interface::Scalar;

/// Numbers of one input, one after the other: a number alone, a vector, the columns of a matrix, elements of an array.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "said above")]
pub enum Input {
    F32(Vec<f32>),
    U32(Vec<u32>),
    I32(Vec<i32>),
}

impl Input {
    /// The bytes of its numbers, if these are of a type.
    pub(super) fn bytes(&self, scalar: Scalar) -> Option<&[u8]> {
        match (self, scalar) {
            (Self::F32(numbers), Scalar::F32) => Some(bytemuck::cast_slice(numbers)),
            (Self::U32(numbers), Scalar::U32) => Some(bytemuck::cast_slice(numbers)),
            (Self::I32(numbers), Scalar::I32) => Some(bytemuck::cast_slice(numbers)),
            _ => None,
        }
    }

    /// What it is, in words.
    pub(super) fn kind(&self) -> String {
        let (count, of) = match self {
            Self::F32(numbers) => (numbers.len(), "f32"),
            Self::U32(numbers) => (numbers.len(), "u32"),
            Self::I32(numbers) => (numbers.len(), "i32"),
        };
        format!("{count} numbers of type {of}")
    }
}

impl From<f32> for Input {
    fn from(number: f32) -> Self {
        Self::F32(vec![number])
    }
}

impl From<u32> for Input {
    fn from(number: u32) -> Self {
        Self::U32(vec![number])
    }
}

impl<const N: usize> From<[f32; N]> for Input {
    fn from(vector: [f32; N]) -> Self {
        Self::F32(vector.into())
    }
}

/// Columns of a matrix.
impl<const N: usize, const M: usize> From<[[f32; N]; M]> for Input {
    fn from(columns: [[f32; N]; M]) -> Self {
        Self::F32(columns.concat())
    }
}

/// What a resource is on the device.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Object {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

/// Draws of the host's own.
pub trait DrawList {
    /// What it draws, each kind with pipelines of its own. It is called once, when pipelines are made.
    fn kinds(&self) -> Vec<DrawKind>;

    /// Binds what the frame does not and issues the draws, each with the pipeline of its kind. Viewport and the frame's own
    /// groups are set.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &[wgpu::RenderPipeline]);
}

/// The host's lists of draws by name.
pub type Lists<'a> = BTreeMap<&'a str, &'a dyn DrawList>;

/// What draws of one kind have in common.
#[derive(Clone, Debug, Default)]
pub struct DrawKind {
    /// The values by which their variants are chosen: those of the configuration's draws.
    pub axes: BTreeMap<String, String>,
    /// How their triangles are put together, and which of them are culled.
    pub primitive: wgpu::PrimitiveState,
    /// The groups that the host binds, with their layouts.
    pub groups: Vec<(u32, wgpu::BindGroupLayout)>,
}

/// What a host gives for one frame.
#[derive(Clone, Default)]
pub struct Inputs<'a> {
    /// By their names; members of structures by theirs as well.
    pub(super) values: BTreeMap<(&'a str, &'a str), Input>,
    pub(super) resources: BTreeMap<&'a str, Object>,
    pub(super) lists: Lists<'a>,
}

impl<'a> Inputs<'a> {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives an input.
    pub fn set(&mut self, name: &'a str, value: impl Into<Input>) -> &mut Self {
        self.member(name, "", value)
    }

    /// Gives a member of an input that is a structure.
    pub fn member(&mut self, name: &'a str, member: &'a str, value: impl Into<Input>) -> &mut Self {
        self.values.insert((name, member), value.into());
        self
    }

    /// Gives a texture, whose layers and levels are bound as the frame has them.
    pub fn texture(&mut self, name: &'a str, texture: &wgpu::Texture) -> &mut Self {
        self.resources.insert(name, Object::Texture(texture.clone()));
        self
    }

    /// Gives a view that is bound as it is, of a texture of the resource's size. What is drawn to, and what has several layers
    /// or levels, is given as a texture: how many of these a view shows is not known.
    pub fn view(&mut self, name: &'a str, view: &wgpu::TextureView) -> &mut Self {
        self.resources.insert(name, Object::View(view.clone()));
        self
    }

    /// Gives a buffer.
    pub fn buffer(&mut self, name: &'a str, buffer: &wgpu::Buffer) -> &mut Self {
        self.resources.insert(name, Object::Buffer(buffer.clone()));
        self
    }

    /// Gives draws.
    pub fn draws(&mut self, name: &'a str, list: &'a dyn DrawList) -> &mut Self {
        self.lists.insert(name, list);
        self
    }
}
