//! Errors of bindings.

/// Why there are no bindings.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Two things of the library would have one name in Rust.
    #[error(
        "`{name}` would name {first} and {second} in the Rust bindings; rename one of them in the library"
    )]
    Collision {
        /// The name.
        name: String,
        /// One of them.
        first: String,
        /// The other.
        second: String,
    },
    /// A number that Rust has no type for.
    #[error(
        "`{place}` is {ty}, for which the Rust bindings have no type; known are f16, f32, f64, i32, u32, i64, u64"
    )]
    Scalar {
        /// Struct and field.
        place: String,
        /// Its type in WGSL.
        ty: String,
    },
    /// The generated text is invalid Rust.
    #[error("the generated bindings are not Rust: {0}")]
    Syntax(#[from] syn::Error),
}
