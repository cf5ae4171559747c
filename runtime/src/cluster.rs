//! Virtual lights of clusters of texels: what filtered importance sampling is compared with.
//!
//! Centres are drawn by the density, each texel of the map goes to the closest one, texels are sorted by cluster, and one
//! invocation sums each cluster [Tokuyoshi 2016, Appendix D].

use bytemuck::{Pod, Zeroable};
use sglow_shaders::{
    Draw, Light, Lobes, Precision, SglowLight, Sharpness, Space, SpecularPower, Variance, centres,
    cluster_assign, cluster_boxes, cluster_codes, cluster_starts, cluster_sum, cluster_tree,
};
use thiserror::Error;

use crate::generation::vsgl_size;
use crate::indirect::SurfaceViews;
use crate::light::LightView;
use crate::package::Package;
use crate::pipeline::{ComputePass, PipelineError, Step, constant, encode_stage, storage, uniform};
use crate::sort::{MOST_KEYS, SortBuffers, SortPasses};
use crate::timing::Timer;

/// Why there are no clusters.
#[derive(Debug, Error)]
pub enum ClusterError {
    /// A setting cannot be.
    #[error("{name} is {value}, and must be {range}")]
    Range {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        range: String,
    },
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
}

/// What clusters are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterSettings {
    /// Width and height of the map in texels, any that its textures can have.
    pub size: [u32; 2],
    /// Number of clusters, which is the number of virtual lights: 1 to 65536.
    pub count: u32,
    /// How centres are drawn.
    pub draw: Draw,
    /// Where texels are close to a centre.
    pub space: Space,
    /// The kind of the light whose map it is.
    pub light: Light,
    /// The variance of virtual lights' positions.
    pub variance: Variance,
    /// How the sharpness of virtual lights' directions follows from their mean.
    pub sharpness: Sharpness,
    /// The lobes that virtual lights emit.
    pub lobes: Lobes,
    /// Length of the mean direction of a texel's diffuse emission, 0 to 1.
    pub diffuse_mean_length: f32,
    /// The power of their specular lobes; F0 with diffuse lobes alone.
    pub specular_power: SpecularPower,
}

impl ClusterSettings {
    fn sum(&self) -> cluster_sum::ClusterSum {
        let Self { light, variance, sharpness, lobes, specular_power, .. } = *self;
        cluster_sum::ClusterSum { light, variance, sharpness, lobes, specular_power }
    }

    /// The variants that they run.
    pub(crate) fn variants(&self) -> Vec<String> {
        let Self { draw, space, .. } = *self;
        let mut variants = SortPasses::variants();
        variants.extend([
            centres::Centres { draw, space }.id(),
            cluster_codes::ClusterCodes { space }.id(),
            cluster_tree::ClusterTree.id(),
            cluster_boxes::ClusterBoxes.id(),
            cluster_assign::ClusterAssign { space }.id(),
            cluster_starts::ClusterStarts.id(),
            self.sum().id(),
        ]);
        variants
    }

    /// What [`Clusters::bytes`] says of clusters with these settings.
    pub(crate) fn bytes(&self) -> Vec<(&'static str, u64)> {
        let count = u64::from(self.count);
        let inner = (count - 1).max(1);
        let length = self.size[0] * self.size[1];
        vec![
            ("centres", 4 * (4 * count + 6)),
            (
                "cluster tree",
                SortBuffers::bytes_of(self.count)
                    + 4 * (2 * inner + 2 * count - 1 + 4 * count + 6 * inner),
            ),
            ("sorted texels", SortBuffers::bytes_of(length) + 4 * (count + 1)),
            ("vsgls", count * vsgl_size(self.lobes, Precision::F32)),
        ]
    }
}

/// What one frame of clusters reads.
pub struct ClusterInputs<'a> {
    /// The map, of the settings' size.
    pub map: SurfaceViews<'a>,
    /// The light and its map.
    pub light: &'a LightView,
    /// All levels of the density, as a texture array: a power-of-two square, 0 where the map is smaller.
    pub density: &'a wgpu::TextureView,
    /// Where the chains are, with [`Draw::Metropolis`]: [`crate::metropolis::Metropolis::chains`], at least `count`.
    pub chains: Option<&'a wgpu::Buffer>,
}

// The layouts of uniforms whose passes are not committed, and so have no structs in the bindings; padded to 16 bytes.

/// Of the passes that have one invocation a cluster.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct CountParameters {
    count: u32,
    padding: [u32; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AssignParameters {
    size: [u32; 2],
    count: u32,
    padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct StartsParameters {
    length: u32,
    count: u32,
    padding: [u32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SumParameters {
    light: SglowLight,
    origin: [f32; 3],
    count: u32,
    minimum_variance: f32,
    diffuse_mean_length: f32,
    padding: [u32; 2],
}

/// The passes of clusters, with all they keep between them.
pub struct Clusters {
    device: wgpu::Device,
    queue: wgpu::Queue,
    settings: ClusterSettings,
    centres: wgpu::Buffer,
    /// The box around the centres, six words.
    centres_box: wgpu::Buffer,
    codes: SortBuffers,
    children: wgpu::Buffer,
    parents: wgpu::Buffer,
    leaves: wgpu::Buffer,
    boxes: wgpu::Buffer,
    texels: SortBuffers,
    starts: wgpu::Buffer,
    vsgls: wgpu::Buffer,
    count_parameters: wgpu::Buffer,
    assign_parameters: wgpu::Buffer,
    starts_parameters: wgpu::Buffer,
    sum_parameters: wgpu::Buffer,
    centres_pass: ComputePass,
    codes_pass: ComputePass,
    sort_passes: SortPasses,
    tree_pass: ComputePass,
    boxes_pass: ComputePass,
    assign_pass: ComputePass,
    starts_pass: ComputePass,
    sum_pass: ComputePass,
}

/// What a stage's time stands under.
const CENTRES: &str = "centres";
const ASSIGNMENT: &str = "cluster assignment";
const SORT: &str = "cluster sort";
const SUM: &str = "cluster sum";

fn check(device: &wgpu::Device, settings: &ClusterSettings) -> Result<(), ClusterError> {
    let limits = device.limits();
    let range = |holds: bool, name, value: String, range: String| {
        if holds { Ok(()) } else { Err(ClusterError::Range { name, value, range }) }
    };
    let [width, height] = settings.size;
    let most = limits.max_texture_dimension_2d;
    for (name, side) in [("the width of the map", width), ("the height of the map", height)] {
        let holds = (1..=most).contains(&side);
        let text = format!("between 1 and {most}, the most this device's textures have");
        range(holds, name, side.to_string(), text)?;
    }
    // Four bytes a texel in each buffer.
    let most = u64::from(MOST_KEYS).min(limits.max_storage_buffer_binding_size / 4);
    let texels = u64::from(width) * u64::from(height);
    let text = format!("at most {most}, which one buffer of this device can be sorted of");
    range(texels <= most, "the number of texels of the map", texels.to_string(), text)?;
    let count = settings.count;
    let holds = (1..=65536).contains(&count);
    range(holds, "the number of clusters", count.to_string(), "1 to 65536".to_owned())?;
    let (space, spaces) = (settings.space, "image or world, for without one there are no clusters");
    range(space != Space::None, "the space of clusters", space.to_string(), spaces.to_owned())
}

impl Clusters {
    /// Clusters by a package that has their passes, which the embedded one has not.
    ///
    /// # Errors
    ///
    /// A setting out of its range; or the variant that the package lacks or the device refuses.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        settings: &ClusterSettings,
    ) -> Result<Self, ClusterError> {
        check(device, settings)?;
        let ClusterSettings { size, count, draw, space, lobes, .. } = *settings;
        let length = size[0] * size[1];
        let pass = |id: String, label| ComputePass::new(device, package, &id, label, &[]);
        let words = |label, words: u32| storage(device, label, u64::from(words));
        let code_bits = match space {
            Space::None | Space::Image => 32,
            Space::World => 30,
        };
        let cluster_bits = u32::BITS - (count - 1).leading_zeros();
        let vsgl_bytes = vsgl_size(lobes, Precision::F32);
        let count_parameters = CountParameters { count, padding: [0; 3] };
        let starts_parameters = StartsParameters { length, count, padding: [0; 2] };
        Ok(Self {
            centres: words("sglow centres", 4 * count),
            centres_box: words("sglow box of centres", 6),
            codes: SortBuffers::new(device, count, code_bits),
            children: words("sglow children", 2 * (count - 1).max(1)),
            parents: words("sglow parents", 2 * count - 1),
            leaves: words("sglow leaves", 4 * count),
            boxes: words("sglow boxes", 6 * (count - 1).max(1)),
            texels: SortBuffers::new(device, length, cluster_bits),
            starts: words("sglow starts", count + 1),
            vsgls: words("sglow cluster vsgls", count * (vsgl_bytes / 4) as u32),
            count_parameters: constant(device, "sglow clusters", &count_parameters),
            assign_parameters: constant(
                device,
                "sglow assignment",
                &AssignParameters { size, count, padding: 0 },
            ),
            starts_parameters: constant(device, "sglow starts", &starts_parameters),
            sum_parameters: uniform::<SumParameters>(device, "sglow sum parameters"),
            centres_pass: pass(centres::Centres { draw, space }.id(), CENTRES)?,
            codes_pass: pass(cluster_codes::ClusterCodes { space }.id(), ASSIGNMENT)?,
            sort_passes: SortPasses::new(device, package)?,
            tree_pass: pass(cluster_tree::ClusterTree.id(), ASSIGNMENT)?,
            boxes_pass: pass(cluster_boxes::ClusterBoxes.id(), ASSIGNMENT)?,
            assign_pass: pass(cluster_assign::ClusterAssign { space }.id(), ASSIGNMENT)?,
            starts_pass: pass(cluster_starts::ClusterStarts.id(), SORT)?,
            sum_pass: pass(settings.sum().id(), SUM)?,
            device: device.clone(),
            queue: queue.clone(),
            settings: *settings,
        })
    }

    /// Encodes one frame: from the map to virtual lights in [`Self::vsgls`]. Its stages are timed as "centres",
    /// "cluster assignment" (codes, their sort, the tree, the closest centres), "cluster sort" and "cluster sum".
    ///
    /// # Errors
    ///
    /// When chains draw the centres and there are none, or fewer than clusters.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &ClusterInputs<'_>,
        mut timer: Option<&mut Timer<'_>>,
    ) -> Result<(), ClusterError> {
        self.encode_centres(encoder, inputs, timer.as_deref_mut())?;
        self.encode_assignment(encoder, inputs, timer.as_deref_mut());
        self.encode_sort(encoder, timer.as_deref_mut());
        self.encode_sum(encoder, inputs, timer);
        Ok(())
    }

    fn stage(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
        label: &'static str,
        steps: &[Step<'_>],
    ) {
        encode_stage(&self.device, encoder, timer, label, steps);
    }

    /// One invocation for each cluster, 64 in a workgroup.
    fn groups(&self) -> [u32; 3] {
        [self.settings.count.div_ceil(64), 1, 1]
    }

    /// The first stage: the centres.
    ///
    /// # Errors
    ///
    /// When chains draw the centres and there are none, or fewer than clusters.
    pub fn encode_centres(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &ClusterInputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), ClusterError> {
        let mut bindings = vec![
            (0, self.count_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(inputs.density)),
            (3, self.centres.as_entire_binding()),
            (4, self.centres_box.as_entire_binding()),
        ];
        if self.settings.space == Space::World {
            bindings.push((2, wgpu::BindingResource::TextureView(inputs.map.position)));
        }
        if self.settings.draw == Draw::Metropolis {
            let available = inputs.chains.map_or(0, |chains| chains.size() / 8);
            match inputs.chains.filter(|_| available >= u64::from(self.settings.count)) {
                Some(chains) => bindings.push((8, chains.as_entire_binding())),
                None => {
                    return Err(ClusterError::Range {
                        name: "the number of chains that draw the centres",
                        value: available.to_string(),
                        range: format!("at least {}, one a cluster", self.settings.count),
                    });
                }
            }
        }
        encoder.clear_buffer(&self.centres_box, 0, None);
        let step = Step { pass: &self.centres_pass, bindings, workgroups: self.groups() };
        self.stage(encoder, timer, CENTRES, &[step]);
        Ok(())
    }

    /// The second stage: the tree of the centres, and the closest one of each texel.
    pub fn encode_assignment(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &ClusterInputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let workgroups = self.groups();
        let mut steps = vec![Step {
            pass: &self.codes_pass,
            bindings: vec![
                (0, self.count_parameters.as_entire_binding()),
                (1, self.centres.as_entire_binding()),
                (2, self.centres_box.as_entire_binding()),
                (3, self.codes.keys().as_entire_binding()),
                (4, self.codes.values().as_entire_binding()),
            ],
            workgroups,
        }];
        steps.extend(self.codes.steps(&self.sort_passes));
        steps.push(Step {
            pass: &self.tree_pass,
            bindings: vec![
                (0, self.count_parameters.as_entire_binding()),
                (1, self.codes.sorted_keys().as_entire_binding()),
                (2, self.children.as_entire_binding()),
                (3, self.parents.as_entire_binding()),
            ],
            workgroups,
        });
        encoder.clear_buffer(&self.boxes, 0, None);
        steps.push(Step {
            pass: &self.boxes_pass,
            bindings: vec![
                (0, self.count_parameters.as_entire_binding()),
                (1, self.centres.as_entire_binding()),
                (2, self.codes.sorted_values().as_entire_binding()),
                (3, self.parents.as_entire_binding()),
                (4, self.leaves.as_entire_binding()),
                (5, self.boxes.as_entire_binding()),
            ],
            workgroups,
        });
        let mut bindings = vec![
            (0, self.assign_parameters.as_entire_binding()),
            (2, self.children.as_entire_binding()),
            (3, self.boxes.as_entire_binding()),
            (4, self.leaves.as_entire_binding()),
            (5, self.texels.keys().as_entire_binding()),
            (6, self.texels.values().as_entire_binding()),
        ];
        if self.settings.space == Space::World {
            bindings.push((1, wgpu::BindingResource::TextureView(inputs.map.position)));
        }
        let [width, height] = self.settings.size;
        steps.push(Step {
            pass: &self.assign_pass,
            bindings,
            workgroups: [width.div_ceil(8), height.div_ceil(8), 1],
        });
        self.stage(encoder, timer, ASSIGNMENT, &steps);
    }

    /// The third stage: the texels sorted by cluster, and where each cluster begins.
    pub fn encode_sort(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut Timer<'_>>) {
        let mut steps = self.texels.steps(&self.sort_passes);
        steps.push(Step {
            pass: &self.starts_pass,
            bindings: vec![
                (0, self.starts_parameters.as_entire_binding()),
                (1, self.texels.sorted_keys().as_entire_binding()),
                (2, self.starts.as_entire_binding()),
            ],
            workgroups: [(self.settings.count + 1).div_ceil(64), 1, 1],
        });
        self.stage(encoder, timer, SORT, &steps);
    }

    /// The last stage: a virtual light of each cluster.
    pub fn encode_sum(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &ClusterInputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let parameters = SumParameters {
            light: inputs.light.uniform,
            origin: inputs.light.origin.into(),
            count: self.settings.count,
            minimum_variance: inputs.light.minimum_variance,
            diffuse_mean_length: self.settings.diffuse_mean_length,
            padding: [0; 2],
        };
        self.queue.write_buffer(&self.sum_parameters, 0, bytemuck::bytes_of(&parameters));
        let step = Step {
            pass: &self.sum_pass,
            bindings: vec![
                (0, self.sum_parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(inputs.map.position)),
                (2, wgpu::BindingResource::TextureView(inputs.map.normal)),
                (3, wgpu::BindingResource::TextureView(inputs.map.base_color)),
                (4, self.texels.sorted_values().as_entire_binding()),
                (5, self.starts.as_entire_binding()),
                (6, self.vsgls.as_entire_binding()),
            ],
            workgroups: self.groups(),
        };
        self.stage(encoder, timer, SUM, &[step]);
    }

    /// What it was made with.
    pub fn settings(&self) -> &ClusterSettings {
        &self.settings
    }

    /// The virtual lights: `SglowVsglBoth` or `SglowVsglDiffuse`, after the lobes.
    pub fn vsgls(&self) -> &wgpu::Buffer {
        &self.vsgls
    }

    /// The centres: four floats each, x, y and z in pixels of the map (z is 0) or in world space, and a 0.
    pub fn centres(&self) -> &wgpu::Buffer {
        &self.centres
    }

    /// The cluster of each texel, row by row: a word each.
    pub fn assignment(&self) -> &wgpu::Buffer {
        self.texels.keys()
    }

    /// The texels in the order of their clusters: a word each.
    pub fn order(&self) -> &wgpu::Buffer {
        self.texels.sorted_values()
    }

    /// Where the texels of each cluster begin in [`Self::order`], and behind the last one where they all end.
    pub fn starts(&self) -> &wgpu::Buffer {
        &self.starts
    }

    /// The bytes of the buffers that it keeps between its passes; those of the parameters are left out.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let tree = [&self.children, &self.parents, &self.leaves, &self.boxes];
        vec![
            ("centres", self.centres.size() + self.centres_box.size()),
            (
                "cluster tree",
                self.codes.bytes() + tree.into_iter().map(wgpu::Buffer::size).sum::<u64>(),
            ),
            ("sorted texels", self.texels.bytes() + self.starts.size()),
            ("vsgls", self.vsgls.size()),
        ]
    }
}
