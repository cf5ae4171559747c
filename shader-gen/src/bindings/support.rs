//! The items that every crate of bindings has at its root.

use proc_macro2::TokenStream;
use quote::quote;

/// Their names.
pub(super) const RESERVED: [&str; 12] = [
    "Embedded",
    "EntryPoint",
    "Exclusion",
    "Override",
    "UnknownValue",
    "Variant",
    "MANIFEST",
    "VARIANTS",
    "EMBEDDED",
    "bind_groups",
    "embedded",
    "variant",
];

pub(super) fn support() -> TokenStream {
    quote! {
        /// What a host has to know of a variant to make a pipeline of it.
        #[derive(Clone, Copy, Debug)]
        pub struct Variant {
            /// Pass and values joined by `-`.
            pub id: &'static str,
            /// Name of its pass.
            pub pass: &'static str,
            /// Its entry points.
            pub entry_points: &'static [EntryPoint],
            /// The entries of its bind groups: group by group, each sorted by binding.
            pub bind_groups: &'static [&'static [wgpu::BindGroupLayoutEntry]],
            /// The names that the text gives to those entries.
            pub binding_names: &'static [&'static [&'static str]],
        }

        /// A function that a pipeline starts in.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct EntryPoint {
            /// Its name.
            pub name: &'static str,
            /// Its stage.
            pub stage: wgpu::ShaderStages,
            /// Invocations of a workgroup in x, y and z; compute only.
            pub workgroup_size: Option<[u32; 3]>,
        }

        /// The text of a variant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Embedded {
            /// Pass and values joined by `-`.
            pub id: &'static str,
            /// Name of its pass.
            pub pass: &'static str,
            /// Its WGSL.
            pub text: &'static str,
            /// SHA-256 of the text in hexadecimal.
            pub sha256: &'static str,
        }

        /// A number that may be set when a pipeline is made.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Override {
            /// Its key among a pipeline's constants.
            pub name: &'static str,
            /// The value it has when none is set; one has to be set if absent.
            pub default: Option<f64>,
            /// The least value allowed.
            pub minimum: Option<f64>,
            /// The greatest value allowed.
            pub maximum: Option<f64>,
        }

        /// The rule that takes a combination of values out of the space.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Exclusion {
            /// Name of the rule.
            pub name: &'static str,
            /// Why.
            pub reason: &'static str,
        }

        /// A name that no value of an axis has.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct UnknownValue {
            /// The axis.
            pub axis: &'static str,
            /// The name.
            pub value: String,
            /// The names that are known.
            pub known: Vec<&'static str>,
        }

        impl core::fmt::Display for UnknownValue {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(
                    f,
                    "unknown value '{}' of axis '{}'; known values: {}",
                    self.value,
                    self.axis,
                    self.known.join(", "),
                )
            }
        }

        impl core::error::Error for UnknownValue {}

        /// The variant with this identifier, if the package has it.
        pub fn variant(id: &str) -> Option<&'static Variant> {
            VARIANTS.binary_search_by(|variant| variant.id.cmp(id)).ok().and_then(|at| VARIANTS.get(at))
        }

        /// The entries of the bind groups of the variant with this identifier, if the package has it.
        pub fn bind_groups(id: &str) -> Option<&'static [&'static [wgpu::BindGroupLayoutEntry]]> {
            variant(id).map(|variant| variant.bind_groups)
        }

        /// The text of the variant with this identifier, if the package has it.
        pub fn embedded(id: &str) -> Option<&'static Embedded> {
            EMBEDDED.binary_search_by(|embedded| embedded.id.cmp(id)).ok().and_then(|at| EMBEDDED.get(at))
        }
    }
}
