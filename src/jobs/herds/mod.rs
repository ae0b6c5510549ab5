//! What the three processes of herds share.

pub mod arrivals;
pub mod ellipses;
pub mod faults;
pub mod key_frames;
pub mod key_herd_outputs;
pub mod obstacles;
pub mod photo;
pub mod pictures;
pub mod scene;
pub mod scribbles;
pub mod site;
pub mod tie;
pub mod tracks;
pub mod walk_options;
