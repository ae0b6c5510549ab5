//! Herds: from a photo to animals that walk (T chapter 4, H).
//!
//! | stage | from | to |
//! |---|---|---|
//! | [`extraction`] | a photo and a few scribbles | an ellipse per animal |
//! | [`key_herd`] | those ellipses | any number of animals on the ground that look alike |
//! | [`animation`] | key-herds along a path | a track per animal |
//!
//! [`Obstacles`] and their [`Clearance`], and how deep two animals overlap ([`contact`]), serve
//! the stages on the ground.

pub mod animation;
pub mod contact;
pub mod extraction;
pub mod key_herd;
mod obstacles;

pub use obstacles::Clearance;
pub use obstacles::Obstacles;
