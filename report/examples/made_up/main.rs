//! Writes the pages of made-up scenes into a folder: what a browser opens to see how pages look.

use std::path::PathBuf;

use sglow_report::failure::{Failure, Result};
use sglow_report::write;

mod scenes;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).ok_or_else(|| Failure::new("name a folder"))?;
    let folder = PathBuf::from(folder);
    write::text(&folder.join("whole.html"), &scenes::whole())?;
    write::text(&folder.join("one.html"), &scenes::one())
}
