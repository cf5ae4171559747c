//! A frame as data: resources and steps of a renderer.
pub mod configuration;
pub mod description;
pub mod error;
mod evaluate;
pub mod formula;
pub mod frame;
mod parse;
pub mod reference;
mod scope;

pub use configuration::Configuration;
pub use description::Description;
pub use error::{Error, Errors, Place, Problem};
pub use formula::Formula;
pub use frame::Frame;
