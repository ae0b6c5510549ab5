//! OpenAPI 3.1 written as 3.0, for clients that read nothing newer.

use serde_json::Map;
use serde_json::Value;
use serde_json::json;

/// Keywords of JSON Schema 2020-12 that 3.0 does not know and that only narrow or explain.
const UNKNOWN: [&str; 7] = [
    "$schema",
    "$defs",
    "contentMediaType",
    "patternProperties",
    "propertyNames",
    "unevaluatedProperties",
    "jsonSchemaDialect",
];

/// The document in OpenAPI 3.0.3.
pub fn to_3_0(document: &Value) -> Value {
    let mut out = document.clone();
    out["openapi"] = "3.0.3".into();
    if let Some(schemas) = out["components"]["schemas"].as_object_mut() {
        schemas.values_mut().for_each(convert);
    }
    if let Some(paths) = out["paths"].as_object_mut() {
        paths.values_mut().for_each(convert_inside);
    }
    out
}

/// Converts every schema below a path item.
fn convert_inside(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(convert_inside),
        Value::Object(fields) => {
            for (name, field) in fields {
                if name == "schema" { convert(field) } else { convert_inside(field) }
            }
        }
        _ => {}
    }
}

/// Converts a schema and all within it.
fn convert(schema: &mut Value) {
    match schema {
        Value::Bool(true) => *schema = json!({}),
        Value::Bool(false) => *schema = json!({ "not": {} }),
        Value::Object(fields) => convert_fields(fields),
        _ => {}
    }
}

fn convert_fields(fields: &mut Map<String, Value>) {
    UNKNOWN.iter().for_each(|name| drop(fields.remove(*name)));
    nullable_types(fields);
    nullable_alternatives(fields);
    bounds(fields, "exclusiveMinimum", "minimum");
    bounds(fields, "exclusiveMaximum", "maximum");
    if let Some(value) = fields.remove("const") {
        fields.insert("enum".into(), json!([value]));
    }
    if let Some(Value::Array(examples)) = fields.remove("examples")
        && let Some(first) = examples.into_iter().next()
    {
        fields.insert("example".into(), first);
    }
    if fields.remove("contentEncoding").is_some() {
        fields.insert("format".into(), "binary".into());
    }
    if fields.remove("prefixItems").is_some() {
        fields.insert("items".into(), json!({}));
    }
    if fields.get("type") == Some(&json!("array")) && !fields.contains_key("items") {
        fields.insert("items".into(), json!({}));
    }
    alone_reference(fields);
    for (name, field) in fields.iter_mut() {
        match name.as_str() {
            "properties" => field.as_object_mut().into_iter().flat_map(|p| p.values_mut()).for_each(convert),
            "items" | "not" => convert(field),
            "additionalProperties" if field.is_object() => convert(field),
            "allOf" | "anyOf" | "oneOf" => field.as_array_mut().into_iter().flatten().for_each(convert),
            _ => {}
        }
    }
}

/// `"type": ["string", "null"]` becomes `"type": "string", "nullable": true`.
fn nullable_types(fields: &mut Map<String, Value>) {
    let Some(Value::Array(types)) = fields.get("type").cloned() else {
        if fields.get("type") == Some(&json!("null")) {
            fields.remove("type");
            fields.insert("enum".into(), json!([null]));
            fields.insert("nullable".into(), true.into());
        }
        return;
    };
    let others: Vec<_> = types.iter().filter(|name| *name != "null").cloned().collect();
    if others.len() < types.len() {
        fields.insert("nullable".into(), true.into());
    }
    match others.as_slice() {
        [one] => drop(fields.insert("type".into(), one.clone())),
        several => {
            fields.remove("type");
            let forms: Vec<_> = several.iter().map(|name| json!({ "type": name })).collect();
            fields.insert("anyOf".into(), forms.into());
        }
    }
}

/// `"anyOf": [X, {"type": "null"}]` becomes `"allOf": [X], "nullable": true`.
fn nullable_alternatives(fields: &mut Map<String, Value>) {
    for keyword in ["anyOf", "oneOf"] {
        let Some(Value::Array(forms)) = fields.get(keyword).cloned() else { continue };
        let others: Vec<_> = forms.iter().filter(|form| form["type"] != "null").cloned().collect();
        if others.len() == forms.len() {
            continue;
        }
        fields.insert("nullable".into(), true.into());
        fields.remove(keyword);
        let keyword = if others.len() == 1 { "allOf" } else { keyword };
        fields.insert(keyword.into(), others.into());
    }
}

/// A limit that is excluded is a flag beside the limit.
fn bounds(fields: &mut Map<String, Value>, exclusive: &str, limit: &str) {
    if let Some(value) = fields.get(exclusive).filter(|value| value.is_number()).cloned() {
        fields.insert(limit.into(), value);
        fields.insert(exclusive.into(), true.into());
    }
}

/// What stands beside a reference is ignored in 3.0, so the reference moves inside.
fn alone_reference(fields: &mut Map<String, Value>) {
    if fields.len() > 1
        && let Some(target) = fields.remove("$ref")
    {
        fields.insert("allOf".into(), json!([{ "$ref": target }]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(mut schema: Value) -> Value {
        convert(&mut schema);
        schema
    }

    #[test]
    fn what_3_0_does_not_know_is_said_in_its_own_words() {
        for (new, old) in [
            (json!({"type": ["string", "null"]}), json!({"type": "string", "nullable": true})),
            (json!({"const": "a"}), json!({"enum": ["a"]})),
            (json!({"exclusiveMinimum": 0}), json!({"exclusiveMinimum": true, "minimum": 0})),
            (
                json!({"anyOf": [{"$ref": "#/x"}, {"type": "null"}]}),
                json!({"nullable": true, "allOf": [{"$ref": "#/x"}]}),
            ),
            (json!({"properties": {"a": true}}), json!({"properties": {"a": {}}})),
            (json!({"$ref": "#/x", "description": "d"}), json!({"description": "d", "allOf": [{"$ref": "#/x"}]})),
        ] {
            assert_eq!(converted(new), old);
        }
    }
}
