//! Documents and tables as HTML.

use serde_json::Map;
use serde_json::Value;

use crate::http::pages::esc;
use crate::jobs::Table;

/// Rows of a table that are shown at once.
const ROWS: usize = 200;
/// Entries of a list that are shown at once.
const ITEMS: usize = 60;

/// A table with the units of its columns.
pub fn table(table: &Table) -> String {
    let class = |numeric: bool| if numeric { r#" class="number""# } else { "" };
    let head: String = table
        .columns
        .iter()
        .map(|column| {
            let unit =
                if column.unit.is_empty() { String::new() } else { format!(" <small>{}</small>", esc(&column.unit)) };
            format!("<th{}>{}{unit}</th>", class(column.values.is_numeric()), esc(&column.name))
        })
        .collect();
    let row = |row: usize| -> String {
        let cell = |column: &crate::jobs::table::Column| {
            let value = if column.values.is_numeric() {
                number(&column.values.json(row))
            } else {
                esc(&column.values.text(row))
            };
            format!("<td{}>{value}</td>", class(column.values.is_numeric()))
        };
        format!("<tr>{}</tr>", table.columns.iter().map(cell).collect::<String>())
    };
    let rows: String = (0..table.rows().min(ROWS)).map(row).collect();
    let more = match table.rows().checked_sub(ROWS) {
        Some(more) if more > 0 => format!(r#"<p class="soft">… and {more} rows more</p>"#),
        _ => String::new(),
    };
    format!(r#"<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{more}"#)
}

/// A document: objects as tables of names and values, lists of like objects as tables.
pub fn json(value: &Value) -> String {
    match value {
        Value::Object(fields) if fields.is_empty() => r#"<span class="soft">none</span>"#.into(),
        Value::Array(items) if items.is_empty() => r#"<span class="soft">none</span>"#.into(),
        Value::Object(fields) => object(fields),
        Value::Array(items) => match columns(items) {
            Some(names) => records(&names, items),
            None => list(items),
        },
        scalar => self::scalar(scalar),
    }
}

fn object(fields: &Map<String, Value>) -> String {
    let row = |(name, value): (&String, &Value)| format!("<tr><th>{}</th><td>{}</td></tr>", esc(name), json(value));
    let rows: String = fields.iter().map(row).collect();
    format!(r#"<div class="scroll"><table><tbody>{rows}</tbody></table></div>"#)
}

/// The names that all of the objects of a list share with the first; `None` when it is not a
/// list of like objects of few fields.
fn columns(items: &[Value]) -> Option<Vec<&String>> {
    let first = items.first()?.as_object().filter(|first| (1..=12).contains(&first.len()))?;
    let alike = |item: &Value| item.as_object().is_some_and(|item| item.keys().eq(first.keys()));
    (items.len() > 1 && items.iter().all(alike)).then(|| first.keys().collect())
}

fn records(names: &[&String], items: &[Value]) -> String {
    let head: String = names.iter().map(|name| format!("<th>{}</th>", esc(name))).collect();
    let cell = |value: &Value| {
        let class = if value.is_number() { r#" class="number""# } else { "" };
        format!("<td{class}>{}</td>", json(value))
    };
    let row = |item: &Value| {
        let cells: String = item.as_object().into_iter().flat_map(|fields| fields.values()).map(cell).collect();
        format!("<tr>{cells}</tr>")
    };
    let rows: String = items.iter().take(ROWS).map(row).collect();
    let more = more(items.len(), ROWS);
    format!(r#"<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{more}"#)
}

fn list(items: &[Value]) -> String {
    let short = items.iter().all(|item| !item.is_object() && !item.is_array());
    let shown = items.iter().take(ITEMS).map(json);
    let text = if short { shown.collect::<Vec<_>>().join(", ") } else { shown.collect() };
    format!("{text}{}", more(items.len(), ITEMS))
}

fn more(all: usize, shown: usize) -> String {
    if all > shown { format!(r#"<p class="soft">… and {} more</p>"#, all - shown) } else { String::new() }
}

fn scalar(value: &Value) -> String {
    match value {
        Value::String(text) => esc(text),
        Value::Null => r#"<span class="soft">–</span>"#.into(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.into(),
        number => self::number(number),
    }
}

/// A number with as many digits as help a reader.
fn number(value: &Value) -> String {
    match value.as_f64() {
        _ if value.is_i64() || value.is_u64() => value.to_string(),
        Some(x) if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e7) => format!("{x:.3e}"),
        Some(x) => {
            let digits = if x.abs() >= 100.0 { 1 } else { 3 };
            let text = format!("{x:.digits$}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn nothing_a_client_sent_becomes_a_tag() {
        let page = json(&json!({"<b>": "<script>alert(1)</script>", "list": ["\"<i>"]}));
        assert!(!page.contains("<script>") && !page.contains("<b>") && !page.contains("<i>"));
    }

    #[test]
    fn numbers_are_shown_with_the_digits_that_help() {
        for (value, shown) in
            [(json!(3), "3"), (json!(0.5), "0.5"), (json!(1234.567), "1234.6"), (json!(1e-9), "1.000e-9")]
        {
            assert_eq!(number(&value), shown);
        }
    }

    #[test]
    fn a_list_of_like_objects_becomes_a_table() {
        let page = json(&json!([{"a": 1, "b": 2}, {"a": 3, "b": 4}]));
        assert_eq!(page.matches("<tr>").count(), 3);
    }
}
