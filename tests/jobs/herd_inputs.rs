//! What the three processes of herds refuse before anything is queued, and what they only warn of.

use base64::Engine as _;
use biotope::codec::picture::Animation;
use biotope::codec::picture::Image;
use biotope::jobs::Process;
use biotope::jobs::herd_animation::HerdAnimation;
use biotope::jobs::herd_extraction::HerdExtraction;
use biotope::jobs::key_herd::KeyHerd;
use biotope::jobs::schema::InputCheck;
use biotope::jobs::sources::ByValueOnly;
use serde_json::Value;
use serde_json::json;

/// The faults found in `inputs`: (pointer, code), each with something expected and found.
fn faults(process: &dyn Process, inputs: &Value) -> Vec<(String, String)> {
    let check = InputCheck::new(&process.description().inputs).expect("a valid schema");
    let faults = match check.check(inputs) {
        Ok(()) => process.parse(inputs.clone(), &ByValueOnly).err(),
        Err(faults) => Some(faults),
    };
    let errors = faults.map(|f| f.errors).unwrap_or_default();
    assert!(errors.iter().all(|e| !e.expected.is_empty() && !e.found.is_empty()), "{errors:?}");
    errors.into_iter().map(|e| (e.pointer, e.code)).collect()
}

fn changed(inputs: Value, change: impl Fn(&mut Value)) -> Value {
    let mut all = inputs;
    change(&mut all);
    all
}

fn assert_fault(process: &dyn Process, inputs: &Value, pointer: &str, code: &str) {
    let found = faults(process, inputs);
    assert!(found.contains(&(pointer.to_owned(), code.to_owned())), "expected {pointer} {code}, found {found:?}");
}

pub fn by_value(bytes: &[u8], media_type: &str) -> Value {
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    json!({"value": text, "encoding": "base64", "mediaType": media_type})
}

/// A grass-green picture with dark spots.
fn picture() -> Image {
    let dark = |i: usize| (i % 60) % 20 < 8 && (i / 60) % 20 < 5;
    let rgb = (0..60 * 40).map(|i| if dark(i) { [40, 30, 26] } else { [100, 124, 62] }).collect();
    Image { width: 60, height: 40, rgb }
}

fn png() -> Vec<u8> {
    picture().to_png().expect("a picture")
}

pub mod extraction {
    use super::*;

    pub fn inputs() -> Value {
        json!({
            "photo": by_value(&png(), "image/png"),
            "scribbles": {"strokes": [
                {"mark": "animal", "points": [[1, 38], [6, 38]], "width": 2},
                {"mark": "ground", "points": [[12, 10], [18, 10]], "width": 2},
            ]},
        })
    }

    pub fn with(change: impl Fn(&mut Value)) -> Value {
        changed(inputs(), change)
    }

    fn refused(inputs: Value, pointer: &str, code: &str) {
        assert_fault(&HerdExtraction, &inputs, pointer, code);
    }

    /// A grey label image by value.
    fn labels(size: (u32, u32), value: impl Fn(usize) -> u8) -> Value {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().expect("a header");
        let data: Vec<u8> = (0..(size.0 * size.1) as usize).map(value).collect();
        writer.write_image_data(&data).expect("pixels");
        drop(writer);
        by_value(&bytes, "image/png")
    }

    #[test]
    fn valid_inputs_have_no_fault() {
        assert_eq!(faults(&HerdExtraction, &inputs()), []);
    }

    #[test]
    fn an_unreadable_picture_is_refused() {
        refused(with(|i| i["photo"] = by_value(b"", "image/png")), "/photo", "unreadable");
        refused(with(|i| i["photo"] = by_value(b"GIF89a and more", "image/gif")), "/photo", "unreadable");
        refused(with(|i| i["photo"] = by_value(&png()[..200], "image/png")), "/photo", "unreadable");
        refused(with(|i| drop(i.as_object_mut().unwrap().remove("photo"))), "/photo", "missing");
    }

    #[test]
    fn a_moving_picture_is_refused() {
        let moving = Animation { frames: vec![picture(), picture()], delay_ms: 50 }.to_apng().expect("an animation");
        refused(with(|i| i["photo"] = by_value(&moving, "image/png")), "/photo", "picture-animated");
        // Neither form is read at all, moving or still.
        let webp = b"RIFF\x2a\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x3b\0\0\x27\0\0ANIM\x06\0\0\0\0\0\0\0\0\0";
        refused(with(|i| i["photo"] = by_value(webp, "image/webp")), "/photo", "unreadable");
        let gif = b"GIF89a\x01\0\x01\0\0\0\0!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0";
        refused(with(|i| i["photo"] = by_value(gif, "image/gif")), "/photo", "unreadable");
    }

    #[test]
    fn a_picture_in_printing_colours_is_refused() {
        let cmyk = [0xff, 0xd8, 0xff, 0xc0, 0, 20, 8, 0, 1, 0, 1, 4, 1, 0x11, 0];
        refused(with(|i| i["photo"] = by_value(&cmyk, "image/jpeg")), "/photo", "picture-cmyk");
    }

    #[test]
    fn a_huge_picture_is_refused_by_its_header() {
        let mut huge = png();
        huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
        let crc = !huge[12..29].iter().fold(!0u32, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
        });
        huge[29..33].copy_from_slice(&crc.to_be_bytes());
        refused(with(|i| i["photo"] = by_value(&huge, "image/png")), "/photo", "picture-too-large");
    }

    #[test]
    fn scribbles_of_only_one_kind_are_refused() {
        for kept in [0, 1] {
            let inputs = with(|i| drop(i["scribbles"]["strokes"].as_array_mut().unwrap().remove(kept)));
            refused(inputs, "/scribbles", "one-kind-of-scribble");
        }
        let only = labels((60, 40), |i| u8::from(i < 60));
        refused(with(|i| i["scribbles"] = json!({"labels": only})), "/scribbles", "one-kind-of-scribble");
    }

    #[test]
    fn a_stroke_outside_the_picture_is_named_by_its_point() {
        let inputs = with(|i| i["scribbles"]["strokes"][1]["points"][1] = json!([61, 10]));
        refused(inputs, "/scribbles/strokes/1/points/1", "outside-picture");
    }

    #[test]
    fn strokes_that_contradict_each_other_are_refused() {
        let inputs = with(|i| i["scribbles"]["strokes"][1]["points"] = json!([[3, 30], [3, 39]]));
        refused(inputs, "/scribbles", "contradicting-scribbles");
    }

    #[test]
    fn scribbles_are_strokes_or_a_label_image_and_not_both() {
        let image = labels((60, 40), |i| if i < 6 { 255 } else { u8::from(i > 2000) * 128 });
        assert_eq!(faults(&HerdExtraction, &with(|i| i["scribbles"] = json!({"labels": image}))), []);
        refused(with(|i| i["scribbles"]["labels"] = image.clone()), "/scribbles", "inconsistent");
        refused(with(|i| i["scribbles"] = json!({})), "/scribbles", "missing");
    }

    #[test]
    fn a_label_image_of_another_size_or_with_other_values_is_refused() {
        let small = labels((59, 40), |_| 1);
        refused(with(|i| i["scribbles"] = json!({"labels": small})), "/scribbles/labels", "SIZE_MISMATCH");
        let odd = labels((60, 40), |i| (i % 7) as u8);
        refused(with(|i| i["scribbles"] = json!({"labels": odd})), "/scribbles/labels", "not-one-of");
    }

    #[test]
    fn corrections_draw_ellipses_in_the_picture() {
        let one = json!({"x": 5, "y": 5, "a": 4, "b": 2, "theta": 0});
        let good = json!({"remove": [0], "add": [one], "flip": [1], "replace": [{"id": 2, "by": [one, one]}]});
        assert_eq!(faults(&HerdExtraction, &with(|i| i["corrections"] = good.clone())), []);
        let flat = json!({"x": 5, "y": 5, "a": 2, "b": 4, "theta": 0});
        refused(with(|i| i["corrections"] = json!({"add": [one, flat]})), "/corrections/add/1", "not-an-ellipse");
        let far = json!({"x": 61, "y": 5, "a": 4, "b": 2, "theta": 0});
        let replace = json!({"replace": [{"id": 2, "by": [far]}]});
        refused(with(|i| i["corrections"] = replace.clone()), "/corrections/replace/0/by/0", "outside-picture");
    }
}

/// An ESRI ASCII grid of heights, 100 m square on cells of 5 m, with a hole in its north-west.
pub fn terrain() -> Value {
    let mut text = String::from("ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n");
    for row in 0..20 {
        let height =
            |column| if row < 3 && column < 3 { "-9999".to_owned() } else { format!("{}", 0.1 * column as f64) };
        text.push_str(&(0..20).map(height).collect::<Vec<_>>().join(" "));
        text.push('\n');
    }
    json!({"source": {"value": text, "mediaType": "text/plain"}})
}

pub fn animals(count: usize, x: f64, y: f64) -> Value {
    let one = |i: usize| json!({"id": i, "x": x + 3.0 * (i % 4) as f64, "y": y + 2.0 * (i / 4) as f64, "a": 1.2, "b": 0.5, "theta": 0.1});
    (0..count).map(one).collect()
}

pub mod key_herd {
    use super::*;

    pub fn inputs() -> Value {
        json!({
            "exemplar": animals(9, 0.0, 0.0),
            "count": 12,
            "place": {"position": [50, 50], "direction": 0.5},
            "terrain": terrain(),
        })
    }

    pub fn with(change: impl Fn(&mut Value)) -> Value {
        changed(inputs(), change)
    }

    fn refused(inputs: Value, pointer: &str, code: &str) {
        assert_fault(&KeyHerd, &inputs, pointer, code);
    }

    #[test]
    fn valid_inputs_have_no_fault() {
        assert_eq!(faults(&KeyHerd, &inputs()), []);
        let by_csv =
            json!({"value": "id,x,y,a,b,theta,suspect,why\n0,1.0,2.0,1.2,0.5,0.1,false,\n", "mediaType": "text/csv"});
        assert_eq!(faults(&KeyHerd, &with(|i| i["exemplar"] = by_csv.clone())), []);
        let way = json!({"trajectory": [[10, 10], [50, 40], [90, 50]], "along": 0.5});
        assert_eq!(faults(&KeyHerd, &with(|i| i["place"] = way.clone())), []);
    }

    #[test]
    fn a_herd_of_none_is_refused() {
        refused(with(|i| i["count"] = json!(0)), "/count", "out-of-range");
        refused(with(|i| drop(i.as_object_mut().unwrap().remove("count"))), "/count", "missing");
    }

    #[test]
    fn an_exemplar_without_animals_or_with_broken_ones_is_refused() {
        refused(with(|i| i["exemplar"] = json!([])), "/exemplar", "wrong-count");
        refused(with(|i| i["exemplar"][3]["b"] = json!(2.0)), "/exemplar/3", "not-an-ellipse");
        refused(with(|i| i["exemplar"][3]["a"] = json!(-1.0)), "/exemplar/3/a", "out-of-range");
        let all_suspect = |i: &mut Value| {
            i["suspects"] = json!("leave-out");
            i["exemplar"].as_array_mut().unwrap().iter_mut().for_each(|e| e["suspect"] = json!(true));
        };
        refused(with(all_suspect), "/exemplar", "wrong-count");
    }

    #[test]
    fn a_place_is_given_in_one_way() {
        refused(with(|i| i["place"] = json!({})), "/place", "missing");
        refused(with(|i| i["place"]["trajectory"] = json!([[0, 0], [1, 1]])), "/place", "inconsistent");
        refused(with(|i| i["place"]["along"] = json!(0.5)), "/place/along", "inconsistent");
        let still = json!({"trajectory": [[5, 5], [5, 5]]});
        refused(with(|i| i["place"] = still.clone()), "/place/trajectory", "out-of-range");
    }

    #[test]
    fn a_herd_off_the_terrain_is_refused_unless_a_painted_density_says_where_it_stands() {
        let away = |i: &mut Value| i["place"]["position"] = json!([500, 50]);
        refused(with(away), "/place", "off-terrain");
        let painted = "ncols 2\nnrows 2\nxllcorner 20\nyllcorner 20\ncellsize 30\n1 1\n1 1\n";
        let map = json!({"type": "painted", "map": {"raster": {"value": painted, "mediaType": "text/plain"}}});
        let elsewhere = with(|i| {
            away(i);
            i["density"] = map.clone();
        });
        assert_eq!(faults(&KeyHerd, &elsewhere), []);
    }

    #[test]
    fn a_herd_that_an_ecosystem_does_not_have_is_refused() {
        let csv = |text: &str| json!({"value": text, "mediaType": "text/csv"});
        let herd = |number: u64, from_s: f64| {
            json!({"ecosystem_herd": {
                "herds": csv("herd,species,region,size\n0,Bison priscus,1,7\n"),
                "paths": csv("herd,species,t,x,y,z\n0,Bison priscus,10.0,20.0,50.0,0.0\n0,Bison priscus,40.0,60.0,50.0,0.0\n"),
                "herd": number,
                "from_s": from_s,
            }})
        };
        let tied = |place: Value| {
            with(|i| {
                i["place"] = place.clone();
                drop(i.as_object_mut().unwrap().remove("count"));
            })
        };
        assert_eq!(faults(&KeyHerd, &tied(herd(0, 0.0))), []);
        refused(tied(herd(1, 0.0)), "/place/ecosystem_herd/herd", "no-such-herd");
        refused(tied(herd(0, 30.0)), "/place/ecosystem_herd/herd", "no-such-herd");
    }

    #[test]
    fn bodies_obstacles_and_maps_are_checked() {
        refused(with(|i| i["body"] = json!({"length_m": 1, "width_m": 2})), "/body/width_m", "inconsistent");
        let bow = json!({"areas": [{"outer": [[0, 0], [9, 9], [9, 0], [0, 5]]}]});
        refused(with(|i| i["obstacles"] = bow.clone()), "/obstacles/areas/0", "self-crossing");
        let nothing = json!({"type": "painted", "map": {"raster": {"value": "no raster", "mediaType": "text/plain"}}});
        refused(with(|i| i["density"] = nothing.clone()), "/density/map/raster", "unreadable");
        let negative = "ncols 2\nnrows 1\nxllcorner 40\nyllcorner 40\ncellsize 10\n-1 3\n";
        let negative = json!({"type": "painted", "map": {"raster": {"value": negative, "mediaType": "text/plain"}}});
        refused(with(|i| i["density"] = negative.clone()), "/density/map", "out-of-range");
    }
}

pub mod animation {
    use super::*;

    pub fn inputs() -> Value {
        json!({
            "terrain": terrain(),
            "obstacles": {"disks": [{"x": 50, "y": 75, "radius": 4}]},
            "key_frames": [
                {"time_s": 0, "herd": animals(6, 15.0, 50.0)},
                {"time_s": 30, "position": [50, 60]},
                {"time_s": 60, "herd": animals(6, 75.0, 50.0)},
            ],
        })
    }

    pub fn with(change: impl Fn(&mut Value)) -> Value {
        changed(inputs(), change)
    }

    fn refused(inputs: Value, pointer: &str, code: &str) {
        assert_fault(&HerdAnimation, &inputs, pointer, code);
    }

    #[test]
    fn valid_inputs_have_no_fault() {
        assert_eq!(faults(&HerdAnimation, &inputs()), []);
    }

    #[test]
    fn key_frames_out_of_order_or_at_one_time_are_refused() {
        refused(with(|i| i["key_frames"][1]["time_s"] = json!(70)), "/key_frames/2/time_s", "times-not-rising");
        refused(with(|i| i["key_frames"][1]["time_s"] = json!(60)), "/key_frames/2/time_s", "times-not-rising");
    }

    #[test]
    fn a_key_frame_off_the_terrain_or_in_a_hole_is_refused() {
        refused(with(|i| i["key_frames"][1]["position"] = json!([50, 101])), "/key_frames/1", "off-terrain");
        refused(with(|i| i["key_frames"][1]["position"] = json!([3, 97])), "/key_frames/1", "off-terrain");
        refused(with(|i| i["key_frames"][2]["herd"][5]["x"] = json!(-1)), "/key_frames/2/herd/5", "off-terrain");
    }

    #[test]
    fn a_key_frame_inside_an_obstacle_is_refused() {
        refused(with(|i| i["key_frames"][1]["position"] = json!([51, 74])), "/key_frames/1", "in-obstacle");
        let stand = |i: &mut Value| {
            i["key_frames"][2]["herd"][3]["x"] = json!(50);
            i["key_frames"][2]["herd"][3]["y"] = json!(76);
        };
        refused(with(stand), "/key_frames/2/herd/3", "in-obstacle");
    }

    #[test]
    fn all_that_is_wrong_with_key_frames_is_told_at_once() {
        let wrong = with(|i| {
            i["key_frames"][0]["herd"][2]["y"] = json!(-4);
            i["key_frames"][1] = json!({"time_s": -3, "position": [50, 75]});
            i["key_frames"][2]["herd"] = animals(4, 75.0, 50.0);
        });
        let found = faults(&HerdAnimation, &wrong);
        for (pointer, code) in [
            ("/key_frames/0/herd/2", "off-terrain"),
            ("/key_frames/1/time_s", "times-not-rising"),
            ("/key_frames/1", "in-obstacle"),
            ("/key_frames/2/herd", "numbers-differ"),
        ] {
            assert!(found.contains(&(pointer.to_owned(), code.to_owned())), "{pointer} {code}: {found:?}");
        }
        assert_eq!(found.len(), 4, "{found:?}");
    }

    #[test]
    fn key_herds_of_different_numbers_are_refused() {
        refused(with(|i| i["key_frames"][2]["herd"] = animals(5, 75.0, 50.0)), "/key_frames/2/herd", "numbers-differ");
    }

    #[test]
    fn two_key_frames_one_with_a_herd_are_needed() {
        let one = |i: &mut Value| i["key_frames"].as_array_mut().unwrap().truncate(1);
        refused(with(one), "/key_frames", "wrong-count");
        let none = |i: &mut Value| {
            i["key_frames"] = json!([{"time_s": 0, "position": [10, 10]}, {"time_s": 9, "position": [20, 10]}]);
        };
        refused(with(none), "/key_frames", "wrong-count");
        refused(with(|i| i["key_frames"][0]["herd"] = json!([])), "/key_frames/0/herd", "wrong-count");
    }

    #[test]
    fn a_key_frame_is_a_position_or_a_herd() {
        refused(with(|i| i["key_frames"][1] = json!({"time_s": 30})), "/key_frames/1", "missing");
        refused(with(|i| i["key_frames"][0]["position"] = json!([5, 5])), "/key_frames/0", "inconsistent");
    }

    #[test]
    fn options_out_of_range_and_too_many_poses_are_refused() {
        refused(with(|i| i["gait"] = json!({"max_speed_m_per_s": 0})), "/gait/max_speed_m_per_s", "out-of-range");
        let sharp = json!({"metric": "power", "exponent": 9});
        refused(with(|i| i["pairing"] = sharp.clone()), "/pairing/exponent", "out-of-range");
        refused(with(|i| i["steering"] = json!({"separation": -1})), "/steering/separation", "out-of-range");
        let long = |i: &mut Value| {
            i["key_frames"][2]["time_s"] = json!(2e6);
            i["every_s"] = json!(0.1);
        };
        refused(with(long), "/every_s", "out-of-range");
    }
}
