//! The wire types of Biotope: what a client sends and receives.
//!
//! Rules of the contract. Lengths are in metres, angles in radians counter-clockwise from east,
//! times in seconds of the local solar day, unless the name says otherwise; every quantity
//! carries its unit in its name. x is east, y is north, z is up; rasters are row-major, first row
//! north, values at cell centres. This crate holds types and their (de)serialisation only.
//!
//! | module | holds |
//! |---|---|
//! | [`error`] | every error code with its status and meaning, and the problem document |
//! | [`warning`] | every warning code, and a warning |
//! | [`link`], [`job`], [`process`], [`execute`], [`asset`] | the resources of OGC API – Processes |
//! | [`mod@reference`] | an input given by value or by reference |
//! | [`echo`] and the others | one module a process: its inputs, and outputs that are documents |

pub mod asset;
pub mod echo;
pub mod ecosystem;
pub mod error;
pub mod execute;
pub mod herds;
pub mod job;
pub mod link;
pub mod points;
pub mod process;
pub mod reference;
pub mod warning;
