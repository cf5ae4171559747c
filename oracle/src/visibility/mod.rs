//! What hides a virtual light from a shading point: its map, however made, the comparison with it, and the reference.

pub mod basis;
pub mod exact;
pub mod light_fill;
pub mod light_points;
pub mod light_shadow;
pub mod map;
pub mod visible;

pub use basis::Basis;
pub use light_points::Point;
pub use map::{Maps, View};
pub use visible::{Seen, visible};
