//! Ellipses on the wire and as a table.

use biotope_api::error::ErrorCode;
use biotope_api::herds::EllipseInput;

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::jobs::Invalid;
use crate::jobs::Table;

/// An ellipse of the wire.
pub fn ellipse(input: &EllipseInput) -> Ellipse {
    Ellipse { centre: Point::new(input.x, input.y), a: input.a, b: input.b, theta: input.theta }
}

/// A list of ellipses.
///
/// # Errors
/// Those that are none.
pub fn ellipses(inputs: &[EllipseInput], pointer: &str) -> Result<Vec<Ellipse>, Invalid> {
    let mut faults = Invalid::default();
    let all: Vec<Ellipse> = inputs.iter().map(ellipse).collect();
    for (i, e) in all.iter().enumerate().filter(|(_, e)| !e.is_valid()) {
        faults.push(
            format!("{pointer}/{i}"),
            ErrorCode::NotAnEllipse,
            "axes a ≥ b > 0",
            format!("a = {}, b = {}", e.a, e.b),
        );
    }
    faults.into_result().map(|()| all)
}

/// An animal of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its number.
    pub id: u64,
    /// Its outline.
    pub ellipse: Ellipse,
    /// Why it may not be one animal; empty when nothing speaks against it.
    pub why: String,
}

/// The table `ellipses`: id, x, y, a, b, theta, suspect and why, lengths in `unit`.
pub fn table(rows: &[Row], unit: &str) -> Table {
    Table::new()
        .integers("id", "", rows.iter().map(|r| r.id as i64))
        .numbers("x", unit, rows.iter().map(|r| r.ellipse.centre.x))
        .numbers("y", unit, rows.iter().map(|r| r.ellipse.centre.y))
        .numbers("a", unit, rows.iter().map(|r| r.ellipse.a))
        .numbers("b", unit, rows.iter().map(|r| r.ellipse.b))
        .numbers("theta", "rad", rows.iter().map(|r| r.ellipse.theta))
        .flags("suspect", rows.iter().map(|r| !r.why.is_empty()))
        .texts("why", rows.iter().map(|r| r.why.as_str()))
}
