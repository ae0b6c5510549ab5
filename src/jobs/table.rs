//! A table: columns of equal length, each with a name and a unit.

use serde::Deserialize;
use serde::Serialize;
use serde_json::Map;
use serde_json::Value;

/// A table. Kept by column; handed back as JSON records or as CSV.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Table {
    /// The columns, in order.
    pub columns: Vec<Column>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Its name: the header in CSV, the field in JSON.
    pub name: String,
    /// Unit of its values; empty when there is none.
    pub unit: String,
    /// Its values.
    pub values: Values,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Values {
    /// Texts.
    Text(Vec<String>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Numbers; one that is not finite is an empty cell.
    Number(#[serde(deserialize_with = "numbers_or_null")] Vec<f64>),
    /// Yes or no.
    Flag(Vec<bool>),
}

/// JSON has no NaN: it is written as null.
fn numbers_or_null<'de, D: serde::Deserializer<'de>>(input: D) -> Result<Vec<f64>, D::Error> {
    let cells = Vec::<Option<f64>>::deserialize(input)?;
    Ok(cells.into_iter().map(|cell| cell.unwrap_or(f64::NAN)).collect())
}

impl Values {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Text(v) => v.len(),
            Self::Integer(v) => v.len(),
            Self::Number(v) => v.len(),
            Self::Flag(v) => v.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value in `row` as JSON.
    pub fn json(&self, row: usize) -> Value {
        match self {
            Self::Text(v) => Value::from(v[row].as_str()),
            Self::Integer(v) => Value::from(v[row]),
            Self::Number(v) => Value::from(v[row]),
            Self::Flag(v) => Value::from(v[row]),
        }
    }

    /// The value in `row` as a text, empty for no value. A number always has its decimal point
    /// or exponent, so that tools which type a column by its first row read it as one.
    pub fn text(&self, row: usize) -> String {
        match self {
            Self::Text(v) => v[row].clone(),
            Self::Integer(v) => v[row].to_string(),
            Self::Number(v) if v[row].is_finite() => format!("{:?}", v[row]),
            Self::Number(_) => String::new(),
            Self::Flag(v) => v[row].to_string(),
        }
    }

    /// Whether the values are numbers.
    pub const fn is_numeric(&self) -> bool {
        matches!(self, Self::Integer(_) | Self::Number(_))
    }
}

impl Table {
    /// A table without columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column of texts.
    pub fn texts<S: Into<String>>(self, name: &str, values: impl IntoIterator<Item = S>) -> Self {
        self.column(name, "", Values::Text(values.into_iter().map(Into::into).collect()))
    }

    /// Adds a column of whole numbers in `unit`.
    pub fn integers(self, name: &str, unit: &str, values: impl IntoIterator<Item = i64>) -> Self {
        self.column(name, unit, Values::Integer(values.into_iter().collect()))
    }

    /// Adds a column of numbers in `unit`.
    pub fn numbers(self, name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> Self {
        self.column(name, unit, Values::Number(values.into_iter().collect()))
    }

    /// Adds a column of yes or no.
    pub fn flags(self, name: &str, values: impl IntoIterator<Item = bool>) -> Self {
        self.column(name, "", Values::Flag(values.into_iter().collect()))
    }

    fn column(mut self, name: &str, unit: &str, values: Values) -> Self {
        self.columns.push(Column { name: name.to_owned(), unit: unit.to_owned(), values });
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Whether all columns have the same number of rows.
    pub fn is_even(&self) -> bool {
        self.columns.iter().all(|column| column.values.len() == self.rows())
    }

    /// One JSON object a row.
    pub fn records(&self) -> Value {
        let record = |row| {
            let fields = self.columns.iter().map(|column| (column.name.clone(), column.values.json(row)));
            Value::Object(Map::from_iter(fields))
        };
        Value::Array((0..self.rows()).map(record).collect())
    }

    /// CSV (RFC 4180 with plain line feeds): a header of names, then one line a row.
    pub fn csv(&self) -> String {
        let mut out = String::new();
        let mut line = |cells: &mut dyn Iterator<Item = String>| {
            out.push_str(&cells.map(|cell| quoted(&cell)).collect::<Vec<_>>().join(","));
            out.push('\n');
        };
        line(&mut self.columns.iter().map(|column| column.name.clone()));
        for row in 0..self.rows() {
            line(&mut self.columns.iter().map(|column| column.values.text(row)));
        }
        out
    }
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn herds() -> Table {
        Table::new()
            .integers("herd", "", [0, 1])
            .texts("species", ["Bison, \"priscus\"", "Ovis ammon"])
            .numbers("x", "m", [0.5, f64::NAN])
            .flags("asleep", [true, false])
    }

    #[test]
    fn csv_quotes_what_it_must_and_leaves_cells_without_a_value_empty() {
        let csv = "herd,species,x,asleep\n0,\"Bison, \"\"priscus\"\"\",0.5,true\n1,Ovis ammon,,false\n";
        assert_eq!(herds().csv(), csv);
    }

    #[test]
    fn records_carry_the_names_of_the_columns() {
        let expected = r#"[{"herd":0,"species":"Bison, \"priscus\"","x":0.5,"asleep":true},{"herd":1,"species":"Ovis ammon","x":null,"asleep":false}]"#;
        assert_eq!(herds().records().to_string(), expected);
    }

    #[test]
    fn a_stored_table_reads_back_with_its_gaps() {
        let text = serde_json::to_string(&herds()).unwrap();
        let back: Table = serde_json::from_str(&text).unwrap();
        assert!(herds().is_even());
        assert_eq!(back.csv(), herds().csv());
    }
}
