//! What the three processes of herds share.

pub mod ellipses;
pub mod faults;
pub mod photo;
pub mod pictures;
pub mod scribbles;
