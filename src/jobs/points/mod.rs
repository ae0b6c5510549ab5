//! What the four processes on arrangements share: elements and domains in, faults, documents and
//! pictures out.

pub mod documents;
pub mod elements;
pub mod exemplar;
pub mod faults;
pub mod pictures;
pub mod regions;
pub mod synthesis;
