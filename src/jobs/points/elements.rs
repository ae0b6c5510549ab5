//! Elements in: a list, a reference to a JSON list, or a CSV table.

use biotope_api::error::ErrorCode;
use biotope_api::points::ElementInput;
use biotope_api::points::default_class;
use biotope_api::reference::Given;

use crate::compute::geometry::Point;
use crate::compute::pcf::Element;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::csv;
use crate::jobs::schema::read;
use crate::jobs::sources::Content;

/// The most elements a pattern may have.
pub const MAX_ELEMENTS: usize = 200_000;

/// Cells of a table that are no numbers, before the rest is not looked at.
const MOST_FAULTS: usize = 20;

/// Elements with the names of their classes.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// The elements; classes are places in `classes`.
    pub elements: Vec<Element>,
    /// The names, in the order in which they first occur.
    pub classes: Vec<String>,
}

impl Named {
    /// The name of a class.
    pub fn name(&self, class: usize) -> String {
        self.classes.get(class).cloned().unwrap_or_else(|| class.to_string())
    }
}

/// The elements given at `pointer`, their classes numbered after `classes`, new ones at the end.
///
/// # Errors
/// When nothing stands behind the reference, it is no list of elements, or it is too long.
pub fn open(
    given: &Given<Vec<ElementInput>>,
    pointer: &str,
    (mut classes, sources): (Vec<String>, &dyn Sources),
) -> Result<Named, Invalid> {
    let inputs = match given {
        Given::Value(list) => list.clone(),
        Given::Reference(reference) => {
            let source = sources.open(reference).map_err(|e| e.at(pointer))?;
            match &source.content {
                Content::Encoded { media_type, bytes } if media_type.contains("csv") => from_csv(bytes, pointer)?,
                _ => read(source.json().map_err(|e| e.at(pointer))?).map_err(|e| e.below(pointer))?,
            }
        }
    };
    if inputs.len() > MAX_ELEMENTS {
        let expected = format!("at most {MAX_ELEMENTS} elements");
        return Err(Invalid::new(pointer, ErrorCode::WrongCount, expected, inputs.len()));
    }
    let mut element = |input: ElementInput| {
        let class = classes.iter().position(|c| *c == input.class).unwrap_or_else(|| {
            classes.push(input.class.clone());
            classes.len() - 1
        });
        Element { centre: Point::new(input.x, input.y), radius: input.radius, class }
    };
    let elements = inputs.into_iter().map(&mut element).collect();
    Ok(Named { elements, classes })
}

/// The rows of a CSV table with the columns x and y, and radius and class where they are there.
/// Classes are texts, whatever they look like; a cell left empty is as if its column were not
/// there.
fn from_csv(bytes: &[u8], pointer: &str) -> Result<Vec<ElementInput>, Invalid> {
    let (header, rows) = csv::rows(bytes).map_err(|e| e.at(pointer))?;
    let column = |name: &str| header.iter().position(|c| c == name);
    let (Some(x), Some(y)) = (column("x"), column("y")) else {
        let found = header.iter().collect::<Vec<&str>>().join(",");
        return Err(Invalid::new(pointer, ErrorCode::Unreadable, "a CSV table with columns x,y", found));
    };
    let (radius, class) = (column("radius"), column("class"));
    let mut faults = Invalid::default();
    let mut elements = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let cell = |column: Option<usize>| column.and_then(|c| row.get(c)).filter(|cell| !cell.is_empty());
        let mut number = |cell: &str, name: &str| {
            cell.parse::<f64>().unwrap_or_else(|_| {
                faults.push(
                    format!("{pointer}/{i}/{name}"),
                    ErrorCode::WrongType,
                    "a number",
                    if cell.is_empty() { "an empty cell" } else { cell },
                );
                0.0
            })
        };
        elements.push(ElementInput {
            id: None,
            class: cell(class).map_or_else(default_class, str::to_owned),
            x: number(cell(Some(x)).unwrap_or_default(), "x"),
            y: number(cell(Some(y)).unwrap_or_default(), "y"),
            radius: cell(radius).map_or(0.0, |cell| number(cell, "radius")),
        });
        if faults.errors.len() >= MOST_FAULTS {
            break;
        }
    }
    faults.into_result().map(|()| elements)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::sources::ByValueOnly;
    use biotope_api::reference::Reference;

    fn opened(href: &str) -> Result<Named, Invalid> {
        open(&Given::Reference(Reference::to(href)), "/exemplar/elements", (Vec::new(), &ByValueOnly))
    }

    #[test]
    fn a_csv_table_and_a_json_list_are_read_alike() {
        let table = opened("data:text/csv,id,class,x,y,radius%0A1,tree,2,3,0.5%0A2,grass,4,5,0%0A").unwrap();
        let list = opened(
            "data:application/json,[{\"class\":\"tree\",\"x\":2,\"y\":3,\"radius\":0.5},{\"class\":\"grass\",\"x\":4,\"y\":5}]",
        )
        .unwrap();
        assert_eq!(table, list);
        assert_eq!(table.classes, ["tree", "grass"]);
    }

    #[test]
    fn a_cell_that_is_no_number_is_named() {
        let faults = opened("data:text/csv,x,y%0A1,two%0A").unwrap_err();
        assert_eq!(
            (faults.errors[0].pointer.as_str(), faults.errors[0].found.as_str()),
            ("/exemplar/elements/0/y", "two")
        );
        let empty = opened("data:text/csv,x,y%0A1,%0A").unwrap_err();
        assert_eq!(empty.errors[0].found, "an empty cell");
    }

    #[test]
    fn classes_are_texts_whatever_they_look_like() {
        let table =
            opened("data:text/csv,class,x,y%0A1,2,3%0A01,4,5%0Atrue,6,7%0A%22a%2C %22%22b%22%22%22,8,9%0A,1,1%0A")
                .unwrap();
        assert_eq!(table.classes, ["1", "01", "true", "a, \"b\"", &default_class()]);
    }

    #[test]
    fn a_table_without_places_or_with_a_short_row_is_refused() {
        let other = opened("data:text/csv,a,b%0A1,2%0A").unwrap_err();
        assert_eq!((other.errors[0].code.as_str(), other.errors[0].found.as_str()), ("unreadable", "a,b"));
        assert_eq!(opened("data:text/csv,x,y%0A1,2%0A3%0A").unwrap_err().errors[0].code, "malformed");
    }
}
