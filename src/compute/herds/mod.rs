//! Herds: from a photo to animals that walk.
