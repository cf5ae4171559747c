//! What a host has to know of a module: entry points, bindings, the layout of its structs, limits.
//!
//! All of it comes from naga's reading of the final text; descriptions are the text's own doc comments.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use naga::common::wgsl::ToWgsl;
use naga::proc::{IndexableLength, Layouter};
use naga::valid::{GlobalUse, ModuleInfo};
use naga::{
    AddressSpace, ArraySize, Handle, ImageClass, ImageDimension, Scalar, ScalarKind, ShaderStage,
    StorageAccess, Type, TypeInner,
};

use super::comments::Comments;
use super::{
    Access, Binding, Cost, Dimension, EntryPoint, FieldType, Layout, LayoutField, Resource,
    SampleType, SamplerType, Stage,
};

/// Why a module cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A resource of a kind that the manifest cannot describe.
    #[error(
        "`{name}` is {what}; what a package may bind is: uniform and storage buffers, sampled, depth and storage textures, samplers"
    )]
    Resource {
        /// The variable.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// A type in a buffer that has no layout.
    #[error("`{name}` lies in a buffer but has no layout there")]
    Layout {
        /// The variable or field.
        name: String,
    },
    /// naga cannot lay the types out.
    #[error("naga cannot lay out the types: {0}")]
    Layouter(#[from] naga::proc::LayoutError),
}

/// What a host has to know of a module.
#[derive(Clone, Debug)]
pub struct Reflection {
    /// In the order of the text.
    pub entry_points: Vec<EntryPoint>,
    /// The static operations that each of them reaches, by its name.
    pub cost: BTreeMap<String, Cost>,
    /// By group and number.
    pub bindings: Vec<Binding>,
    /// The structs in buffers, each after those within it.
    pub layouts: Vec<Arc<Layout>>,
    /// WebGPU limits and what the module needs of each.
    pub limits: BTreeMap<String, u64>,
    /// WebGPU features that the module itself uses.
    pub features: BTreeSet<String>,
}

/// Describes a module for its host.
///
/// # Errors
///
/// When it binds something that is no buffer, texture or sampler.
pub fn reflect(text: &str, module: &naga::Module, info: &ModuleInfo) -> Result<Reflection, Error> {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx())?;
    let reflector = Reflector { module, info, layouter, comments: Comments::of(text) };
    let mut layouts = Vec::new();
    let bindings = reflector.bindings(&mut layouts)?;
    Ok(Reflection {
        entry_points: reflector.entry_points(),
        cost: reflector.cost(),
        limits: reflector.limits(&bindings),
        features: reflector.features(),
        bindings,
        layouts,
    })
}

struct Reflector<'a> {
    module: &'a naga::Module,
    info: &'a ModuleInfo,
    layouter: Layouter,
    comments: Comments,
}

impl Reflector<'_> {
    fn entry_points(&self) -> Vec<EntryPoint> {
        let entry_points = self.module.entry_points.iter();
        entry_points
            .map(|entry_point| EntryPoint {
                name: entry_point.name.clone(),
                stage: Stage::of(entry_point.stage),
                workgroup_size: (entry_point.stage == ShaderStage::Compute)
                    .then_some(entry_point.workgroup_size),
            })
            .collect()
    }

    fn cost(&self) -> BTreeMap<String, Cost> {
        let entry_points = self.module.entry_points.iter().enumerate();
        let cost = |index| super::cost::of(self.module, self.info, index);
        entry_points.map(|(index, of)| (of.name.clone(), cost(index))).collect()
    }

    fn bindings(&self, layouts: &mut Vec<Arc<Layout>>) -> Result<Vec<Binding>, Error> {
        let mut bindings = Vec::new();
        for (handle, variable) in self.module.global_variables.iter() {
            let Some(at) = &variable.binding else {
                continue;
            };
            let name = variable.name.clone().unwrap_or_default();
            let mut visibility: Vec<Stage> = self
                .users(handle)
                .map(|index| Stage::of(self.module.entry_points[index].stage))
                .collect();
            visibility.sort();
            visibility.dedup();
            bindings.push(Binding {
                group: at.group,
                binding: at.binding,
                description: self.comments.variables.get(&name).cloned().unwrap_or_default(),
                resource: self.resource(handle, &name, layouts)?,
                name,
                visibility,
            });
        }
        bindings.sort_by_key(|binding| (binding.group, binding.binding));
        Ok(bindings)
    }

    /// The entry points that use a variable.
    fn users(&self, variable: Handle<naga::GlobalVariable>) -> impl Iterator<Item = usize> {
        (0..self.module.entry_points.len())
            .filter(move |index| self.info.get_entry_point(*index)[variable] != GlobalUse::empty())
    }

    fn resource(
        &self,
        handle: Handle<naga::GlobalVariable>,
        name: &str,
        layouts: &mut Vec<Arc<Layout>>,
    ) -> Result<Resource, Error> {
        let variable = &self.module.global_variables[handle];
        let refuse = |what| Err(Error::Resource { name: name.to_owned(), what });
        let mut buffer = || {
            let ty = self.field_type(variable.ty, name)?;
            ty.layouts(layouts);
            let size = u64::from(self.layouter[variable.ty].size);
            Ok::<_, Error>((ty.to_string(), size, ty.stride()))
        };
        match variable.space {
            AddressSpace::Uniform => {
                let (r#type, min_size, _) = buffer()?;
                return Ok(Resource::Uniform { r#type, min_size });
            }
            AddressSpace::Storage { access } => {
                let (r#type, min_size, stride) = buffer()?;
                let access = Access::of(access);
                return Ok(Resource::Storage { access, r#type, min_size, stride });
            }
            _ => {}
        }
        match self.module.types[variable.ty].inner {
            TypeInner::Image { dim, arrayed, class } => {
                let Some(dimension) = Dimension::of(dim, arrayed) else {
                    return refuse("an array of 1D or 3D textures");
                };
                match class {
                    ImageClass::Sampled { kind, multi } => Ok(Resource::Texture {
                        dimension,
                        sample_type: match kind {
                            ScalarKind::Sint => SampleType::Sint,
                            ScalarKind::Uint => SampleType::Uint,
                            _ if self.is_sampled(handle) => SampleType::Float,
                            _ => SampleType::UnfilterableFloat,
                        },
                        multisampled: multi,
                    }),
                    ImageClass::Depth { multi } => Ok(Resource::Texture {
                        dimension,
                        sample_type: SampleType::Depth,
                        multisampled: multi,
                    }),
                    ImageClass::Storage { format, access } => Ok(Resource::StorageTexture {
                        dimension,
                        format: format.to_wgsl().to_owned(),
                        access: Access::of(access),
                    }),
                    ImageClass::External => refuse("an external texture"),
                }
            }
            TypeInner::Sampler { comparison } => Ok(Resource::Sampler {
                sampler_type: if comparison {
                    SamplerType::Comparison
                } else {
                    SamplerType::Filtering
                },
            }),
            TypeInner::BindingArray { .. } => refuse("an array of bindings"),
            TypeInner::AccelerationStructure { .. } => refuse("an acceleration structure"),
            _ => refuse("neither buffer nor texture nor sampler"),
        }
    }

    /// Whether a sampler ever reads the texture.
    fn is_sampled(&self, image: Handle<naga::GlobalVariable>) -> bool {
        (0..self.module.entry_points.len()).any(|index| {
            let set = &self.info.get_entry_point(index).sampling_set;
            set.iter().any(|pair| pair.image == image)
        })
    }

    fn field_type(&self, handle: Handle<Type>, name: &str) -> Result<FieldType, Error> {
        let no_layout = || Error::Layout { name: name.to_owned() };
        Ok(match &self.module.types[handle].inner {
            TypeInner::Scalar(scalar) => FieldType::Scalar(*scalar),
            TypeInner::Atomic(scalar) => FieldType::Atomic(*scalar),
            TypeInner::Vector { size, scalar } => FieldType::Vector(*size, *scalar),
            TypeInner::Matrix { columns, rows, scalar } => {
                FieldType::Matrix { columns: *columns, rows: *rows, scalar: *scalar }
            }
            TypeInner::Array { base, size, stride } => FieldType::Array {
                element: Box::new(self.field_type(*base, name)?),
                length: self.length(*size).ok_or_else(no_layout)?,
                stride: *stride,
            },
            TypeInner::Struct { members, span } => {
                let name = self.module.types[handle].name.clone().unwrap_or_default();
                let fields = members.iter().map(|member| {
                    let field = member.name.clone().unwrap_or_default();
                    Ok(LayoutField {
                        offset: member.offset,
                        size: self.layouter[member.ty].size,
                        r#type: self.field_type(member.ty, &format!("{name}.{field}"))?,
                        description: self.comments.field(&name, &field),
                        name: field,
                    })
                });
                FieldType::Struct(Arc::new(Layout {
                    fields: fields.collect::<Result<_, Error>>()?,
                    description: self.comments.structs.get(&name).cloned().unwrap_or_default(),
                    size: *span,
                    align: self.layouter[handle].alignment.round_up(1),
                    name,
                }))
            }
            _ => return Err(no_layout()),
        })
    }

    /// The outer option is `None` where the length is not known when the pipeline is made.
    fn length(&self, size: ArraySize) -> Option<Option<u32>> {
        match size.resolve(self.module.to_ctx()).ok()? {
            IndexableLength::Known(length) => Some(Some(length)),
            IndexableLength::Dynamic => Some(None),
        }
    }

    /// What the module needs of the WebGPU limits that count things or sizes; nothing that is zero.
    fn limits(&self, bindings: &[Binding]) -> BTreeMap<String, u64> {
        let mut limits = BTreeMap::new();
        let mut need = |name: &str, value: u64| {
            if value > 0 {
                let limit: &mut u64 = limits.entry(name.to_owned()).or_default();
                *limit = value.max(*limit);
            }
        };
        need(
            "maxBindGroups",
            bindings.iter().map(|binding| u64::from(binding.group) + 1).max().unwrap_or(0),
        );
        for (index, entry_point) in self.module.entry_points.iter().enumerate() {
            let stage = Stage::of(entry_point.stage);
            let mut counts = BTreeMap::<_, u64>::new();
            for binding in bindings.iter().filter(|binding| binding.visibility.contains(&stage)) {
                *counts.entry(binding.resource.limit()).or_default() += 1;
            }
            for (name, count) in counts {
                need(name, count);
            }
            if entry_point.stage != ShaderStage::Compute {
                continue;
            }
            let [x, y, z] = entry_point.workgroup_size.map(u64::from);
            need("maxComputeInvocationsPerWorkgroup", x * y * z);
            need("maxComputeWorkgroupSizeX", x);
            need("maxComputeWorkgroupSizeY", y);
            need("maxComputeWorkgroupSizeZ", z);
            // [WGSL, Section 13.4.2]: each variable counts with its size rounded up to 16 bytes.
            let used = self.module.global_variables.iter().filter(|(handle, variable)| {
                variable.space == AddressSpace::WorkGroup
                    && self.users(*handle).any(|user| user == index)
            });
            let bytes = used.map(|(_, variable)| u64::from(self.layouter[variable.ty].size));
            need(
                "maxComputeWorkgroupStorageSize",
                bytes.map(|size| size.next_multiple_of(16)).sum(),
            );
        }
        limits
    }

    /// Features that types and functions ask for by themselves.
    fn features(&self) -> BTreeSet<String> {
        let mut features = BTreeSet::new();
        let half = |scalar: Scalar| scalar.kind == ScalarKind::Float && scalar.width == 2;
        if self.module.types.iter().any(|(_, ty)| ty.inner.scalar().is_some_and(half)) {
            features.insert("shader-f16".to_owned());
        }
        let functions = self.module.functions.iter().map(|(_, function)| function);
        let entry_points = self.module.entry_points.iter().map(|entry_point| &entry_point.function);
        let subgroups = functions.chain(entry_points).any(|function| {
            function.expressions.iter().any(|(_, expression)| {
                matches!(
                    expression,
                    naga::Expression::SubgroupBallotResult
                        | naga::Expression::SubgroupOperationResult { .. }
                )
            })
        });
        if subgroups {
            features.insert("subgroups".to_owned());
        }
        features
    }
}

impl Stage {
    fn of(stage: ShaderStage) -> Self {
        match stage {
            ShaderStage::Vertex => Self::Vertex,
            ShaderStage::Fragment => Self::Fragment,
            ShaderStage::Compute => Self::Compute,
            _ => Self::Other,
        }
    }
}

impl Access {
    fn of(access: StorageAccess) -> Self {
        match (access.contains(StorageAccess::LOAD), access.contains(StorageAccess::STORE)) {
            (true, false) => Self::Read,
            (false, true) => Self::Write,
            _ => Self::ReadWrite,
        }
    }
}

impl Dimension {
    fn of(dimension: ImageDimension, arrayed: bool) -> Option<Self> {
        Some(match (dimension, arrayed) {
            (ImageDimension::D1, false) => Self::D1,
            (ImageDimension::D2, false) => Self::D2,
            (ImageDimension::D2, true) => Self::D2Array,
            (ImageDimension::D3, false) => Self::D3,
            (ImageDimension::Cube, false) => Self::Cube,
            (ImageDimension::Cube, true) => Self::CubeArray,
            (ImageDimension::D1 | ImageDimension::D3, true) => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    fn reflected(text: &str) -> Reflection {
        let module = naga::front::wgsl::parse_str(text).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        reflect(text, &module, &info).unwrap()
    }

    fn sample_types(reflection: &Reflection) -> BTreeMap<&str, SampleType> {
        let bindings = reflection.bindings.iter();
        bindings
            .filter_map(|binding| match binding.resource {
                Resource::Texture { sample_type, .. } => Some((binding.name.as_str(), sample_type)),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn a_texture_is_filterable_where_a_sampler_ever_reads_it() {
        // `passed` reaches its sampler through a function's parameters.
        let reflection = reflected(
            "@group(0) @binding(0) var loaded: texture_2d<f32>;
            @group(0) @binding(1) var passed: texture_2d<f32>;
            @group(0) @binding(2) var counted: texture_2d<u32>;
            @group(0) @binding(3) var depth: texture_depth_2d_array;
            @group(0) @binding(4) var smooth_sampler: sampler;
            @group(0) @binding(5) var<storage, read_write> out: array<f32>;
            fn read(t: texture_2d<f32>, s: sampler) -> f32 {
                return textureSampleLevel(t, s, vec2(0.5), 0.0).x;
            }
            @compute @workgroup_size(1) fn main() {
                out[0] = textureLoad(loaded, vec2(0), 0).x + read(passed, smooth_sampler)
                    + f32(textureLoad(counted, vec2(0), 0).x) + textureLoad(depth, vec2(0), 0, 0);
            }",
        );
        let expected = BTreeMap::from([
            ("loaded", SampleType::UnfilterableFloat),
            ("passed", SampleType::Float),
            ("counted", SampleType::Uint),
            ("depth", SampleType::Depth),
        ]);
        assert_eq!(sample_types(&reflection), expected);
    }

    #[test]
    fn stages_see_what_they_use() {
        let reflection = reflected(
            "@group(0) @binding(0) var<uniform> both: vec4<f32>;
            @group(1) @binding(3) var<uniform> tint: vec4<f32>;
            @vertex fn place() -> @builtin(position) vec4<f32> { return both; }
            @fragment fn paint() -> @location(0) vec4<f32> { return both * tint; }",
        );
        let visible: Vec<_> = reflection
            .bindings
            .iter()
            .map(|of| (of.group, of.binding, of.visibility.as_slice()))
            .collect();
        let (vertex, fragment) = (Stage::Vertex, Stage::Fragment);
        assert_eq!(visible, [(0, 0, &[vertex, fragment][..]), (1, 3, &[fragment])]);
        assert_eq!(reflection.limits["maxBindGroups"], 2);
        assert_eq!(reflection.limits["maxUniformBuffersPerShaderStage"], 2);
    }

    #[test]
    fn limits_count_what_an_entry_point_uses() {
        let reflection = reflected(
            "@group(0) @binding(0) var<storage, read> a: array<f32>;
            @group(0) @binding(1) var<storage, read_write> b: array<f32>;
            var<workgroup> tile: array<vec3<f32>, 3>;
            var<workgroup> flag: u32;
            @compute @workgroup_size(8, 4, 2) fn main(@builtin(local_invocation_index) i: u32) {
                tile[i % 3u].x = a[i];
                flag = 1u;
                workgroupBarrier();
                b[i] = tile[(i + 1u) % 3u].x;
            }
            @compute @workgroup_size(1) fn clear() { b[0] = 0.0; }",
        );
        let expected = [
            ("maxBindGroups", 1),
            ("maxComputeInvocationsPerWorkgroup", 64),
            ("maxComputeWorkgroupSizeX", 8),
            ("maxComputeWorkgroupSizeY", 4),
            ("maxComputeWorkgroupSizeZ", 2),
            // 48 bytes and 4, which counts as 16.
            ("maxComputeWorkgroupStorageSize", 64),
            ("maxStorageBuffersPerShaderStage", 2),
        ];
        let expected = expected.map(|(name, value)| (name.to_owned(), value));
        assert_eq!(reflection.limits, BTreeMap::from(expected));
    }

    #[test]
    fn least_sizes_hold_one_element() {
        let reflection = reflected(
            "struct Item { at: vec3<f32>, weight: f32, tag: u32 }
            struct List { count: u32, items: array<Item> }
            @group(0) @binding(0) var<storage, read_write> list: List;
            @group(0) @binding(1) var<storage, read> items: array<Item>;
            @compute @workgroup_size(1) fn main() { list.items[list.count] = items[0]; }",
        );
        let sizes: Vec<_> = reflection.bindings.iter().map(|binding| &binding.resource).collect();
        assert!(matches!(
            sizes[0],
            Resource::Storage { min_size: 48, access: Access::ReadWrite, stride: None, .. }
        ));
        assert!(matches!(
            sizes[1],
            Resource::Storage { min_size: 32, access: Access::Read, stride: Some(32), .. }
        ));
        let strides = reflection.layouts[1].fields.iter().map(|field| field.r#type.stride());
        assert_eq!(strides.collect::<Vec<_>>(), [None, Some(32)]);
        let names: Vec<_> = reflection.layouts.iter().map(|layout| layout.name.as_str()).collect();
        assert_eq!(names, ["Item", "List"]);
    }

    #[test]
    fn a_comment_belongs_to_what_comes_next() {
        let reflection = reflected(
            "/// A thing,
            /// in two lines.
            struct Thing {
                first: f32, // not this
                /// The second.
                @align(16) second: f32,
                // Nor this.
                third: f32,
            }
            /// Where it lies.
            @group(0) @binding(0)
            var<storage, read_write> thing: Thing;
            @compute @workgroup_size(1) fn main() { thing.first = thing.second + thing.third; }",
        );
        assert_eq!(reflection.bindings[0].description, "Where it lies.");
        let layout = &reflection.layouts[0];
        assert_eq!(layout.description, "A thing, in two lines.");
        let fields: Vec<_> = layout.fields.iter().map(|field| field.description.as_str()).collect();
        assert_eq!(fields, ["", "The second.", ""]);
    }

    #[test]
    fn what_no_host_can_bind_is_refused() {
        let text = "enable wgpu_binding_array;
            @group(0) @binding(0) var many: binding_array<texture_2d<f32>, 4>;
            @group(0) @binding(1) var<storage, read_write> out: array<f32>;
            @compute @workgroup_size(1) fn main() { out[0] = textureLoad(many[0], vec2(0), 0).x; }";
        let module = naga::front::wgsl::parse_str(text).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        let error = reflect(text, &module, &info).unwrap_err();
        assert!(error.to_string().contains("`many` is an array of bindings"), "{error}");
    }
}
