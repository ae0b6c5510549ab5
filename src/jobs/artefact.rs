//! What a job hands back, the one form it is stored in, and the forms it can be had in.

use bytes::Bytes;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;
use serde_json::json;

use crate::codec::map::Category;
use crate::codec::map::Map;
use crate::codec::map::PictureOptions;
use crate::codec::map::Scale;
use crate::jobs::Table;

/// Version of the encoders; to be raised whenever the same artefact gives other bytes in a form.
pub const ENCODERS_VERSION: u32 = 2;

/// What a job hands back.
#[derive(Debug, Clone)]
pub enum Artefact {
    /// A document.
    Json(Value),
    /// A table.
    Table(Table),
    /// Several tables that belong together, each with a name.
    Tables(Vec<(String, Table)>),
    /// A map; stored once in its compact form, encoded when asked for.
    Map(Map),
    /// A PNG picture.
    Picture(Bytes),
    /// A file of another kind.
    Bytes {
        /// Its media type.
        media_type: String,
        /// Its file name extension, without a dot.
        extension: String,
        /// The file.
        bytes: Bytes,
    },
}

/// What kind of thing an artefact is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Kind {
    /// A document.
    Json,
    /// A table.
    Table,
    /// Several tables.
    Tables,
    /// A map.
    Map,
    /// A PNG picture.
    Picture,
    /// A file of another kind.
    File {
        /// Its media type.
        media_type: std::borrow::Cow<'static, str>,
        /// Its file name extension.
        extension: std::borrow::Cow<'static, str>,
    },
}

/// A form in which an artefact can be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// Its name in `?f=`, and the file name extension.
    pub name: String,
    /// Its media type.
    pub media_type: String,
}

/// An artefact in one of its forms.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// Which form.
    pub form: Form,
    /// The bytes.
    pub bytes: Bytes,
}

/// Why an artefact could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ArtefactError {
    /// The artefact has no such form.
    #[error("a {kind} cannot be had as {form}")]
    NoSuchForm {
        /// Kind of the artefact.
        kind: &'static str,
        /// Form asked for.
        form: String,
    },
    /// The columns of a table are of different length.
    #[error("the columns of a table are of different length")]
    UnevenTable,
    /// A document could not be read or written.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A map could not be read or written.
    #[error(transparent)]
    Map(#[from] crate::codec::map::Error),
}

impl Kind {
    /// A file of the given media type and extension.
    pub const fn file(media_type: &'static str, extension: &'static str) -> Self {
        use std::borrow::Cow;
        Self::File { media_type: Cow::Borrowed(media_type), extension: Cow::Borrowed(extension) }
    }

    /// Its name for people.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Json => "document",
            Self::Table => "table",
            Self::Tables => "set of tables",
            Self::Map => "map",
            Self::Picture => "picture",
            Self::File { .. } => "file",
        }
    }

    /// The forms such an artefact can be had in, the default first. A page for people (`html`)
    /// is made of all of them beside these.
    pub fn forms(&self) -> Vec<Form> {
        let forms = |names: &[(&str, &str)]| names.iter().map(|(n, m)| Form::new(n, m)).collect();
        match self {
            Self::Json => forms(&[("json", "application/json")]),
            Self::Table | Self::Tables => forms(&[("json", "application/json"), ("csv", "text/csv")]),
            Self::Map => forms(&[("tif", "image/tiff"), ("png", "image/png"), ("json", "application/json")]),
            Self::Picture => forms(&[("png", "image/png")]),
            Self::File { media_type, extension } => forms(&[(extension.as_ref(), media_type.as_ref())]),
        }
    }

    /// The forms that `run --out` writes: all that carry the contents.
    pub fn file_forms(&self) -> Vec<Form> {
        let described_only = |form: &Form| *self == Self::Map && form.name == "json";
        self.forms().into_iter().filter(|form| !described_only(form)).collect()
    }
}

impl Form {
    /// A form of that name and media type.
    pub fn new(name: &str, media_type: &str) -> Self {
        Self { name: name.to_owned(), media_type: media_type.to_owned() }
    }
}

impl Artefact {
    /// A document made of anything that serialises.
    ///
    /// # Errors
    /// When it does not.
    pub fn document(value: &impl Serialize) -> Result<Self, ArtefactError> {
        Ok(Self::Json(serde_json::to_value(value)?))
    }

    /// What kind of thing it is.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Json(_) => Kind::Json,
            Self::Table(_) => Kind::Table,
            Self::Tables(_) => Kind::Tables,
            Self::Map(_) => Kind::Map,
            Self::Picture(_) => Kind::Picture,
            Self::Bytes { media_type, extension, .. } => {
                Kind::File { media_type: media_type.clone().into(), extension: extension.clone().into() }
            }
        }
    }

    /// Whether it is a map that is 0 or without data everywhere.
    pub fn is_blank(&self) -> bool {
        matches!(self, Self::Map(map) if map.is_blank())
    }

    /// The one form it is stored in.
    ///
    /// # Errors
    /// When a table is uneven or a document does not serialise.
    pub fn to_stored(&self) -> Result<Bytes, ArtefactError> {
        let even = |table: &Table| if table.is_even() { Ok(()) } else { Err(ArtefactError::UnevenTable) };
        match self {
            Self::Json(value) => Ok(serde_json::to_vec(value)?.into()),
            Self::Table(table) => even(table).and_then(|()| Ok(serde_json::to_vec(table)?.into())),
            Self::Tables(tables) => {
                tables.iter().try_for_each(|(_, table)| even(table))?;
                Ok(serde_json::to_vec(tables)?.into())
            }
            Self::Map(map) => Ok(map.to_bytes().into()),
            Self::Picture(bytes) | Self::Bytes { bytes, .. } => Ok(bytes.clone()),
        }
    }

    /// Reads what [`Artefact::to_stored`] wrote.
    ///
    /// # Errors
    /// When the bytes are not of that kind.
    pub fn from_stored(kind: &Kind, bytes: Bytes) -> Result<Self, ArtefactError> {
        Ok(match kind {
            Kind::Json => Self::Json(serde_json::from_slice(&bytes)?),
            Kind::Table => Self::Table(serde_json::from_slice(&bytes)?),
            Kind::Tables => Self::Tables(serde_json::from_slice(&bytes)?),
            Kind::Map => Self::Map(Map::from_bytes(&bytes)?),
            Kind::Picture => Self::Picture(bytes),
            Kind::File { media_type, extension } => {
                Self::Bytes { media_type: media_type.to_string(), extension: extension.to_string(), bytes }
            }
        })
    }

    /// The artefact in the form of that name.
    ///
    /// # Errors
    /// When it has no such form, or cannot be written in it.
    pub fn encode(&self, form: &str) -> Result<Encoded, ArtefactError> {
        let kind = self.kind();
        let known = kind.forms().into_iter().find(|known| known.name == form);
        let refuse = || ArtefactError::NoSuchForm { kind: kind.name(), form: form.to_owned() };
        let bytes = match (self, form) {
            (Self::Json(value), "json") => serde_json::to_vec(value)?.into(),
            (Self::Table(table), "json") => serde_json::to_vec(&table.records())?.into(),
            (Self::Table(table), "csv") => table.csv().into(),
            (Self::Tables(tables), "json") => serde_json::to_vec(&tables_json(tables))?.into(),
            (Self::Tables(tables), "csv") => tables_csv(tables).into(),
            (Self::Map(map), "tif") => map.to_geotiff()?.into(),

            (Self::Map(map), "png") => map.to_png(&PictureOptions::default())?.into(),
            (Self::Map(map), "json") => serde_json::to_vec(&map_json(map))?.into(),
            (Self::Picture(bytes) | Self::Bytes { bytes, .. }, _) if known.is_some() => bytes.clone(),
            _ => return Err(refuse()),
        };
        Ok(Encoded { form: known.ok_or_else(refuse)?, bytes })
    }
}

/// An object of lists of records, by the names of the tables.
fn tables_json(tables: &[(String, Table)]) -> Value {
    Value::Object(tables.iter().map(|(name, table)| (name.clone(), table.records())).collect())
}

/// One CSV after another, each under a line `# <name>` and parted by an empty line.
fn tables_csv(tables: &[(String, Table)]) -> String {
    let parts: Vec<String> = tables.iter().map(|(name, table)| format!("# {name}\n{}", table.csv())).collect();
    parts.join("\n")
}

/// What can be said of a map in a few lines: size, place, legend, extremes; what its classes are.
fn map_json(map: &Map) -> Value {
    let grid = map.grid();
    let statistics = map.statistics();
    let mut about = json!({
        "title": map.legend.title,
        "unit": map.legend.unit,
        "width": grid.width,
        "height": grid.height,
        "cell_m": grid.cell_m,
        "origin_x_m": grid.origin.x,
        "origin_y_m": grid.origin.y,
        "epsg": map.georeference.code(),
        "min": statistics.min,
        "max": statistics.max,
        "mean": statistics.mean,
        "nodata_cells": statistics.nodata,
    });
    if let Scale::Categories(classes) = &map.legend.scale {
        let class = |c: &Category| json!({ "value": c.value, "label": c.label, "colour": c.colour });
        about["classes"] = classes.iter().map(class).collect();
    }
    about
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::map::Georeference;
    use crate::codec::map::Legend;
    use crate::codec::map::MapData;
    use crate::compute::raster::Grid;
    use crate::compute::raster::Raster;

    #[test]
    fn every_kind_encodes_in_every_form_it_claims_and_refuses_others() {
        let table = Table::new().integers("id", "", [1, 2]);
        let file =
            Artefact::Bytes { media_type: "model/gltf-binary".into(), extension: "glb".into(), bytes: "x".into() };
        let tables = Artefact::Tables(vec![("nodes".into(), table.clone()), ("edges".into(), table.clone())]);
        for artefact in
            [Artefact::Json(json!([1])), Artefact::Table(table), tables, Artefact::Picture("x".into()), file]
        {
            let kind = artefact.kind();
            let stored = artefact.to_stored().unwrap();
            let back = Artefact::from_stored(&kind, stored).unwrap();
            for form in kind.forms() {
                assert_eq!(back.encode(&form.name).unwrap().form, form);
                assert_eq!(back.encode(&form.name).unwrap().bytes, artefact.encode(&form.name).unwrap().bytes);
            }
            assert!(matches!(back.encode("xyz"), Err(ArtefactError::NoSuchForm { .. })));
        }
    }

    #[test]
    fn what_is_said_of_a_map_names_its_classes() {
        let class = Category { value: 3, label: "marl".into(), colour: [9, 8, 7] };
        let data = MapData::U8(Raster { grid: Grid::new(2, 1, 5.0), data: vec![3, 255] });
        let legend = Legend::categories("Soil", vec![class]);
        let map = Artefact::Map(Map { data, legend, georeference: Georeference::default() });
        let about: Value = serde_json::from_slice(&map.encode("json").unwrap().bytes).unwrap();
        assert_eq!(about["classes"], json!([{"value": 3, "label": "marl", "colour": [9, 8, 7]}]));
        assert_eq!((&about["nodata_cells"], &about["cell_m"]), (&json!(1), &json!(5.0)));
    }

    #[test]
    fn an_uneven_table_is_not_stored() {
        let table = Table::new().integers("a", "", [1, 2]).integers("b", "", [1]);
        assert!(matches!(Artefact::Table(table).to_stored(), Err(ArtefactError::UnevenTable)));
    }
}
