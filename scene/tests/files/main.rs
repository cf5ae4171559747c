//! Scenes from files, as a user has them.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests are tests, too")]

mod cases;
mod common;
mod details;
mod obj;
mod outside;
