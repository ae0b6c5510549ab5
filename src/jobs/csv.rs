//! CSV tables in: RFC 4180, a header of names, commas, UTF-8.

use biotope_api::error::ErrorCode;
use serde_json::Map;
use serde_json::Number;
use serde_json::Value;

use crate::jobs::sources::SourceError;

/// The rows of a table as a list of objects by the names in its header. Cells that are numbers
/// become numbers, `true` and `false` become booleans, empty cells are left out, all others are
/// texts.
///
/// # Errors
/// When the bytes are no UTF-8, there is no header, or a row has another number of cells.
pub fn records(bytes: &[u8]) -> Result<Value, SourceError> {
    let malformed = |found: String| SourceError::new(ErrorCode::Malformed, "a CSV table with a header", found);
    let text = std::str::from_utf8(bytes).map_err(|error| malformed(error.to_string()))?;
    let mut rows = rows(text.trim_start_matches('\u{feff}')).map_err(|found| malformed(found.to_owned()))?.into_iter();
    let header = rows.next().ok_or_else(|| malformed("an empty text".to_owned()))?;
    let record = |(line, cells): (usize, Vec<String>)| {
        if cells.len() != header.len() {
            return Err(malformed(format!("{} cells in row {line}, {} in the header", cells.len(), header.len())));
        }
        let fields = header.iter().cloned().zip(cells).filter(|(_, cell)| !cell.is_empty());
        Ok(Value::Object(fields.map(|(name, cell)| (name, value(cell))).collect::<Map<_, _>>()))
    };
    (1..).zip(rows).map(record).collect()
}

fn value(cell: String) -> Value {
    let whole = cell.parse::<i64>().ok().map(Number::from);
    let number = || cell.parse::<f64>().ok().and_then(Number::from_f64);
    match (cell.as_str(), whole.or_else(number)) {
        ("true", _) => Value::Bool(true),
        ("false", _) => Value::Bool(false),
        (_, Some(number)) => Value::Number(number),
        _ => Value::String(cell),
    }
}

/// The cells of every line that is not empty.
fn rows(text: &str) -> Result<Vec<Vec<String>>, &'static str> {
    let (mut rows, mut row, mut cell) = (Vec::new(), Vec::new(), String::new());
    let mut letters = text.chars().peekable();
    let mut quoted = false;
    while let Some(letter) = letters.next() {
        match (letter, quoted) {
            ('"', true) if letters.peek() == Some(&'"') => cell.extend(letters.next()),
            ('"', true) => quoted = false,
            (_, true) => cell.push(letter),
            ('"', false) if cell.trim().is_empty() => {
                cell.clear();
                quoted = true;
            }
            (',', false) => row.push(trimmed(&mut cell)),
            ('\n', false) => {
                row.push(trimmed(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            (_, false) => cell.push(letter),
        }
    }
    if quoted {
        return Err("a quotation that does not end");
    }
    row.push(trimmed(&mut cell));
    rows.push(row);
    rows.retain(|row| row.iter().any(|cell| !cell.is_empty()));
    Ok(rows)
}

fn trimmed(cell: &mut String) -> String {
    std::mem::take(cell).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::Table;
    use serde_json::json;

    #[test]
    fn cells_become_what_they_look_like() {
        let text = "\u{feff}id,x,name,suspect,why\r\n1, 2.5 ,\"a, \"\"b\"\"\",true,\r\n\r\n2,-3e2,7a,false,x\n";
        let expected = json!([
            {"id": 1, "x": 2.5, "name": "a, \"b\"", "suspect": true},
            {"id": 2, "x": -300.0, "name": "7a", "suspect": false, "why": "x"},
        ]);
        assert_eq!(records(text.as_bytes()).unwrap(), expected);
    }

    #[test]
    fn what_a_table_writes_is_read_back() {
        let table = Table::new().integers("id", "", [3, 4]).texts("name", ["a\nb", "c"]).numbers("x", "m", [1.0, 0.1]);
        assert_eq!(records(table.csv().as_bytes()).unwrap(), table.records());
    }

    #[test]
    fn uneven_rows_and_open_quotations_are_named() {
        let found = |text: &str| records(text.as_bytes()).unwrap_err().found;
        assert_eq!(found("a,b\n1,2\n3\n"), "1 cells in row 2, 2 in the header");
        assert_eq!(found("a,b\n\"1,2\n"), "a quotation that does not end");
        assert_eq!(found(""), "an empty text");
        assert!(records(&[0xff, 0xfe]).is_err());
    }
}
