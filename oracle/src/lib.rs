//! The f64 evaluation of every formula of sglow, and the truths that the formulas approximate.
//!
//! Written from the papers and from the conventions in `ARCHITECTURE.md`, apart from the shaders, so that agreement
//! between the two means something. Everything is a pure function over plain arrays.
//!
//! # Two kinds of number
//! A stage's function is generic over [`Real`]. With `f64` it gives the value. With [`Bounded`] it gives the value
//! together with the largest distance that an f32 evaluation may keep from it, when every operation is granted the
//! error that Vulkan and WebGPU grant. That distance is the tolerance of a comparison: a function of the input.
//!
//! # Pipeline
//! [`surface`] and [`light`] make virtual point lights; [`rsm`] makes their moments, density and mips; [`fis`] places
//! the kernels; [`vsgl`] makes one light per kernel; [`visibility`] says what hides them; [`shade`] reflects them;
//! [`direct`] and [`compose`] add the rest.
//! [`sg`] has the integrals of spherical Gaussians that shading is made of, on the functions of [`math`].
//! The truths are [`quadrature`] for integrals over the sphere and [`vpl`] for whole pictures.
//!
//! # Citations
//! - Banerjee 2005: Clustering on the unit hypersphere using von Mises-Fisher distributions, JMLR 6.
//! - Cigolle 2014: A survey of efficient representations for independent unit vectors, JCGT 3(2).
//! - Clarberg 2005: Wavelet importance sampling, ACM Trans. Graph. 24(3).
//! - DLMF: NIST Digital Library of Mathematical Functions, <https://dlmf.nist.gov>.
//! - Duff 2017: Building an orthonormal basis, revisited, JCGT 6(1).
//! - Heitz 2014: Understanding the masking-shadowing function, JCGT 3(2).
//! - Krivanek 2008: Real-time shading with filtered importance sampling, Comput. Graph. Forum 27(4).
//! - Kroeger 2015: Simple, admissible, and accurate approximants of the inverse Langevin and Brillouin functions,
//!   relevant for strong polymer deformations and flows, J. Non-Newton. Fluid Mech. 223.
//! - Marroquim 2007: Efficient point-based rendering using image reconstruction, Symposium on Point-Based Graphics.
//! - Meder 2018: Screen space approximate Gaussian hulls, EGSR Experimental Ideas and Implementations.
//! - Ritschel 2008: Imperfect shadow maps for efficient computation of indirect illumination, ACM Trans. Graph. 27(5).
//! - Schlick 1994: An inexpensive BRDF model for physically-based rendering, Comput. Graph. Forum 13(3).
//! - Tokuyoshi 2015: Fast indirect illumination using two virtual spherical Gaussian lights, supplement.
//! - Tokuyoshi 2016: Modified filtered importance sampling for virtual spherical Gaussian lights, CVM 2(4).
//! - Tokuyoshi 2022: Accurate diffuse lighting from spherical Gaussian lights, SIGGRAPH Posters.
//! - Tokuyoshi 2024: Hierarchical light sampling with accurate spherical Gaussian lighting, SIGGRAPH Asia.
//! - Toksvig 2005: Mipmapping normal maps, J. Graph. Tools 10(3).
//! - Walter 2007: Microfacet models for refraction through rough surfaces, EGSR.
//! - Wang 2009: All-frequency rendering of dynamic, spatially-varying reflectance, ACM Trans. Graph. 28(5).
//! - Xu 2013: Anisotropic spherical Gaussians, ACM Trans. Graph. 32(6).

pub mod asg;
pub mod brdf;
pub mod compose;
pub mod direct;
pub mod fis;
pub mod half;
pub mod light;
pub mod math;
pub mod metrics;
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
