//! Herds: from a photo to animals that walk (T chapter 4, H).
//!
//! | stage | from | to |
//! |---|---|---|
//! | [`extraction`] | a photo and a few scribbles | an ellipse per animal |

pub mod extraction;
