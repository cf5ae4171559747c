//! The f64 evaluation of every formula of sglow, and the references that the formulas approximate.
//!
//! Written from the papers and from the conventions in `docs/conventions.md`, apart from the shaders, so that agreement
//! between the two means something. Everything is a pure function over plain arrays.
//!
//! # Two kinds of number
//! A stage's function is generic over [`Real`]. With `f64` it gives the value. With [`Bounded`] it gives the value
//! together with the largest distance that an f32 evaluation may keep from it, when every operation is granted the
//! error that Vulkan and WebGPU grant. That distance is the tolerance of a comparison: a function of the input.
//!
//! # Pipeline
//! [`surface`] and [`light`] make virtual point lights; [`rsm`] makes their moments and mips; [`density`] says by
//! what kernels are drawn; [`fis`] places the kernels; [`vsgl`] makes one light per kernel, [`cluster`] one per cluster of
//! texels, [`cut`] one per node of a tree over them; [`visibility`] says what hides them; [`shade`] reflects them;
//! [`direct`] and [`compose`] add the rest.
//! [`sg`] has the integrals of spherical Gaussians that shading is made of, on the functions of [`math`].
//! The references are [`quadrature`] for integrals over the sphere, and [`vpl`] (without visibility) and [`path`] (with
//! it) for whole pictures; `docs/references.md` says how far off they are.
//!
//! # Citations
//! - Abasi 2020: Distance metrics for very large color differences, Color Res. Appl. 45(2).
//! - Andersson 2020: FLIP: a difference evaluator for alternating images, Proc. ACM Comput. Graph. Interact. Tech. 3(2).
//! - Apetrei 2014: Fast and simple agglomerative LBVH construction, Computer Graphics and Visual Computing.
//! - Banerjee 2005: Clustering on the unit hypersphere using von Mises-Fisher distributions, JMLR 6.
//! - Barak 2013: Temporally coherent adaptive sampling for imperfect shadow maps, Comput. Graph. Forum 32(4).
//! - Baum 1989: Improving radiosity solutions through the use of analytically determined form factors, SIGGRAPH.
//! - Chan 1983: Algorithms for computing the sample variance: analysis and recommendations, The American Statistician 37(3).
//! - Cigolle 2014: A survey of efficient representations for independent unit vectors, JCGT 3(2).
//! - Clarberg 2005: Wavelet importance sampling, ACM Trans. Graph. 24(3).
//! - Cochran 1977: Sampling techniques, 3rd edition, Wiley.
//! - Dachsbacher 2005: Reflective shadow maps, I3D.
//! - DLMF: NIST Digital Library of Mathematical Functions, <https://dlmf.nist.gov>.
//! - Dupuy 2023: Sampling visible GGX normals with spherical caps, Comput. Graph. Forum 42(8).
//! - Hastings 1970: Monte Carlo sampling methods using Markov chains and their applications, Biometrika 57(1).
//! - Duff 2017: Building an orthonormal basis, revisited, JCGT 6(1).
//! - Heitz 2014: Understanding the masking-shadowing function, JCGT 3(2).
//! - Howell: A catalog of radiation heat transfer configuration factors, <http://www.thermalradiation.net>.
//! - Jarzynski and Olano 2020: Hash functions for GPU rendering, JCGT 9(3).
//! - Karras 2012: Maximizing parallelism in the construction of BVHs, octrees, and k-d trees, High-Performance Graphics.
//! - Keller 1997: Instant radiosity, SIGGRAPH.
//! - Krivanek 2008: Real-time shading with filtered importance sampling, Comput. Graph. Forum 27(4).
//! - Kroeger 2015: Simple, admissible, and accurate approximants of the inverse Langevin and Brillouin functions,
//!   relevant for strong polymer deformations and flows, J. Non-Newton. Fluid Mech. 223.
//! - Lambert 1760: Photometria sive de mensura et gradibus luminis, colorum et umbrae.
//! - Marroquim 2007: Efficient point-based rendering using image reconstruction, Symposium on Point-Based Graphics.
//! - Meder 2018: Screen space approximate Gaussian hulls, EGSR Experimental Ideas and Implementations.
//! - Metropolis 1953: Equation of state calculations by fast computing machines, J. Chem. Phys. 21(6).
//! - Morton 1966: A computer oriented geodetic data base and a new technique in file sequencing, IBM.
//! - Ritschel 2011: Making imperfect shadow maps view-adaptive, Comput. Graph. Forum 30(8).
//! - Ritschel 2008: Imperfect shadow maps for efficient computation of indirect illumination, ACM Trans. Graph. 27(5).
//! - Schlick 1994: An inexpensive BRDF model for physically-based rendering, Comput. Graph. Forum 13(3).
//! - Sutherland 1974: Reentrant polygon clipping, Commun. ACM 17(1).
//! - Tokuyoshi 2015: Fast indirect illumination using two virtual spherical Gaussian lights, supplement.
//! - Tokuyoshi 2016: Modified filtered importance sampling for virtual spherical Gaussian lights, CVM 2(4).
//! - Tokuyoshi 2022: Accurate diffuse lighting from spherical Gaussian lights, SIGGRAPH Posters.
//! - Tokuyoshi 2024: Hierarchical light sampling with accurate spherical Gaussian lighting, SIGGRAPH Asia.
//! - Toksvig 2005: Mipmapping normal maps, J. Graph. Tools 10(3).
//! - Veach 1997: Robust Monte Carlo methods for light transport simulation, dissertation, Stanford University.
//! - Walter 2007: Microfacet models for refraction through rough surfaces, EGSR.
//! - Wang 2009: All-frequency rendering of dynamic, spatially-varying reflectance, ACM Trans. Graph. 28(5).
//! - Woop 2013: Watertight ray/triangle intersection, JCGT 2(1).
//! - Xu 2013: Anisotropic spherical Gaussians, ACM Trans. Graph. 32(6).

pub mod asg;
pub mod brdf;
pub mod cluster;
pub mod compose;
pub mod cut;
pub mod density;
pub mod direct;
pub mod estimate;
pub mod fis;
pub mod flip;
mod groups;
pub mod half;
pub mod light;
pub mod math;
pub mod metrics;
pub mod path;
pub mod quadrature;
pub mod real;
pub mod rsm;
pub mod sg;
pub mod shade;
pub mod surface;
pub mod tolerance;
pub mod vector;
pub mod visibility;
pub mod vmf;
pub mod vpl;
pub mod vsgl;

pub use real::{Linear, Real};
pub use tolerance::Bounded;
pub use vector::Vector3;

#[cfg(test)]
mod adversary;
#[cfg(test)]
mod scenery;
