//! Bytes to compute values and back: every format that comes in or goes out.
//!
//! | file | holds |
//! |---|---|
//! | [`map`] | a map with its legend: the compact form it is stored in, GeoTIFF, picture |
//! | [`binary`] | the compact form of everything else that is stored between stages |
//! | [`colours`] | colour maps |
//! | [`draw`] | a canvas with lines, shapes, text and plots |
//! | [`sheet`] | a raster as it stands in a file, in any format |
//! | [`terrain`] | a height map comes in: metres on square cells |
//! | [`mask`] | painted masks, densities and maps that belong to a terrain |
//! | [`picture`] | photos in, PNG and animated PNG out |
//! | [`tracks`] | tracks of a herd as columns, Moving Features and glTF |
//!
//! Nothing here knows of storage, jobs or HTTP. Whatever comes in may be hostile: sizes are
//! checked from the header before anything is allocated, and every error is a value that says
//! what was expected and what was found.

pub mod binary;
mod blocks;
pub mod colours;
pub mod draw;
pub mod map;
pub mod mask;
pub mod picture;
pub mod sheet;
pub mod terrain;
pub mod tracks;
pub mod warning;
