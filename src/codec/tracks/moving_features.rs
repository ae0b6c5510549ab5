//! OGC Moving Features JSON (OGC 19-045r3): one feature an animal, a `MovingPoint` with its height
//! and heading as temporal properties. Second 0 is 2000-01-01T00:00Z.
//!
//! Positions are in the plane, although the standard allows a third coordinate: MovingPandas takes
//! pairs only, and a height that is a property comes out as a column of its own.

use std::fmt::Write as _;

use time::OffsetDateTime;
use time::PrimitiveDateTime;

use super::TrackFile;
use crate::codec::map::Georeference;

/// Seconds of 2000-01-01T00:00Z since 1970.
const EPOCH_S: i64 = 946_684_800;

impl TrackFile<'_> {
    /// The collection as a text: written piece by piece, as a tree of it would be many times as
    /// large.
    pub fn to_moving_features(&self) -> String {
        let steps = self.tracks.times_s.len();
        let times: Vec<String> = self.tracks.times_s.iter().map(|t| format!("\"{}\"", timestamp(*t))).collect();
        let times = times.join(",");
        let mut out = String::with_capacity(400 + self.tracks.animals * (400 + steps * 100));
        out.push_str(r#"{"type":"FeatureCollection","crs":"#);
        out.push_str(&crs(self.georeference));
        out.push_str(r#","trs":{"type":"Name","properties":{"name":"urn:ogc:data:time:iso8601"}},"features":["#);
        for animal in 0..self.tracks.animals {
            if animal > 0 {
                out.push(',');
            }
            self.feature(&mut out, animal, &times);
        }
        out.push_str("]}");
        out
    }

    fn feature(&self, out: &mut String, animal: usize, times: &str) {
        let poses = || (0..self.tracks.times_s.len()).map(|step| self.tracks.pose(step, animal));
        let (a, b) = self.bodies.get(animal).copied().unwrap_or_default();
        let _ = write!(
            out,
            r#"{{"type":"Feature","id":{animal},"properties":{{"id":{animal},"simulated":true,"length_m":{:?},"width_m":{:?}}},"#,
            2.0 * a,
            2.0 * b
        );
        let _ = write!(out, r#""geometry":null,"temporalGeometry":{{"type":"MovingPoint","datetimes":[{times}],"#);
        out.push_str(r#""coordinates":["#);
        list(out, poses(), |out, p| {
            let _ = write!(out, "[{:?},{:?}]", p.place.x, p.place.y);
        });
        let _ = write!(out, r#"],"interpolation":"Linear","crs":{}}},"#, crs(self.georeference));
        let _ = write!(out, r#""temporalProperties":[{{"datetimes":[{times}],"#);
        measure(out, ("z", "m"), poses().map(|p| p.z));
        out.push(',');
        measure(out, ("heading", "rad"), unwrapped(poses().map(|p| p.heading)));
        out.push_str("}]}");
    }
}

/// A temporal property and its unit.
fn measure(out: &mut String, (name, unit): (&str, &str), values: impl Iterator<Item = f64>) {
    let _ = write!(out, r#""{name}":{{"type":"Measure","form":"{unit}","values":["#);
    list(out, values, |out, value| {
        let _ = write!(out, "{value:?}");
    });
    out.push_str(r#"],"interpolation":"Linear"}"#);
}

fn list<T>(out: &mut String, items: impl Iterator<Item = T>, mut write: impl FnMut(&mut String, T)) {
    for (i, item) in items.enumerate() {
        if i > 0 {
            out.push(',');
        }
        write(out, item);
    }
}

/// Angles without jumps of a whole turn, so that what lies between two can be interpolated.
pub(super) fn unwrapped(angles: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    const TURN: f64 = std::f64::consts::TAU;
    angles.scan(None, |last: &mut Option<f64>, angle| {
        let near = last.map_or(angle, |last| angle + TURN * ((last - angle) / TURN).round());
        *last = Some(near);
        Some(near)
    })
}

fn crs(georeference: &Georeference) -> String {
    match georeference.code() {
        Some(code) => {
            format!(r#"{{"type":"Name","properties":{{"name":"urn:ogc:def:crs:EPSG::{code}"}}}}"#)
        }
        None => "null".to_owned(),
    }
}

/// A moment in milliseconds. What the calendar cannot hold stands at its last day.
fn timestamp(seconds: f64) -> String {
    let millis = (seconds.clamp(-9e11, 9e11) * 1000.0).round() as i128 + i128::from(EPOCH_S) * 1000;
    let moment =
        OffsetDateTime::from_unix_timestamp_nanos(millis * 1_000_000).unwrap_or(PrimitiveDateTime::MAX.assume_utc());
    let (date, (hour, minute, second, millis)) = (moment.date(), moment.time().as_hms_milli());
    format!("{date}T{hour:02}:{minute:02}:{second:02}.{millis:03}Z")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::tracks::tests::file;
    use crate::codec::tracks::tests::tracks;
    use serde_json::Value;
    use serde_json::json;

    fn document(georeference: &Georeference) -> Value {
        let tracks = tracks();
        serde_json::from_str(&file(&tracks, georeference).to_moving_features()).unwrap()
    }

    #[test]
    fn every_animal_is_a_moving_point_with_a_heading_and_marked_as_simulated() {
        let all = document(&Georeference::local("test"));
        assert_eq!(
            (&all["type"], &all["crs"], all["features"].as_array().unwrap().len()),
            (&json!("FeatureCollection"), &Value::Null, 2)
        );
        let feature = &all["features"][1];
        assert_eq!(
            (&feature["properties"]["simulated"], &feature["properties"]["length_m"]),
            (&json!(true), &json!(2.0))
        );
        let geometry = &feature["temporalGeometry"];
        assert_eq!((&geometry["type"], &geometry["interpolation"]), (&json!("MovingPoint"), &json!("Linear")));
        assert_eq!(
            geometry["datetimes"],
            json!(["2000-01-01T00:01:00.000Z", "2000-01-01T00:01:00.500Z", "2000-01-01T00:01:01.250Z"])
        );
        assert_eq!(geometry["coordinates"], json!([[12.0, 25.0], [12.0, 26.0], [11.0, 26.0]]));
        let properties = &feature["temporalProperties"][0];
        assert_eq!(properties["datetimes"], geometry["datetimes"]);
        assert_eq!((&properties["z"]["values"], &properties["z"]["form"]), (&json!([17.0, 17.0, 16.0]), &json!("m")));
        let heading = properties["heading"]["values"][2].as_f64().unwrap();
        assert!((heading - (std::f64::consts::TAU - 3.1)).abs() < 1e-12, "{heading}");
    }

    #[test]
    fn an_anchored_world_names_its_coordinates() {
        let all = document(&Georeference::epsg(32616));
        assert_eq!(all["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::32616");
    }

    #[test]
    fn moments_are_those_of_the_calendar() {
        assert_eq!(timestamp(0.0), "2000-01-01T00:00:00.000Z");
        assert_eq!(timestamp(-0.001), "1999-12-31T23:59:59.999Z");
        assert_eq!(timestamp(59.0 * 86_400.0 + 3661.0005), "2000-02-29T01:01:01.001Z");
        assert_eq!(timestamp(366.0 * 86_400.0), "2001-01-01T00:00:00.000Z");
        assert_eq!(timestamp(86_400.0 * 146_097.0), "2400-01-01T00:00:00.000Z");
    }
}
