//! What the `ecosystem` process refuses before anything is queued, and what it only warns of.

use biotope::jobs::Process;
use biotope::jobs::ecosystem::Ecosystem;
use biotope::jobs::schema::InputCheck;
use biotope::jobs::sources::ByValueOnly;
use serde_json::Value;
use serde_json::json;

/// An ESRI ASCII grid of `values`, row by row, on cells of 30 m, as a reference by value.
pub fn grid(columns: usize, rows: usize, values: impl Fn(usize, usize) -> f64) -> Value {
    let mut text =
        format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 30\nNODATA_value -9999\n");
    for row in 0..rows {
        let line: Vec<String> = (0..columns).map(|column| values(column, row).to_string()).collect();
        text.push_str(&line.join(" "));
        text.push('\n');
    }
    by_value(&text)
}

pub fn by_value(text: &str) -> Value {
    json!({"value": text, "mediaType": "text/plain"})
}

pub fn slope(column: usize, row: usize) -> f64 {
    100.0 + 2.0 * column as f64 + row as f64
}

pub fn month() -> Value {
    json!({"temperature_mean_c": 12, "temperature_half_range_c": 5, "precipitation_mm": 60, "sunshine_fraction": 0.5})
}

/// Inputs that are valid.
pub fn inputs() -> Value {
    json!({
        "terrain": {"source": grid(12, 10, slope), "latitude_deg": 43},
        "climate": {"months": vec![month(); 12]},
        "plants": [{"species": "Poaceae"}, {"species": "Quercus"}],
        "animals": [{"species": "Cervus elaphus"}, {"species": "Canis mosbachensis"}],
    })
}

pub fn with(change: impl Fn(&mut Value)) -> Value {
    let mut all = inputs();
    change(&mut all);
    all
}

/// The faults found in `inputs`: (pointer, code), each with something expected and found.
fn faults(inputs: Value) -> Vec<(String, String)> {
    let check = InputCheck::new(&Ecosystem.description().inputs).expect("a valid schema");
    let faults = match check.check(&inputs) {
        Ok(()) => Ecosystem.parse(inputs, &ByValueOnly).err(),
        Err(faults) => Some(faults),
    };
    let errors = faults.map(|f| f.errors).unwrap_or_default();
    assert!(errors.iter().all(|e| !e.expected.is_empty() && !e.found.is_empty()), "{errors:?}");
    errors.into_iter().map(|e| (e.pointer, e.code)).collect()
}

fn assert_fault(inputs: Value, pointer: &str, code: &str) {
    let found = faults(inputs);
    assert!(found.contains(&(pointer.to_owned(), code.to_owned())), "expected {pointer} {code}, found {found:?}");
}

#[test]
fn valid_inputs_have_no_fault() {
    assert_eq!(faults(inputs()), []);
}

#[test]
fn no_terrain_is_missing() {
    assert_fault(with(|i| drop(i.as_object_mut().unwrap().remove("terrain"))), "/terrain", "missing");
    assert_fault(with(|i| i["terrain"]["source"] = by_value("")), "/terrain/source", "unreadable");
    assert_fault(with(|i| i["terrain"]["source"] = by_value("no raster at all")), "/terrain/source", "unreadable");
}

#[test]
fn a_terrain_of_one_cell_is_too_small() {
    assert_fault(with(|i| i["terrain"]["source"] = grid(1, 1, slope)), "/terrain/source", "raster-too-small");
}

#[test]
fn a_terrain_of_forty_thousand_cells_square_is_refused_by_its_header() {
    let header = "ncols 40000\nnrows 40000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3";
    assert_fault(with(|i| i["terrain"]["source"] = by_value(header)), "/terrain/source", "raster-too-large");
}

#[test]
fn a_terrain_without_any_height_is_refused() {
    assert_fault(with(|i| i["terrain"]["source"] = grid(5, 5, |_, _| -9999.0)), "/terrain/source", "no-data");
}

#[test]
fn infinite_heights_are_refused() {
    let grid = grid(5, 5, |c, r| if (c, r) == (2, 2) { 1e39 } else { 1.0 });
    assert_fault(with(|i| i["terrain"]["source"] = grid.clone()), "/terrain/source", "infinite-values");
}

#[test]
fn a_colour_picture_is_no_terrain() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[9; 12]).expect("pixels");
    drop(writer);
    let text: String = bytes.iter().map(|b| format!("%{b:02X}")).collect();
    let source = json!({ "href": format!("data:image/png,{text}") });
    assert_fault(with(|i| i["terrain"]["source"] = source.clone()), "/terrain/source", "COLOR_PNG");
}

#[test]
fn a_map_of_another_size_is_refused() {
    let mask = grid(9, 10, |_, _| 0.0);
    assert_fault(with(|i| i["maps"] = json!({"exclusion": mask})), "/maps/exclusion", "SIZE_MISMATCH");
}

/// A terrain-sized grey picture of one level, or a TIFF of its bytes.
fn grey(level: u8) -> Value {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 12, 10);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[level; 120]).expect("pixels");
    drop(writer);
    let text: String = bytes.iter().map(|b| format!("%{b:02X}")).collect();
    json!({ "href": format!("data:image/png,{text}") })
}

#[test]
fn a_map_of_a_quantity_is_no_grey_picture_but_a_mask_may_be_one() {
    for (field, map) in [("texture", json!(grey(90))), ("moisture/0", json!([grey(90)]))] {
        let name = field.trim_end_matches("/0");
        assert_fault(with(|i| i["maps"] = json!({ name: map })), &format!("/maps/{field}"), "NO_RANGE");
    }
    for name in ["exclusion", "water_depth_m"] {
        assert_eq!(faults(with(|i| i["maps"] = json!({ name: grey(255) }))), []);
    }
}

#[test]
fn a_map_of_impossible_values_is_refused() {
    for (pointer, value) in [
        ("temperature_max_c/0", 290.0),
        ("temperature_min_c/0", -273.2),
        ("moisture/0", 40.0),
        ("sunlight/0", 1.5),
        ("water_depth_m", -2.0),
        ("exclusion", 7.0),
        ("soil", 9.0),
    ] {
        let map = grid(12, 10, |_, _| value);
        let name = pointer.trim_end_matches("/0");
        let map = if name == pointer { map } else { json!([map]) };
        assert_fault(with(|i| i["maps"] = json!({ name: map })), &format!("/maps/{pointer}"), "out-of-range");
    }
}

#[test]
fn a_minimum_above_the_maximum_of_its_month_is_refused() {
    let year = |value: f64| json!([grid(12, 10, |_, _| value)]);
    let maps = json!({"temperature_min_c": year(12.0), "temperature_max_c": year(8.0)});
    assert_fault(with(|i| i["maps"] = maps.clone()), "/maps/temperature_min_c", "inconsistent");
}

#[test]
fn an_unknown_species_is_named() {
    assert_fault(with(|i| i["plants"][1]["species"] = json!("Quercsu")), "/plants/1/species", "unknown-species");
    assert_fault(with(|i| i["animals"][0]["species"] = json!("Unicornis")), "/animals/0/species", "unknown-species");
    assert_fault(with(|i| i["biomes"] = json!({"dry": ["Pinus"]})), "/biomes/dry/0", "unknown-species");
}

#[test]
fn the_same_species_twice_is_refused() {
    assert_fault(with(|i| i["plants"][1]["species"] = json!("poaceae")), "/plants/1/species", "duplicate-species");
}

#[test]
fn a_range_with_its_ends_swapped_is_refused() {
    let need = json!({"min": 7, "max": 3, "use": 1});
    assert_fault(with(|i| i["plants"][0]["moisture"] = need.clone()), "/plants/0/moisture", "inconsistent");
    assert_fault(with(|i| i["animals"][0]["group_size_min"] = json!(99)), "/animals/0/group_size_min", "inconsistent");
}

#[test]
fn a_negative_mass_is_refused() {
    assert_fault(with(|i| i["animals"][0]["mass_kg"] = json!(-3)), "/animals/0/mass_kg", "out-of-range");
}

#[test]
fn proportions_that_sum_to_zero_are_refused() {
    let zero = |i: &mut Value, list: &str| {
        i[list].as_array_mut().unwrap().iter_mut().for_each(|s| s["proportion"] = json!(0));
    };
    assert_fault(with(|i| zero(i, "plants")), "/plants", "zero-proportions");
    assert_fault(with(|i| zero(i, "animals")), "/animals", "zero-proportions");
    assert_fault(with(|i| i["plants"][0]["proportion"] = json!(3)), "/plants", "inconsistent");
}

#[test]
fn a_food_chain_with_a_cycle_is_named() {
    let eat = |i: &mut Value, who: usize, whom: &str| i["animals"][who]["diet"] = json!([{ "food": whom }]);
    let inputs = with(|i| {
        eat(i, 0, "Canis mosbachensis");
        eat(i, 1, "Cervus elaphus");
    });
    assert_fault(inputs, "/animals/0/diet", "food-chain-cycle");
}

#[test]
fn a_prey_that_is_not_there_is_named() {
    let hunter = json!([{"species": "Canis mosbachensis"}]);
    assert_fault(with(|i| i["animals"] = hunter.clone()), "/animals/0/diet", "missing-prey");
    let diet = json!([{"food": "Mammuthus"}]);
    assert_fault(with(|i| i["animals"][1]["diet"] = diet.clone()), "/animals/1/diet/0/food", "missing-prey");
}

#[test]
fn a_latitude_beyond_the_pole_is_refused() {
    assert_fault(with(|i| i["terrain"]["latitude_deg"] = json!(95)), "/terrain/latitude_deg", "out-of-range");
    let nowhere = with(|i| drop(i["terrain"].as_object_mut().unwrap().remove("latitude_deg")));
    assert_fault(nowhere, "/terrain/latitude_deg", "missing");
}

#[test]
fn a_year_of_eleven_months_is_refused() {
    assert_fault(with(|i| i["climate"]["months"] = json!(vec![month(); 11])), "/climate/months", "wrong-count");
}

#[test]
fn a_ford_beside_the_terrain_is_refused() {
    let fords = json!({"fords": [{"x": 5000, "y": 10}]});
    assert_fault(with(|i| i["passages"] = fords.clone()), "/passages/fords/0", "out-of-range");
}

#[test]
fn a_way_point_off_the_map_or_for_strangers_is_refused() {
    let set = |points: Value| with(|i| i["passages"] = json!({ "waypoints": points }));
    let at = "/passages/waypoints/0";
    assert_fault(set(json!([{"x": -20, "y": 10}])), at, "out-of-range");
    assert_fault(set(json!([{"x": 20, "y": 10, "radius_m": -1}])), &format!("{at}/radius_m"), "out-of-range");
    assert_fault(set(json!([{"x": 20, "y": 10, "share": 1.5}])), &format!("{at}/share"), "out-of-range");
    let strangers = json!([{"x": 20, "y": 10, "species": ["Cervus elaphus", "Mammuthus"]}]);
    assert_fault(set(strangers), &format!("{at}/species/1"), "unknown-species");
    let many = |share: f64| set(json!(vec![json!({"x": 20, "y": 10, "share": share}); 101]));
    assert_fault(many(0.1), "/passages/waypoints", "wrong-count");
    assert_eq!(faults(many(0.0)), []);
}

#[test]
fn all_faults_are_told_at_once() {
    let inputs = with(|i| {
        i["plants"][0]["species"] = json!("Nothing");
        i["animals"][0]["mass_kg"] = json!(-1);
        i["terrain"]["source"] = grid(1, 1, slope);
    });
    let found = faults(inputs);
    for pointer in ["/plants/0/species", "/terrain/source"] {
        assert!(found.iter().any(|(p, _)| p == pointer), "{found:?}");
    }
}
