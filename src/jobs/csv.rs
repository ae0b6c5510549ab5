//! CSV tables in: RFC 4180, a header of names, commas, UTF-8.

use biotope_api::error::ErrorCode;
use serde_json::Map;
use serde_json::Number;
use serde_json::Value;

use crate::jobs::sources::SourceError;

/// The names in the header of a table, and its rows, each of as many cells.
pub type Rows = (csv::StringRecord, Vec<csv::StringRecord>);

/// The cells of a table as they stand there.
///
/// # Errors
/// When the bytes are no UTF-8, there is no header, or a row has another number of cells.
pub fn rows(bytes: &[u8]) -> Result<Rows, SourceError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers().map_err(|error| malformed(error.to_string()))?.clone();
    if header.is_empty() {
        return Err(malformed("an empty text".to_owned()));
    }
    let rows = reader.into_records().map(|row| row.map_err(|error| malformed(error.to_string())));
    Ok((header, rows.collect::<Result<_, _>>()?))
}

/// The rows of a table as a list of objects by the names in its header. Cells that are numbers
/// become numbers, `true` and `false` become booleans, empty cells are left out, all others are
/// texts.
///
/// # Errors
/// As [`rows`].
pub fn records(bytes: &[u8]) -> Result<Value, SourceError> {
    let (header, rows) = rows(bytes)?;
    Ok(rows.iter().map(|row| record(&header, row)).collect())
}

fn malformed(found: String) -> SourceError {
    SourceError::new(ErrorCode::Malformed, "a CSV table with a header", found)
}

fn record(header: &csv::StringRecord, row: &csv::StringRecord) -> Value {
    let fields = header.iter().zip(row).filter(|(_, cell)| !cell.is_empty());
    Value::Object(fields.map(|(name, cell)| (name.to_owned(), value(cell))).collect::<Map<_, _>>())
}

fn value(cell: &str) -> Value {
    let whole = cell.parse::<i64>().ok().map(Number::from);
    let number = || cell.parse::<f64>().ok().and_then(Number::from_f64);
    match (cell, whole.or_else(number)) {
        ("true", _) => Value::Bool(true),
        ("false", _) => Value::Bool(false),
        (_, Some(number)) => Value::Number(number),
        _ => Value::from(cell),
    }
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
    fn what_is_no_table_is_refused_with_its_reason() {
        let found = |text: &str| records(text.as_bytes()).unwrap_err().found;
        assert!(found("a,b\n1,2\n3\n").contains("line: 3"), "{}", found("a,b\n1,2\n3\n"));
        assert!(found("a,b\n\"1,2\n").contains("1 fields"), "{}", found("a,b\n\"1,2\n"));
        assert_eq!(found(""), "an empty text");
        assert!(records(&[0xff, 0xfe]).is_err());
    }
}
