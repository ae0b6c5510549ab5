//! Documents and tables as HTML.

use serde_json::Value;

use crate::http::pages::esc;
use crate::jobs::Table;

/// Rows of a table that are shown at once.
const ROWS: usize = 200;
/// Entries of a list that are shown on one line.
const ITEMS: usize = 24;
/// Texts longer than this get a broad column.
const LONG: usize = 60;
/// Most columns of a table.
const COLUMNS: usize = 24;

/// A table with the units of its columns.
pub fn table(table: &Table) -> String {
    let class = |numeric: bool| if numeric { r#" class="number""# } else { "" };
    let head: String = table
        .columns
        .iter()
        .map(|column| {
            let unit =
                if column.unit.is_empty() { String::new() } else { format!(" <small>{}</small>", esc(&column.unit)) };
            format!("<th{}>{}{unit}</th>", class(column.values.is_numeric()), breakable(&column.name))
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
    format!(r#"<div class="scroll fit"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{more}"#)
}

/// A document: its plain fields as a table of names and values, each of the others under a
/// heading of its own.
pub fn json(value: &Value) -> String {
    let Value::Object(fields) = value else { return part(value) };
    let (plain, nested): (Vec<_>, Vec<_>) = fields.iter().partition(|(_, field)| !is_nested(field));
    let table = if plain.is_empty() && !nested.is_empty() { String::new() } else { pairs(plain) };
    let parts = nested.into_iter().map(|(name, field)| format!("<h3>{}</h3>{}", esc(name), part(field)));
    parts.fold(table, |page, part| page + &part)
}

/// A list of objects as a table, an object as a table of names and values, anything else in line.
fn part(value: &Value) -> String {
    match value {
        Value::Object(fields) if !fields.is_empty() => pairs(fields.iter()),
        Value::Array(items) => match columns(items) {
            Some(names) => records(&names, items),
            None => format!("<p>{}</p>", inline(value)),
        },
        value => format!("<p>{}</p>", inline(value)),
    }
}

fn pairs<'a>(fields: impl IntoIterator<Item = (&'a String, &'a Value)>) -> String {
    let row = |(name, value): (&String, &Value)| format!("<tr><th>{}</th>{}</tr>", esc(name), cell(value));
    let rows: String = fields.into_iter().map(row).collect();
    format!(r#"<div class="scroll fit"><table><tbody>{rows}</tbody></table></div>"#)
}

/// The names of the fields of a list of objects, in the order in which they are met; `None` when
/// it is not such a list, or one of too many fields.
fn columns(items: &[Value]) -> Option<Vec<&String>> {
    let mut names: Vec<&String> = Vec::new();
    for item in items.iter().take(ROWS) {
        let new = item.as_object()?.keys().filter(|name| !names.contains(name)).collect::<Vec<_>>();
        names.extend(new);
    }
    (1..=COLUMNS).contains(&names.len()).then_some(names)
}

fn records(names: &[&String], items: &[Value]) -> String {
    let is_number =
        |name: &String| items.iter().all(|item| item.get(name).is_none_or(|v| v.is_number() || v.is_null()));
    let head = |name: &&String| {
        let class = if is_number(name) { r#" class="number""# } else { "" };
        format!("<th{class}>{}</th>", breakable(name))
    };
    let row = |item: &Value| {
        let cells: String = names.iter().map(|name| cell(item.get(name.as_str()).unwrap_or(&Value::Null))).collect();
        format!("<tr>{cells}</tr>")
    };
    let head: String = names.iter().map(head).collect();
    let rows: String = items.iter().take(ROWS).map(row).collect();
    let more = more(items.len(), ROWS);
    format!(r#"<div class="scroll fit"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{more}"#)
}

/// The name of a column, which may be broken after its underscores.
fn breakable(name: &str) -> String {
    esc(name).replace('_', "_<wbr>")
}

fn cell(value: &Value) -> String {
    let class = if value.is_number() { r#" class="number""# } else { "" };
    let text = inline(value);
    if text.len() > LONG {
        format!(r#"<td><div class="long">{text}</div></td>"#)
    } else {
        format!("<td{class}>{text}</td>")
    }
}

fn is_nested(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().any(|item| item.is_object() || item.is_array()),
        Value::Object(fields) => !fields.is_empty(),
        _ => false,
    }
}

/// A value on one line.
fn inline(value: &Value) -> String {
    let shortened = |parts: Vec<String>, all: usize| {
        let more = if all > ITEMS { format!(", … and {} more", all - ITEMS) } else { String::new() };
        format!("{}{more}", parts.join(", "))
    };
    match value {
        Value::Object(fields) if fields.is_empty() => r#"<span class="soft">none</span>"#.into(),
        Value::Array(items) if items.is_empty() => r#"<span class="soft">none</span>"#.into(),
        Value::Array(items) => shortened(items.iter().take(ITEMS).map(inline).collect(), items.len()),
        Value::Object(fields) => {
            let pair = |(name, value): (&String, &Value)| format!("{} {}", esc(name), inline(value));
            shortened(fields.iter().take(ITEMS).map(pair).collect(), fields.len())
        }
        plain => scalar(plain),
    }
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
        Some(x) if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e15) => format!("{x:.2e}"),
        Some(x) => {
            let digits = match x.abs() {
                _ if value.is_i64() || value.is_u64() => 0,
                1e3.. => 0,
                1e2.. => 1,
                _ => 3,
            };
            let text = format!("{x:.digits$}");
            let text = if digits > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
            grouped(text)
        }
        None => String::new(),
    }
}

/// Digits before the point in groups of three, from five digits on.
fn grouped(text: &str) -> String {
    let (whole, part) = text.split_once('.').map_or((text, None), |(whole, part)| (whole, Some(part)));
    let digits = whole.trim_start_matches('-');
    let mut out = String::from(if whole.starts_with('-') { "−" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && digits.len() > 4 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    part.map_or(out.clone(), |part| format!("{out}.{part}"))
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
            [(json!(3), "3"), (json!(0.5), "0.5"), (json!(234.567), "234.6"), (json!(1e-9), "1.00e-9")]
        {
            assert_eq!(number(&value), shown);
        }
        assert_eq!(number(&json!(-1_234_567.8)), "−1\u{202f}234\u{202f}568");
    }

    #[test]
    fn a_list_of_like_objects_becomes_a_table() {
        let page = json(&json!([{"a": 1, "b": 2}, {"a": 3, "b": 4}]));
        assert_eq!(page.matches("<tr>").count(), 3);
    }
}
