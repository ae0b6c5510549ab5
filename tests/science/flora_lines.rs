//! The ablation studies and the comparison of climates (L 7.2, figures 8 and 13) on the terrains of
//! the examples: each line where it holds. `cargo test --test integration figures -- --ignored
//! --nocapture` prints all of them, as they stand in the README.

use std::path::Path;
use std::sync::LazyLock;

use crate::science::flora_study::Densest;
use crate::science::flora_study::Land;
use crate::science::flora_study::TreeCover;
use crate::science::flora_study::densest_cells;
use crate::science::flora_study::tree_cover;
use crate::science::tautavel;
use biotope::codec::terrain::Terrain;
use biotope::codec::terrain::TerrainOptions;
use biotope::compute::ecosystem::fitness::Needs;
use biotope::compute::ecosystem::species::Stratum;
use biotope::compute::ecosystem::valley::Valley;
use biotope::compute::ecosystem::valley::ValleyOptions;

/// What is measured in one land.
#[derive(Debug)]
struct Study {
    full: Densest,
    no_moisture: Densest,
    no_light: Densest,
    no_temperature: Densest,
    relief_m: f64,
    trees: TreeCover,
    strata: [f64; 3],
}

impl Study {
    fn of(land: &Land) -> Self {
        let species = tautavel::plants();
        let grown = |needs: Needs| land.flora(&species, needs).0;
        let densest = |needs: Needs| densest_cells(land, &grown(needs));
        let flora = grown(Needs::default());
        let known = land.terrain.height.data.iter().filter(|h| !h.is_nan()).count() as f64;
        let mean = |stratum| flora.stratum_map(&species, stratum).data.iter().map(|c| f64::from(*c)).sum::<f64>();
        Self {
            full: densest_cells(land, &flora),
            no_moisture: densest(Needs { moisture: false, ..Needs::default() }),
            no_light: densest(Needs { illumination: false, ..Needs::default() }),
            no_temperature: densest(Needs { temperature: false, ..Needs::default() }),
            relief_m: land.relief_m(),
            trees: tree_cover(land, &species, &flora),
            strata: Stratum::ALL.map(|stratum| mean(stratum) / known),
        }
    }

    /// By how much the mean cosine of the aspect from south rises without the need for moisture.
    fn southness_gained(&self) -> f64 {
        self.no_moisture.southness - self.full.southness
    }

    /// By how much the mean moisture rises without the need for light.
    fn moisture_gained(&self) -> f64 {
        self.no_light.moisture - self.full.moisture
    }

    /// By how much of the relief the mean height rises without bounds of temperature.
    fn height_gained(&self) -> f64 {
        (self.no_temperature.height_m - self.full.height_m) / self.relief_m
    }
}

fn jacksboro(climate: &str) -> Study {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples/jacksboro.tif");
    let terrain = Terrain::read(&std::fs::read(path).unwrap(), &TerrainOptions::default()).unwrap();
    Study::of(&Land::new(terrain.height, &tautavel::climate(climate)))
}

fn valley(climate: &str) -> Study {
    let valley = Valley::generate(&ValleyOptions::default());
    Study::of(&Land::of_water(valley.height, &valley.water_depth_m, &tautavel::climate(climate)))
}

static MILD: LazyLock<Study> = LazyLock::new(|| jacksboro("mild"));
static ICE_AGE: LazyLock<Study> = LazyLock::new(|| jacksboro("ice_age"));

#[test]
fn without_the_need_for_moisture_the_densest_plants_stand_on_sunny_slopes() {
    assert!(MILD.southness_gained() >= 0.2, "{:?}", *MILD);
}

#[test]
fn without_the_need_for_light_the_densest_plants_stand_where_it_is_moist() {
    assert!(MILD.moisture_gained() >= 0.5, "{:?}", *MILD);
}

#[test]
fn without_bounds_of_temperature_the_densest_plants_stand_higher() {
    assert!(ICE_AGE.height_gained() >= 0.1, "{:?}", *ICE_AGE);
}

#[test]
fn an_ice_age_leaves_fewer_trees_and_those_on_south_slopes() {
    let (mild, ice_age) = (MILD.trees, ICE_AGE.trees);
    assert!(ice_age.mean <= 0.7 * mild.mean, "{mild:?} {ice_age:?}");
    assert!(ice_age.south >= 1.5 * ice_age.north, "{ice_age:?}");
}

#[test]
#[ignore = "prints the figures of the README"]
fn figures() {
    for (name, study) in [
        ("jacksboro, mild", &*MILD),
        ("jacksboro, ice age", &*ICE_AGE),
        ("valley, mild", &valley("mild")),
        ("valley, ice age", &valley("ice_age")),
    ] {
        println!("{name}");
        println!(
            "  gained: southness {:+.2}, moisture {:+.2}, height/relief {:+.2}",
            study.southness_gained(),
            study.moisture_gained(),
            study.height_gained()
        );
        println!("  trees {:?}; cover of trees, shrubs, herbs {:.3?}", study.trees, study.strata);
        println!("  densest: {:?}", study.full);
    }
}
