//! What the four processes on arrangements refuse before anything is queued, and what they only
//! warn of.

use biotope::jobs::Process;
use biotope::jobs::disk_synthesis::DiskSynthesis;
use biotope::jobs::distribution_analysis::DistributionAnalysis;
use biotope::jobs::distribution_decomposition::DistributionDecomposition;
use biotope::jobs::distribution_inpainting::DistributionInpainting;
use biotope::jobs::schema::InputCheck;
use biotope::jobs::sources::ByValueOnly;
use serde_json::Value;
use serde_json::json;

/// A small pattern of two classes in a square of 10 m.
fn inputs() -> Value {
    let elements: Vec<Value> = (0..12)
        .map(|k| {
            let class = if k < 4 { "tree" } else { "grass" };
            json!({"class": class, "x": 0.5 + f64::from(k) * 0.8, "y": f64::from(k * 7 % 10) + 0.3, "radius": 0.2})
        })
        .collect();
    let domain = json!({"type": "rectangle", "min": [0, 0], "max": [10, 10]});
    json!({"exemplar": {"elements": elements, "domain": domain}})
}

fn with(change: impl Fn(&mut Value)) -> Value {
    let mut all = inputs();
    change(&mut all);
    all
}

/// The faults found in `inputs`: (pointer, code), each with something expected and found.
fn faults(process: &dyn Process, inputs: Value) -> Vec<(String, String)> {
    let check = InputCheck::new(&process.description().inputs).expect("a valid schema");
    let faults = match check.check(&inputs) {
        Ok(()) => process.parse(inputs, &ByValueOnly).err(),
        Err(faults) => Some(faults),
    };
    let errors = faults.map(|f| f.errors).unwrap_or_default();
    assert!(errors.iter().all(|e| !e.expected.is_empty() && !e.found.is_empty()), "{errors:?}");
    errors.into_iter().map(|e| (e.pointer, e.code)).collect()
}

fn assert_fault(process: &dyn Process, inputs: Value, pointer: &str, code: &str) {
    let found = faults(process, inputs);
    assert!(found.contains(&(pointer.to_owned(), code.to_owned())), "expected {pointer} {code}, found {found:?}");
}

/// Asserts a fault of the exemplar, which all four processes read alike.
fn assert_refused(change: impl Fn(&mut Value), pointer: &str, code: &str) {
    assert_refused_by(&[&DistributionAnalysis, &DiskSynthesis, &DistributionInpainting], &change, pointer, code);
    let clustered = |i: &mut Value| {
        i["clusters"] = json!(2);
        change(i);
    };
    assert_refused_by(&[&DistributionDecomposition], clustered, pointer, code);
}

/// The same for some of them.
fn assert_refused_by(processes: &[&dyn Process], change: impl Fn(&mut Value), pointer: &str, code: &str) {
    for process in processes {
        assert_fault(*process, with(&change), pointer, code);
    }
}

#[test]
fn valid_inputs_have_no_fault() {
    for process in [&DistributionAnalysis as &dyn Process, &DiskSynthesis, &DistributionInpainting] {
        assert_eq!(faults(process, inputs()), []);
    }
    assert_eq!(faults(&DistributionDecomposition, with(|i| i["clusters"] = json!(3))), []);
}

#[test]
fn fewer_than_two_elements_are_refused() {
    assert_refused(|i| i["exemplar"]["elements"] = json!([]), "/exemplar/elements", "wrong-count");
    assert_refused(|i| i["exemplar"]["elements"] = json!([{"x": 1, "y": 1}]), "/exemplar/elements", "wrong-count");
}

#[test]
fn duplicates_are_refused_but_a_place_shared_by_two_classes_is_not() {
    let copy = |i: &mut Value, class: &str| {
        let mut twin = i["exemplar"]["elements"][5].clone();
        twin["class"] = json!(class);
        i["exemplar"]["elements"].as_array_mut().unwrap().push(twin);
    };
    assert_refused(|i| copy(i, "grass"), "/exemplar/elements/12", "duplicate-elements");
    assert_eq!(faults(&DistributionAnalysis, with(|i| copy(i, "tree"))), []);
}

#[test]
fn elements_on_one_line_have_no_free_form_border() {
    let line = |i: &mut Value| {
        let elements: Vec<Value> = (0..9).map(|k| json!({"x": k, "y": 2 * k})).collect();
        i["exemplar"] = json!({"elements": elements, "domain": {"type": "free-form"}});
    };
    assert_refused(line, "/exemplar/elements", "no-border");
}

#[test]
fn elements_outside_the_domain_are_named() {
    assert_refused(|i| i["exemplar"]["elements"][3]["x"] = json!(40), "/exemplar/elements/3", "outside-domain");
}

#[test]
fn numbers_that_are_none_and_negative_radii_are_named() {
    assert_refused(
        |i| i["exemplar"]["elements"][2]["radius"] = json!(-1),
        "/exemplar/elements/2/radius",
        "out-of-range",
    );
    assert_refused(|i| i["exemplar"]["elements"][2]["x"] = json!("NaN"), "/exemplar/elements/2/x", "wrong-type");
    let table = |cell: &str| json!({"value": format!("x,y\n1,2\n{cell},3\n5,6\n"), "mediaType": "text/csv"});
    for cell in ["NaN", "nan", "inf", "-inf", "1e999"] {
        assert_refused(|i| i["exemplar"]["elements"] = table(cell), "/exemplar/elements/1/x", "out-of-range");
    }
    let radii = |cell: &str| json!({"value": format!("x,y,radius\n1,2,0.1\n4,3,{cell}\n"), "mediaType": "text/csv"});
    for cell in ["nan", "inf", "-0.1"] {
        assert_refused(|i| i["exemplar"]["elements"] = radii(cell), "/exemplar/elements/1/radius", "out-of-range");
    }
    // Beyond the largest number of JSON, in a document behind a reference.
    let list = json!({"value": r#"[{"x": 1e999, "y": 1}, {"x": 2, "y": 1}]"#, "mediaType": "application/json"});
    assert_refused(|i| i["exemplar"]["elements"] = list.clone(), "/exemplar/elements", "unreadable");
}

#[test]
fn a_circle_of_dependencies_is_named_and_so_is_a_class_without_elements() {
    let depends = |class: &str, on: &str| json!({"class": class, "depends_on": [on]});
    let circle = json!([depends("tree", "grass"), depends("grass", "tree")]);
    let process = DistributionAnalysis;
    let refused = process.parse(with(|i| i["exemplar"]["dependencies"] = circle.clone()), &ByValueOnly).err().unwrap();
    assert_eq!(refused.errors[0].code, "dependency-cycle");
    assert_eq!(refused.errors[0].found, "tree → grass → tree");
    assert_refused(
        |i| i["exemplar"]["dependencies"] = json!([depends("moss", "tree")]),
        "/exemplar/dependencies/0/class",
        "empty-class",
    );
}

#[test]
fn a_domain_without_area_or_that_crosses_itself_is_refused() {
    let flat = json!({"type": "rectangle", "min": [0, 0], "max": [10, 0]});
    assert_refused(|i| i["exemplar"]["domain"] = flat.clone(), "/exemplar/domain", "zero-area");
    let bow = json!({"type": "polygons", "polygons": [{"outer": [[0, 0], [10, 10], [10, 0], [0, 11]]}]});
    assert_refused(|i| i["exemplar"]["domain"] = bow.clone(), "/exemplar/domain/polygons/0", "self-crossing");
    let line = json!({"type": "polygons", "polygons": [{"outer": [[0, 0], [5, 5], [10, 10]]}]});
    assert_refused(|i| i["exemplar"]["domain"] = line.clone(), "/exemplar/domain", "zero-area");
}

#[test]
fn a_kernel_or_step_that_makes_no_sense_is_refused() {
    assert_refused(|i| i["exemplar"]["sigma"] = json!(0), "/exemplar/sigma", "out-of-range");
    assert_refused(|i| i["exemplar"]["sigma"] = json!(-0.2), "/exemplar/sigma", "out-of-range");
    assert_refused(|i| i["exemplar"]["sigma"] = json!(1e9), "/exemplar/sigma", "out-of-range");
    assert_refused(|i| i["exemplar"]["step"] = json!(9), "/exemplar/step", "out-of-range");
}

#[test]
fn a_count_that_cannot_fit_or_of_an_unknown_class_is_refused() {
    let counts = |counts: Value| with(|i| i["target"] = json!({"counts": counts}));
    assert_fault(&DiskSynthesis, counts(json!({"grass": 100_000})), "/target/counts", "cannot-fit");
    assert_fault(&DiskSynthesis, counts(json!({"grass": 100_000_000})), "/target/counts", "out-of-range");
    assert_fault(&DiskSynthesis, counts(json!({"moss": 3})), "/target/counts/moss", "empty-class");
}

#[test]
fn a_target_of_which_nothing_is_left_is_refused() {
    let all = json!({"type": "rectangle", "min": [-1, -1], "max": [11, 11]});
    let target = with(|i| i["target"] = json!({"exclude": [all]}));
    assert_fault(&DiskSynthesis, target, "/target/exclude/0", "zero-area");
}

#[test]
fn fixed_elements_of_unknown_classes_or_outside_the_domain_are_refused_but_not_those_cut_out_of_it() {
    let fixed = |class: &str, x: i32| {
        let hole = json!({"type": "rectangle", "min": [0, 0], "max": [2, 2]});
        let there = json!([{"class": class, "x": x, "y": 1}]);
        with(move |i| i["target"] = json!({"fixed": there, "exclude": [hole]}))
    };
    assert_fault(&DiskSynthesis, fixed("moss", 1), "/target/fixed/0/class", "empty-class");
    assert_fault(&DiskSynthesis, fixed("tree", 40), "/target/fixed/0", "outside-domain");
    assert_eq!(faults(&DiskSynthesis, fixed("tree", 1)), []);
}

#[test]
fn a_density_of_zeros_or_below_is_refused() {
    let grid = |value: &str| json!({"value": format!("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n{value} 0\n0 0\n"), "mediaType": "text/plain"});
    for value in ["0", "-1"] {
        let painted = with(|i| i["target"] = json!({"density": {"raster": grid(value)}}));
        assert_fault(&DiskSynthesis, painted, "/target/density", "out-of-range");
    }
}

#[test]
fn more_clusters_than_elements_are_refused() {
    assert_fault(&DistributionDecomposition, with(|i| i["clusters"] = json!(13)), "/clusters", "out-of-range");
    assert_fault(&DistributionDecomposition, with(|i| i["clusters"] = json!(0)), "/clusters", "out-of-range");
}

#[test]
fn an_element_outside_the_whole_domain_of_an_inpainting_is_named() {
    let small = json!({"type": "rectangle", "min": [0, 0], "max": [5, 10]});
    let found = faults(&DistributionInpainting, with(|i| i["domain"] = small.clone()));
    assert!(found.iter().any(|(p, c)| p.starts_with("/exemplar/elements/") && c == "outside-domain"), "{found:?}");
}
