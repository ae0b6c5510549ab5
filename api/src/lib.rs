//! The wire types of Biotope: what a client sends and receives.
//!
//! Rules of the contract. Lengths are in metres, angles in radians counter-clockwise from east,
//! times in seconds of the local solar day, unless the name says otherwise; every quantity
//! carries its unit in its name. x is east, y is north, z is up; rasters are row-major, first row
//! north, values at cell centres. This crate holds types and their (de)serialisation only.
