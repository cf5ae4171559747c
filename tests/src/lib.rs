//! Whole-system tests: every stage on the device against the oracle, whole frames, pruning, packages, bad input.
//!
//! A stage's test takes what the device read (its inputs, read back), evaluates the oracle with derived tolerances, and
//! compares with what the device wrote. Each has a negative control: a shader that is broken on purpose must fail.

#[cfg(test)]
mod cluster;
#[cfg(test)]
mod common;
#[cfg(test)]
mod contract;
#[cfg(test)]
mod cut;
#[cfg(test)]
mod cut_error;
#[cfg(test)]
mod dark;
#[cfg(test)]
mod density;
#[cfg(test)]
mod dependencies;
#[cfg(test)]
mod detail;
#[cfg(test)]
mod direct;
#[cfg(test)]
mod documents;
#[cfg(test)]
mod drawing;
#[cfg(test)]
mod execute;
#[cfg(test)]
mod extreme;
#[cfg(test)]
mod footprint;
#[cfg(test)]
mod frame;
#[cfg(test)]
mod frames;
#[cfg(test)]
mod frontier;
#[cfg(test)]
mod function;
#[cfg(test)]
mod graph;
#[cfg(test)]
mod half;
#[cfg(test)]
mod host;
#[cfg(test)]
mod house;
#[cfg(test)]
mod identity;
#[cfg(test)]
mod input;
#[cfg(test)]
mod kernels;
#[cfg(test)]
mod metropolis;
#[cfg(test)]
mod mip;
#[cfg(test)]
mod moments;
#[cfg(test)]
mod numbers;
#[cfg(test)]
mod origin;
#[cfg(test)]
mod output;
#[cfg(test)]
mod overlay;
#[cfg(test)]
mod package;
#[cfg(test)]
mod part;
#[cfg(test)]
mod path;
#[cfg(test)]
mod plan;
#[cfg(test)]
mod pruning;
#[cfg(test)]
mod reliability;
#[cfg(test)]
mod several;
#[cfg(test)]
mod shade;
#[cfg(test)]
mod stress;
#[cfg(test)]
mod strict;
#[cfg(test)]
mod surface;
#[cfg(test)]
mod thin;
#[cfg(test)]
mod tile;
#[cfg(test)]
mod visibility;
