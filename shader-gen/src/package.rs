//! A package: the files of a set of variants, written beside their place and renamed.
