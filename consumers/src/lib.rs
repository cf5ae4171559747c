//! Independent consumers of what this project makes, and the machine that they need: compilers that share no code with the
//! generator, hosts in other languages, a browser.

pub mod chromium;
pub mod cost;
pub mod doctor;
pub mod fuzz;
pub mod hosts;
mod known;
pub mod machine;
pub mod spirv_val;
pub mod subject;
pub mod tint;
mod turns;
pub mod verify;
