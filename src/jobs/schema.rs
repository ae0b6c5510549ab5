//! Inputs against their JSON schema: every fault at once, each with its pointer.

use biotope_api::error::ErrorCode;
use jsonschema::ValidationError;
use jsonschema::Validator;
use jsonschema::error::ValidationErrorKind;
use schemars::Schema;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::jobs::Invalid;
use crate::jobs::invalid::shown;

/// Most faults reported of one request.
const FAULT_LIMIT: usize = 100;

/// A schema ready to check values with.
pub struct InputCheck(Validator);

impl InputCheck {
    /// Makes `schema` ready.
    ///
    /// # Errors
    /// When it is not a schema; the text says why.
    pub fn new(schema: &Schema) -> Result<Self, String> {
        jsonschema::validator_for(schema.as_value()).map(Self).map_err(|error| error.to_string())
    }

    /// Checks `inputs`.
    ///
    /// # Errors
    /// Every fault, with pointers relative to the inputs.
    pub fn check(&self, inputs: &Value) -> Result<(), Invalid> {
        let mut faults = Invalid::default();
        for error in self.0.iter_errors(inputs).take(FAULT_LIMIT) {
            report(&error, "", &mut faults);
        }
        faults.into_result()
    }
}

/// Reads inputs that fit their schema into their type. Whole numbers written with a point
/// (`3.0`) are whole numbers in JSON schema, so they are read as such.
///
/// # Errors
/// When the type refuses what the schema allowed; one fault for the inputs as a whole.
pub fn read<T: DeserializeOwned>(mut inputs: Value) -> Result<T, Invalid> {
    whole_numbers(&mut inputs);
    serde_json::from_value(inputs)
        .map_err(|error| Invalid::new("", ErrorCode::Mismatch, "inputs as the process describes them", error))
}

fn whole_numbers(value: &mut Value) {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match value {
        Value::Array(items) => items.iter_mut().for_each(whole_numbers),
        Value::Object(fields) => fields.values_mut().for_each(whole_numbers),
        Value::Number(number) if number.is_f64() => {
            if let Some(x) = number.as_f64().filter(|x| x.fract() == 0.0 && x.abs() <= EXACT) {
                *value = Value::from(x as i64);
            }
        }
        _ => {}
    }
}

/// Adds what `error` says, in our words, with pointers below `base`.
fn report(error: &ValidationError<'_>, base: &str, faults: &mut Invalid) {
    use ValidationErrorKind as K;
    let pointer = format!("{base}{}", error.instance_path());
    let found = shown(error.instance());
    let mut fault = |code, expected: String| faults.push(pointer.clone(), code, expected, &found);
    match error.kind() {
        K::Required { property } => {
            let field = property.as_str().unwrap_or_default();
            faults.push(format!("{pointer}/{}", escaped(field)), ErrorCode::Missing, "a value", "nothing");
        }
        K::AdditionalProperties { unexpected } | K::UnevaluatedProperties { unexpected } => {
            for field in unexpected {
                faults.push(format!("{pointer}/{}", escaped(field)), ErrorCode::UnknownField, "no such field", field);
            }
        }
        K::Type { kind } => fault(ErrorCode::WrongType, type_names(kind)),
        K::Minimum { limit } => fault(ErrorCode::OutOfRange, format!("at least {limit}")),
        K::Maximum { limit } => fault(ErrorCode::OutOfRange, format!("at most {limit}")),
        K::ExclusiveMinimum { limit } => fault(ErrorCode::OutOfRange, format!("more than {limit}")),
        K::ExclusiveMaximum { limit } => fault(ErrorCode::OutOfRange, format!("less than {limit}")),
        K::MultipleOf { multiple_of } => fault(ErrorCode::OutOfRange, format!("a multiple of {multiple_of}")),
        K::MinItems { limit } => fault(ErrorCode::WrongCount, format!("at least {limit} items")),
        K::MaxItems { limit } => fault(ErrorCode::WrongCount, format!("at most {limit} items")),
        K::MinLength { limit } => fault(ErrorCode::WrongCount, format!("at least {limit} characters")),
        K::MaxLength { limit } => fault(ErrorCode::WrongCount, format!("at most {limit} characters")),
        K::MinProperties { limit } => fault(ErrorCode::WrongCount, format!("at least {limit} fields")),
        K::MaxProperties { limit } => fault(ErrorCode::WrongCount, format!("at most {limit} fields")),
        K::Enum { options } => fault(ErrorCode::NotOneOf, format!("one of {options}")),
        K::Constant { expected_value } => fault(ErrorCode::NotOneOf, expected_value.to_string()),
        K::Pattern { pattern } => fault(ErrorCode::Malformed, format!("a text of the form {pattern}")),
        K::Format { format } => fault(ErrorCode::Malformed, format!("a text of the format {format}")),
        K::AnyOf { context } | K::OneOfNotValid { context } => report_nearest(context, &pointer, &found, faults),
        _ => fault(ErrorCode::Mismatch, error.to_string()),
    }
}

/// Of several forms that all failed, reports the faults of the one that was meant: the value is of
/// its JSON type, it has its fixed words, such as the name of a variant, and the fewest faults were
/// found. Where none has, all the words there are; where none is of the type, that no form fits.
fn report_nearest(forms: &[Vec<ValidationError<'static>>], pointer: &str, found: &str, faults: &mut Invalid) {
    let near: Vec<_> =
        forms.iter().filter(|errors| !errors.iter().any(|error| is_of_another_type(error, pointer))).collect();
    let words: Vec<_> = near.iter().filter_map(|errors| errors.iter().find_map(word)).collect();
    if let [(place, _, found), _, ..] = words.as_slice()
        && words.len() == near.len()
        && words.iter().all(|(other, ..)| other == place)
    {
        let all: Vec<&str> = words.iter().map(|(_, word, _)| word.as_str()).collect();
        return faults.push(place.clone(), ErrorCode::NotOneOf, format!("one of {}", all.join(", ")), found);
    }
    let meant = near.iter().min_by_key(|errors| (errors.iter().any(|error| word(error).is_some()), errors.len()));
    match meant {
        Some(errors) => errors.iter().for_each(|error| report(error, "", faults)),
        None => faults.push(pointer, ErrorCode::Mismatch, "one of the forms described", found),
    }
}

/// The fixed word that a form asks for, where, and what is there instead.
fn word(error: &ValidationError<'_>) -> Option<(String, String, String)> {
    let ValidationErrorKind::Constant { expected_value } = error.kind() else { return None };
    Some((error.instance_path().to_string(), expected_value.to_string(), shown(error.instance())))
}

/// Whether the value at `pointer` as a whole is of another JSON type than the form asks for.
fn is_of_another_type(error: &ValidationError<'_>, pointer: &str) -> bool {
    error.instance_path().as_str().len() <= pointer.len()
        && match error.kind() {
            ValidationErrorKind::Type { .. } => true,
            ValidationErrorKind::AnyOf { context } | ValidationErrorKind::OneOfNotValid { context } => {
                context.iter().all(|form| form.iter().any(|error| is_of_another_type(error, pointer)))
            }
            _ => false,
        }
}

fn type_names(kind: &jsonschema::error::TypeKind) -> String {
    use jsonschema::error::TypeKind;
    match kind {
        TypeKind::Single(one) => format!("a value of type {one}"),
        TypeKind::Multiple(several) => {
            let names: Vec<_> = several.iter().map(|one| one.to_string()).collect();
            format!("a value of type {}", names.join(" or "))
        }
    }
}

fn escaped(field: &str) -> String {
    field.replace('~', "~0").replace('/', "~1")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::process::inputs_schema;
    use biotope_api::reference::Given;
    use biotope_api::reference::Reference;
    use schemars::JsonSchema;
    use serde::Deserialize;
    use serde_json::json;

    #[derive(Debug, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only its schema is looked at")]
    struct Inputs {
        terrain: Reference,
        path: Option<Given<Vec<Point>>>,
        #[schemars(range(min = 1, max = 9))]
        count: Option<u64>,
        shape: Option<Shape>,
    }

    #[derive(Debug, Deserialize, JsonSchema)]
    #[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
    #[expect(dead_code, reason = "only its schema is looked at")]
    enum Shape {
        /// A point.
        Dot,
        /// Round.
        Disk { radius: f64, filled: bool },
        /// Even.
        Square { side: f64 },
    }

    #[derive(Debug, Deserialize, JsonSchema)]
    #[expect(dead_code, reason = "only its schema is looked at")]
    struct Point {
        x: f64,
        y: f64,
    }

    fn faults(inputs: Value) -> Vec<(String, String)> {
        let check = InputCheck::new(&inputs_schema::<Inputs>()).unwrap();
        let found = check.check(&inputs).err().unwrap_or_default();
        found.errors.into_iter().map(|e| (e.pointer, e.code)).collect()
    }

    fn fault(pointer: &str, code: &str) -> (String, String) {
        (pointer.to_owned(), code.to_owned())
    }

    #[test]
    fn all_faults_are_found_at_once_each_with_its_place() {
        let found = faults(json!({"count": 10, "colour": "red"}));
        assert_eq!(found.len(), 3, "{found:?}");
        for expected in
            [fault("/terrain", "missing"), fault("/count", "out-of-range"), fault("/colour", "unknown-field")]
        {
            assert!(found.contains(&expected), "{expected:?} in {found:?}");
        }
    }

    #[test]
    fn of_several_forms_the_nearest_is_reported() {
        let terrain = json!({"href": "/assets/x"});
        assert_eq!(faults(json!({"terrain": terrain, "path": [{"x": 1, "y": 2}]})), []);
        let found = faults(json!({"terrain": terrain, "path": [{"x": 1, "y": "two"}, {"x": 1}]}));
        assert_eq!(found, [fault("/path/0/y", "wrong-type"), fault("/path/1/y", "missing")]);
        assert_eq!(faults(json!({"terrain": 5})), [fault("/terrain", "mismatch")]);
    }

    #[test]
    fn of_several_variants_the_one_that_is_named_is_reported() {
        let of = |shape: Value| faults(json!({"terrain": {"href": "/assets/x"}, "shape": shape}));
        assert_eq!(of(json!({"type": "disk", "radius": 2, "filled": true})), []);
        assert_eq!(of(json!({"type": "disk"})), [fault("/shape/radius", "missing"), fault("/shape/filled", "missing")]);
        assert_eq!(of(json!({"type": "square", "side": "long"})), [fault("/shape/side", "wrong-type")]);
        let check = InputCheck::new(&inputs_schema::<Inputs>()).unwrap();
        let blob = json!({"terrain": {"href": "/assets/x"}, "shape": {"type": "blob", "side": 3}});
        let found = check.check(&blob).unwrap_err().errors;
        assert_eq!((found.len(), found[0].pointer.as_str(), found[0].code.as_str()), (1, "/shape/type", "not-one-of"));
        assert_eq!(found[0].expected, r#"one of "dot", "disk", "square""#);
        assert_eq!(found[0].found, r#""blob""#);
    }

    #[test]
    fn a_whole_number_may_be_written_with_a_point() {
        let inputs: Inputs = read(json!({"terrain": {"href": "x"}, "count": 3.0})).unwrap();
        assert_eq!(inputs.count, Some(3));
    }
}
