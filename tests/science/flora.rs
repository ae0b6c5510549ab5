//! The competition of plants: invariants over random small worlds, and worlds made by hand whose
//! answer is known.

use biotope::compute::ecosystem::fitness::Fitness;
use biotope::compute::ecosystem::fitness::FitnessOptions;
use biotope::compute::ecosystem::fitness::MonthRule;
use biotope::compute::ecosystem::fitness::Needs;
use biotope::compute::ecosystem::fitness::fitness;
use biotope::compute::ecosystem::fitness::share_in_range;
use biotope::compute::ecosystem::flora;
use biotope::compute::ecosystem::flora::Absence;
use biotope::compute::ecosystem::flora::Flora;
use biotope::compute::ecosystem::flora::FloraError;
use biotope::compute::ecosystem::flora::FloraOptions;
use biotope::compute::ecosystem::resources::MONTHS;
use biotope::compute::ecosystem::resources::MonthlyMap;
use biotope::compute::ecosystem::resources::Resources;
use biotope::compute::ecosystem::scales::Scales;
use biotope::compute::ecosystem::species::Interval;
use biotope::compute::ecosystem::species::Need;
use biotope::compute::ecosystem::species::PlantSpecies;
use biotope::compute::ecosystem::species::Soil;
use biotope::compute::ecosystem::species::Stratum;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use proptest::prelude::*;

/// A plant that needs nothing in particular and covers a third of a cell by a unit.
pub fn plant(name: &str, stratum: Stratum) -> PlantSpecies {
    let any = |consumption| Need { range: Interval::new(-100.0, 100.0), consumption };
    PlantSpecies {
        name: name.to_owned(),
        stratum,
        illumination: Need { range: Interval::new(1.0, 9.0), consumption: 3.0 },
        temperature: any(0.0),
        moisture: any(1.0),
        texture: any(0.0),
        viability: [1.0; 5],
        survival_min_c: None,
        growth_kg_per_m2: 0.5,
        offtake: 0.3,
        target: None,
    }
}

/// Uniform ground: fully lit, 10 ± 5 °C, moisture and texture 5, limestone.
pub fn plain(grid: Grid) -> Resources {
    let shifted = |value: f32| MonthlyMap::Shifted { base: Raster::filled(grid, value), offset: [0.0; MONTHS] };
    Resources {
        temperature_min_c: shifted(5.0),
        temperature_max_c: shifted(15.0),
        sunlight: shifted(0.25),
        moisture: shifted(5.0),
        texture: Raster::filled(grid, 5.0),
        soil: Raster::filled(grid, Soil::Limestone as u8),
    }
}

fn solve(species: &[PlantSpecies], resources: &Resources, options: &FloraOptions) -> (Flora, Fitness) {
    let fit_options = FitnessOptions { needs: options.needs, scales: options.scales, ..FitnessOptions::default() };
    let fit = fitness(&Run::silent(), species, resources, &fit_options).unwrap();
    (flora::compete(&Run::silent(), species, resources, &fit, options).unwrap(), fit)
}

fn mean_cover(flora: &Flora, species: usize) -> f64 {
    let total: f64 = flora.cover_map(species).data.iter().map(|c| f64::from(*c)).sum();
    total / flora.left_light.grid.len() as f64
}

/// Every invariant of a competition, worked out anew from the covers alone.
fn hold_invariants(species: &[PlantSpecies], resources: &Resources, flora: &Flora, fit: &Fitness) {
    let scale = Scales::default().illumination;
    for cell in 0..resources.soil.data.len() {
        let covers: Vec<f64> = (0..species.len()).map(|s| f64::from(flora.cover(s, cell))).collect();
        let year = |map: &MonthlyMap| (0..MONTHS).map(|m| f64::from(map.value(m, cell))).sum::<f64>() / MONTHS as f64;
        let capacity = year(&resources.moisture).max(0.0);
        let stratum = |stratum: Stratum| -> f64 {
            covers.iter().zip(species).filter(|(_, p)| p.stratum == stratum).map(|(c, _)| c).sum()
        };
        let drawn: f64 = covers.iter().zip(species).map(|(c, p)| c * p.moisture.consumption).sum();
        assert!(drawn <= capacity + 1e-3, "drawn {drawn} of {capacity}");
        let light = layers(resources, Stratum::ALL.map(stratum), cell);
        for (s, plant) in species.iter().enumerate() {
            assert!(stratum(plant.stratum) <= 1.0 + 1e-6, "a stratum covers more than its cell");
            if covers[s] == 0.0 {
                continue;
            }
            assert!(fit.value(s, cell) > 0.0, "{} grows where its fitness is 0", plant.name);
            let Layer { light, borne } = light[plant.stratum as usize];
            let scaled = scale.clamped(light);
            assert!(scaled >= plant.illumination.range.min - 1e-3, "{} has light {scaled}", plant.name);
            assert!(stratum(plant.stratum) <= borne + 1e-3, "{} draws more light than there is", plant.name);
        }
        agree(flora.left_light.data[cell], light[Stratum::Herb as usize].light);
        let no_data = (0..MONTHS).any(|m| resources.moisture.value(m, cell).is_nan());
        agree(flora.left_moisture.data[cell], if no_data { f64::NAN } else { (capacity - drawn).max(0.0) });
    }
}

/// What reaches one stratum: the light of the growing season, and the cover that the light of the
/// year bears.
#[derive(Debug, Clone, Copy)]
struct Layer {
    light: f64,
    borne: f64,
}

/// What reaches trees, shrubs and herbs of a cell when they cover so much of it.
fn layers(resources: &Resources, covers: [f64; 3], cell: usize) -> [Layer; 3] {
    let scale = Scales::default().illumination;
    let (mut light, mut year) = (growing_light(resources, cell), usable_light(resources, cell));
    covers.map(|cover| {
        // In whole parts, as covers are: where the light bears next to nothing, they tell.
        let borne = if year.is_nan() { 0.0 } else { (scale.at(year) / 9.0).clamp(0.0, 1.0) };
        let borne = (borne * f64::from(flora::FULL_COVER)).round() / f64::from(flora::FULL_COVER);
        let layer = Layer { light, borne };
        let closed = if cover > 0.0 { cover / borne.max(cover) } else { 0.0 };
        (light, year) = (light * (1.0 - 0.8 * closed), year * (1.0 - 0.8 * closed));
        layer
    })
}

/// Mean over the year of the light that falls at 5 °C and more.
fn usable_light(resources: &Resources, cell: usize) -> f64 {
    let warm = |m: usize| {
        let at = |map: &MonthlyMap| f64::from(map.value(m, cell));
        let (low, high) = (at(&resources.temperature_min_c), at(&resources.temperature_max_c));
        if low.is_nan() || high.is_nan() { 0.0 } else { ((high - 5.0) / (high - low)).clamp(0.0, 1.0) }
    };
    (0..MONTHS).map(|m| warm(m) * f64::from(resources.sunlight.value(m, cell))).sum::<f64>() / MONTHS as f64
}

/// Mean light of the months of 5 °C and more, else of the warmest.
fn growing_light(resources: &Resources, cell: usize) -> f64 {
    let mean_c =
        |m: usize| 0.5 * (resources.temperature_min_c.value(m, cell) + resources.temperature_max_c.value(m, cell));
    let light = |m: usize| f64::from(resources.sunlight.value(m, cell));
    let season: Vec<usize> = (0..MONTHS).filter(|m| mean_c(*m) >= 5.0).collect();
    if season.is_empty() {
        let warmest = (0..MONTHS).filter(|m| !mean_c(*m).is_nan()).max_by(|a, b| mean_c(*a).total_cmp(&mean_c(*b)));
        return warmest.map_or(f64::NAN, light);
    }
    season.iter().map(|m| light(*m)).sum::<f64>() / season.len() as f64
}

fn agree(found: f32, expected: f64) {
    let found = f64::from(found);
    assert!(found.is_nan() && expected.is_nan() || (found - expected).abs() < 1e-3, "{found} {expected}");
}

/// In no cell is there a species of which another unit would fit.
fn nothing_fits(species: &[PlantSpecies], resources: &Resources, flora: &Flora, fit: &Fitness) {
    let scale = Scales::default().illumination;
    for cell in 0..resources.soil.data.len() {
        for (_s, plant) in species.iter().enumerate().filter(|(s, _)| fit.value(*s, cell) > 0.0) {
            let sum = |t: Stratum| -> f64 {
                (0..species.len()).filter(|o| species[*o].stratum == t).map(|o| f64::from(flora.cover(o, cell))).sum()
            };
            let Layer { light, borne } = layers(resources, Stratum::ALL.map(sum), cell)[plant.stratum as usize];
            let unit = (plant.illumination.consumption / 9.0).min(borne - sum(plant.stratum));
            let watered = unit * plant.moisture.consumption <= f64::from(flora.left_moisture.data[cell]) - 1e-3;
            let lit = scale.clamped(light) >= plant.illumination.range.min + 1e-3;
            assert!(unit < 1e-3 || !watered || !lit, "a unit of {} still fits in cell {cell}", plant.name);
        }
    }
}

fn random_plant(stream: &mut Stream, index: usize) -> PlantSpecies {
    let mut range = |low: f64, high: f64| {
        let (a, b) = (stream.range(low, high), stream.range(low, high));
        Interval::new(a.min(b), a.max(b) + 1.0)
    };
    let ranges = [range(1.0, 8.0), range(1.0, 8.0), range(1.0, 8.0), range(1.0, 8.0)];
    let need = |range, consumption| Need { range, consumption };
    PlantSpecies {
        illumination: need(ranges[0], stream.range(0.2, 9.0)),
        temperature: need(ranges[1], 0.0),
        moisture: need(ranges[2], stream.range(0.0, 6.0)),
        texture: need(ranges[3], 0.0),
        viability: std::array::from_fn(|_| if stream.below(4) == 0 { 0.0 } else { stream.range(0.3, 1.0) }),
        survival_min_c: (stream.below(3) == 0).then(|| stream.range(-20.0, 0.0)),
        ..plant(&format!("plant {index}"), Stratum::ALL[stream.below(3)])
    }
}

/// A small world of no system: every map is noise, with a cell without data now and then.
fn random_world(seed: u64, cells: usize, kinds: usize) -> (Vec<PlantSpecies>, Resources) {
    let mut stream = Stream::new(seed, Purpose::new("science.flora.world"), 0);
    let grid = Grid::new(cells, 1, 10.0);
    let map = |low: f64, high: f64, stream: &mut Stream| {
        let value = |_| if stream.below(40) == 0 { f32::NAN } else { stream.range(low, high) as f32 };
        Raster { grid, data: (0..cells).map(value).collect() }
    };
    let base = map(-6.0, 6.0, &mut stream);
    let season = |m: usize| (10.0 - 8.0 * (m as f64 * std::f64::consts::TAU / 12.0).cos()) as f32;
    let light = (0..MONTHS).map(|_| map(0.02, 0.4, &mut stream)).collect();
    let resources = Resources {
        temperature_min_c: MonthlyMap::Shifted { base: base.clone(), offset: std::array::from_fn(|m| season(m) - 6.0) },
        temperature_max_c: MonthlyMap::Shifted { base, offset: std::array::from_fn(|m| season(m) + 6.0) },
        sunlight: MonthlyMap::Maps(light),
        moisture: MonthlyMap::Shifted {
            base: map(-1.0, 9.0, &mut stream),
            offset: std::array::from_fn(|m| 0.1 * m as f32 - 0.5),
        },
        texture: map(1.0, 9.0, &mut stream),
        soil: Raster { grid, data: (0..cells).map(|_| stream.below(5) as u8).collect() },
    };
    let species = (0..kinds).map(|i| random_plant(&mut stream, i)).collect();
    (species, resources)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn without_targets_every_invariant_holds_and_nothing_more_fits(seed: u64, cells in 1_usize..60, kinds in 1_usize..9) {
        let (species, resources) = random_world(seed, cells, kinds);
        let (flora, fit) = solve(&species, &resources, &FloraOptions { seed, ..FloraOptions::default() });
        hold_invariants(&species, &resources, &flora, &fit);
        nothing_fits(&species, &resources, &flora, &fit);
    }

    #[test]
    fn with_targets_every_invariant_holds(seed: u64, cells in 1_usize..60, kinds in 1_usize..9, fill: bool) {
        let (mut species, resources) = random_world(seed, cells, kinds);
        species.iter_mut().enumerate().for_each(|(i, p)| p.target = Some(1.0 + i as f64));
        let options = FloraOptions { seed, fill, ..FloraOptions::default() };
        let (flora, fit) = solve(&species, &resources, &options);
        hold_invariants(&species, &resources, &flora, &fit);
        if fill {
            nothing_fits(&species, &resources, &flora, &fit);
        }
        let reached = flora.reached.unwrap();
        prop_assert!((reached.asked.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let sum: f64 = reached.reached.iter().sum();
        prop_assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-9);
    }

    #[test]
    fn batches_of_units_end_where_single_units_do(seed: u64, cells in 200_usize..500, kinds in 2_usize..6) {
        let (mut species, resources) = random_world(seed, cells, kinds);
        species.iter_mut().enumerate().for_each(|(i, p)| p.target = Some(1.0 + (i % 3) as f64));
        let options = FloraOptions { seed, ..FloraOptions::default() };
        let (batches, fit) = solve(&species, &resources, &options);
        let single = FloraOptions { batch: 0.0, ..options };
        let singles = flora::compete(&Run::silent(), &species, &resources, &fit, &single).unwrap();
        let (a, b) = (batches.reached.clone().unwrap(), singles.reached.clone().unwrap());
        // Each may stop anywhere within the tolerance of what is asked, on either side.
        let apart = 2.0 * options.proportion_tolerance;
        for s in 0..species.len() {
            prop_assert!((a.reached[s] - b.reached[s]).abs() <= apart, "{a:?} {b:?}");
            let (cover, other) = (mean_cover(&batches, s), mean_cover(&singles, s));
            prop_assert!((cover - other).abs() <= apart, "{s}: {cover} {other}");
        }
    }

    #[test]
    fn painting_and_clearing_keep_every_invariant(seed: u64, cells in 1_usize..60, kinds in 1_usize..9) {
        let (species, resources) = random_world(seed, cells, kinds);
        let options = FloraOptions { seed, ..FloraOptions::default() };
        let (flora, fit) = solve(&species, &resources, &options);
        let mut stream = Stream::new(seed, Purpose::new("science.flora.paint"), 0);
        let grid = resources.soil.grid;
        let wish = |_| if stream.below(3) == 0 { f32::NAN } else { stream.unit() as f32 };
        let wanted = Raster { grid, data: (0..cells).map(wish).collect() };
        let before = flora.cover_map(0);
        let (flora, done) =
            flora::paint(&Run::silent(), &species, (&resources, &fit), (flora, 0, &wanted), &options).unwrap();
        hold_invariants(&species, &resources, &flora, &fit);
        let missing: f64 = (0..cells)
            .filter(|c| wanted.data[*c].is_finite())
            .map(|c| f64::from(wanted.data[c] - flora.cover(0, c)).max(0.0))
            .sum();
        let told = done.shortfall.map_or(0.0, |s| s.area_m2) / grid.cell_area_m2();
        prop_assert!((missing - told).abs() < 1e-3 * cells as f64, "missing {missing}, told {told}");
        for c in 0..cells {
            let kept = wanted.data[c].is_nan() && flora.cover(0, c) == before.data[c];
            let painted = flora.cover(0, c) <= wanted.data[c] + 1e-4;
            prop_assert!(kept || painted || wanted.data[c].is_nan() && species[0].stratum != Stratum::Tree);
        }
        let share = wanted.map(|v| v);
        let cleared = flora::clear(&Run::silent(), &species, (&resources, &fit), (flora, &share), &options).unwrap();
        hold_invariants(&species, &resources, &cleared, &fit);
    }

    #[test]
    fn the_table_of_temperatures_gives_the_fitness_of_the_formula(seed: u64, minimum: bool) {
        let (species, resources) = random_world(seed, 40, 6);
        let months = if minimum { MonthRule::Minimum } else { MonthRule::Mean };
        let options = FitnessOptions { months, tree_line_c: None, ..FitnessOptions::default() };
        let fit = fitness(&Run::silent(), &species, &resources, &options).unwrap();
        for (s, plant) in species.iter().enumerate() {
            for cell in 0..40 {
                let expected = formula(plant, &resources, (months, cell));
                // Half a step of the byte, and what 1/256 °C moves twelve months by.
                prop_assert!((fit.value(s, cell) - expected).abs() < 0.004, "{} {expected}", fit.value(s, cell));
            }
        }
        let maps = |map: &MonthlyMap| MonthlyMap::Maps((0..MONTHS).map(|m| map.month(m)).collect());
        let same = Resources {
            temperature_min_c: maps(&resources.temperature_min_c),
            temperature_max_c: maps(&resources.temperature_max_c),
            moisture: maps(&resources.moisture),
            ..resources
        };
        let direct = fitness(&Run::silent(), &species, &same, &options).unwrap();
        for (a, b) in fit.levels.iter().flat_map(|m| &m.data).zip(direct.levels.iter().flat_map(|m| &m.data)) {
            prop_assert!(a.abs_diff(*b) <= 1);
        }
    }
}

/// T eq. 5.4 for one species and cell, term by term.
fn formula(plant: &PlantSpecies, resources: &Resources, (months, cell): (MonthRule, usize)) -> f64 {
    let scales = Scales::default();
    let year = |need: &Need, value: &dyn Fn(usize) -> (f64, f64)| {
        let shares = std::array::from_fn(|m| {
            let (low, high) = value(m);
            share_in_range(need.range, low, high)
        });
        months.combine(&shares)
    };
    let single = |v: f64| (v, v);
    let temperature = |m: usize| {
        let at = |map: &MonthlyMap| scales.temperature.at(f64::from(map.value(m, cell)));
        (at(&resources.temperature_min_c), at(&resources.temperature_max_c))
    };
    let coldest = (0..MONTHS).map(|m| resources.temperature_min_c.value(m, cell)).fold(f32::INFINITY, f32::min);
    if plant.survival_min_c.is_some_and(|bound| coldest < bound as f32) {
        return 0.0;
    }
    let light = |m: usize| single(scales.illumination.clamped(f64::from(resources.sunlight.value(m, cell))));
    let least = year(&plant.illumination, &light)
        .min(year(&plant.temperature, &temperature))
        .min(year(&plant.moisture, &|m| single(f64::from(resources.moisture.value(m, cell)))))
        .min(year(&plant.texture, &|_| single(f64::from(resources.texture.data[cell]))));
    least * plant.viability[usize::from(resources.soil.data[cell])]
}

#[test]
fn one_and_two_threads_give_the_same_plants() {
    let (mut species, resources) = random_world(11, 9000, 8);
    let on = |threads: usize, species: &[PlantSpecies]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(species, &resources, &FloraOptions { fill: true, ..FloraOptions::default() }).0.covers)
    };
    assert_eq!(on(1, &species), on(2, &species));
    species.iter_mut().for_each(|p| p.target = Some(1.0));
    assert_eq!(on(1, &species), on(2, &species));
}

#[test]
fn another_seed_draws_other_winners_among_equals() {
    let species = [plant("a", Stratum::Tree), plant("b", Stratum::Tree)];
    let world = plain(Grid::new(20, 20, 10.0));
    let of = |seed| solve(&species, &world, &FloraOptions { seed, ..FloraOptions::default() }).0.covers;
    assert_ne!(of(1), of(2));
}

#[test]
fn a_sun_lover_dies_below_a_closed_canopy_and_a_shade_plant_stays() {
    let mut sun = plant("sun herb", Stratum::Herb);
    sun.illumination.range = Interval::new(5.0, 9.0);
    let mut shade = plant("shade herb", Stratum::Herb);
    // Full light counts as 9, a fifth of it as 1 + 8 (0.05 - 0.01) / 0.24 = 2.33.
    shade.illumination.range = Interval::new(2.3, 9.0);
    let mut tree = plant("tree", Stratum::Tree);
    tree.viability = [0.9; 5];
    let species = [sun, shade, tree];
    let (flora, fit) = solve(&species, &plain(Grid::new(4, 4, 10.0)), &FloraOptions::default());
    hold_invariants(&species, &plain(Grid::new(4, 4, 10.0)), &flora, &fit);
    assert_eq!([0, 2].map(|s| mean_cover(&flora, s)), [0.0, 1.0]);
    assert!((mean_cover(&flora, 1) - 2.3333 / 9.0).abs() < 1e-4, "as thin as the light there is");
    assert!(matches!(flora.totals[0].why_empty, Some(Absence::Outcompeted(c)) if c.shaded == 16));
}

#[test]
fn half_the_light_bears_half_the_cover_and_frozen_months_bear_none() {
    let cover = |light: f32, cold_months: usize, needs: Needs| {
        let mut world = plain(Grid::new(2, 2, 10.0));
        let offset = |c: f32| std::array::from_fn(|m| if m < cold_months { c - 20.0 } else { c });
        let shifted = |offset| MonthlyMap::Shifted { base: Raster::filled(Grid::new(2, 2, 10.0), 0.0), offset };
        (world.temperature_min_c, world.temperature_max_c) = (shifted(offset(5.0)), shifted(offset(15.0)));
        world.sunlight = shifted([light; MONTHS]);
        mean_cover(&solve(&[plant("grass", Stratum::Herb)], &world, &FloraOptions { needs, ..Default::default() }).0, 0)
    };
    // 4.5 on the scale is 0.01 + 0.24 · 3.5 / 8.
    assert!((cover(0.115, 0, Needs::default()) - 0.5).abs() < 1e-4);
    // Six months of 0.22 are 0.11 over the year, 4.3333 on the scale.
    assert!((cover(0.22, 6, Needs::default()) - 4.3333 / 9.0).abs() < 1e-4);
    assert!((cover(0.22, 6, Needs { temperature: false, ..Needs::default() }) - 8.0 / 9.0).abs() < 1e-4);
    assert_eq!(cover(0.115, 0, Needs { illumination: false, ..Needs::default() }), 1.0);
}

#[test]
fn herbs_never_keep_trees_out_by_shade() {
    let mut herb = plant("herb", Stratum::Herb);
    herb.moisture.consumption = 0.2;
    let mut tree = plant("tree", Stratum::Tree);
    tree.viability = [0.3; 5];
    tree.illumination.range = Interval::new(7.0, 9.0);
    let (flora, _) = solve(&[herb, tree], &plain(Grid::new(4, 4, 10.0)), &FloraOptions::default());
    assert_eq!(mean_cover(&flora, 1), 1.0);
}

#[test]
fn a_meadow_can_be_full_and_a_forest_closed() {
    let grid = Grid::new(8, 8, 10.0);
    let meadow = [plant("grass", Stratum::Herb)];
    assert_eq!(mean_cover(&solve(&meadow, &plain(grid), &FloraOptions::default()).0, 0), 1.0);
    let mut oak = plant("oak", Stratum::Tree);
    oak.illumination.consumption = 5.0;
    oak.moisture.consumption = 5.0;
    let (forest, _) = solve(&[oak], &plain(grid), &FloraOptions::default());
    assert_eq!(mean_cover(&forest, 0), 1.0, "one unit of 5/9 and one cut to 4/9");
    assert!(forest.left_moisture.data.iter().all(|m| m.abs() < 1e-4));
}

#[test]
fn a_unit_needs_its_whole_draw_of_moisture() {
    let mut oak = plant("oak", Stratum::Tree);
    (oak.illumination.consumption, oak.moisture.consumption) = (5.0, 6.0);
    let (forest, _) = solve(&[oak], &plain(Grid::new(2, 2, 10.0)), &FloraOptions::default());
    assert!((mean_cover(&forest, 0) - 5.0 / 9.0).abs() < 1e-4);
    assert!((f64::from(forest.left_moisture.data[0]) - (5.0 - 6.0 * 5.0 / 9.0)).abs() < 1e-3);
}

#[test]
fn equals_share_uniform_ground_evenly_over_the_four_quarters() {
    let species: Vec<PlantSpecies> = (0..6)
        .map(|i| plant(&format!("p{i}"), Stratum::ALL[i % 3]))
        .map(|p| PlantSpecies { illumination: Need { range: Interval::new(1.0, 9.0), consumption: 5.0 }, ..p })
        .collect();
    let world = plain(Grid::new(128, 128, 10.0));
    let with_targets: Vec<PlantSpecies> =
        species.iter().enumerate().map(|(i, p)| PlantSpecies { target: Some(1.0 + i as f64), ..p.clone() }).collect();
    for kinds in [&species, &with_targets] {
        let (flora, _) = solve(kinds, &world, &FloraOptions::default());
        assert!(spread(&flora.total_map(|_| true)) < 0.05);
        for stratum in Stratum::ALL {
            assert!(spread(&flora.stratum_map(kinds, stratum)) < 0.05, "{stratum:?}");
        }
        // A species that covers little has few units, and those vary by chance.
        for s in 0..kinds.len() {
            let map = flora.cover_map(s);
            let units = map.data.iter().filter(|c| **c > 0.0).count() as f64 / 4.0;
            assert!(spread(&map) < 0.05 + 4.0 / units.sqrt(), "{s}: {}", spread(&map));
        }
    }
}

/// By how much the means of the four quarters of a map differ, relative to their mean.
fn spread(map: &Raster<f32>) -> f64 {
    let quarters = quarter_means(map);
    let (low, high) = quarters.iter().fold((f64::MAX, f64::MIN), |(l, h), q| (l.min(*q), h.max(*q)));
    4.0 * (high - low) / quarters.iter().sum::<f64>()
}

/// The mean of a map over its four quarters.
fn quarter_means(map: &Raster<f32>) -> [f64; 4] {
    let (mut sums, mut counts) = ([0.0; 4], [0.0; 4]);
    for (i, v) in map.data.iter().enumerate() {
        let cell = map.grid.cell(i);
        let quarter = 2 * usize::from(2 * cell.row >= map.grid.height) + usize::from(2 * cell.column >= map.grid.width);
        sums[quarter] += f64::from(*v);
        counts[quarter] += 1.0;
    }
    std::array::from_fn(|q| sums[q] / counts[q])
}

#[test]
fn the_fittest_takes_the_cell_without_targets() {
    let mut good = plant("good", Stratum::Herb);
    let mut poor = plant("poor", Stratum::Herb);
    (good.viability, poor.viability) = ([1.0; 5], [0.5; 5]);
    let (flora, _) = solve(&[poor, good], &plain(Grid::new(5, 5, 10.0)), &FloraOptions::default());
    assert_eq!([0, 1].map(|s| mean_cover(&flora, s)), [0.0, 1.0]);
}

#[test]
fn targets_are_reached_where_there_is_room() {
    let mut species: Vec<PlantSpecies> = (0..4).map(|i| plant(&format!("p{i}"), Stratum::Herb)).collect();
    for (p, target) in species.iter_mut().zip([60.0, 25.0, 10.0, 5.0]) {
        p.target = Some(target);
    }
    let (flora, _) = solve(&species, &plain(Grid::new(40, 40, 10.0)), &FloraOptions::default());
    let reached = flora.reached.unwrap();
    assert!(reached.distance <= 0.02, "{reached:?}");
    let total: f64 = flora.totals.iter().map(|t| t.cover_m2).sum();
    assert!(total > 0.97 * 160_000.0, "{total}");
}

#[test]
fn when_a_species_runs_out_of_room_the_others_are_held_back_unless_told_to_fill() {
    let grid = Grid::new(40, 40, 10.0);
    let mut world = plain(grid);
    world.soil.data[..200].fill(Soil::Alluvium as u8);
    let mut narrow = plant("narrow", Stratum::Herb);
    narrow.viability = [0.0, 0.0, 0.0, 0.0, 1.0];
    let species = [
        PlantSpecies { target: Some(50.0), ..narrow },
        PlantSpecies { target: Some(50.0), ..plant("broad", Stratum::Herb) },
    ];
    let (flora, _) = solve(&species, &world, &FloraOptions::default());
    let reached = flora.reached.clone().unwrap();
    assert!(reached.held_back && reached.out_of_room == [0] && reached.distance <= 0.021, "{reached:?}");
    let (flora, fit) = solve(&species, &world, &FloraOptions { fill: true, ..FloraOptions::default() });
    nothing_fits(&species, &world, &flora, &fit);
    assert!(flora.reached.unwrap().distance > 0.3);
}

#[test]
fn a_species_that_fits_nowhere_is_left_out_of_the_target_and_explained() {
    let mut cold = plant("cold", Stratum::Herb);
    cold.temperature.range = Interval::new(1.0, 2.0);
    let species =
        [PlantSpecies { target: Some(0.5), ..cold }, PlantSpecies { target: Some(0.5), ..plant("a", Stratum::Herb) }];
    let (flora, _) = solve(&species, &plain(Grid::new(6, 6, 10.0)), &FloraOptions::default());
    assert_eq!(flora.reached.unwrap().left_out, [0]);
    assert_eq!(flora.totals[0].why_empty, Some(Absence::Temperature));
    assert!((flora.totals[1].cover_m2 - 3600.0).abs() < 1e-6);
}

#[test]
fn a_world_where_nothing_grows_says_why_for_each_species() {
    type Change = fn(&mut PlantSpecies);
    let cases: [(Change, fn(Absence) -> bool); 8] = [
        (|p| p.viability = [0.0, 1.0, 1.0, 1.0, 1.0], |a| a == Absence::Soil),
        (|p| p.texture.range = Interval::new(7.0, 9.0), |a| a == Absence::Texture),
        (|p| p.temperature.range = Interval::new(8.0, 9.0), |a| a == Absence::Temperature),
        (|p| p.survival_min_c = Some(8.0), |a| a == Absence::Winter),
        (|p| p.moisture.range = Interval::new(1.0, 2.0), |a| a == Absence::Moisture),
        (|p| p.illumination.range = Interval::new(1.0, 4.0), |a| a == Absence::Illumination),
        (
            |p| (p.illumination.consumption, p.moisture.consumption) = (9.0, 7.0),
            |a| matches!(a, Absence::Outcompeted(c) if c.dry == 9),
        ),
        (|p| p.viability = [0.0, 0.0, 0.0, 0.0, 0.0], |a| a == Absence::Soil),
    ];
    for (change, is_right) in cases {
        let mut p = plant("p", Stratum::Herb);
        change(&mut p);
        let (flora, _) = solve(&[p], &plain(Grid::new(3, 3, 10.0)), &FloraOptions::default());
        let why = flora.totals[0].why_empty.unwrap();
        assert!(flora.totals[0].cells == 0 && is_right(why), "{why:?}");
    }
}

#[test]
fn trees_end_where_the_warmest_month_falls_below_ten_degrees_and_shrubs_one_degree_later() {
    let grid = Grid::new(60, 1, 10.0);
    let mut world = plain(grid);
    // The warmest month is 12 °C in the west and 0.1 °C cooler each cell.
    let base = Raster { grid, data: (0..60).map(|i| -0.1 * i as f32).collect() };
    let offset = |half: f32| std::array::from_fn(|m| if m == 6 { 12.0 } else { 4.0 } + half);
    world.temperature_min_c = MonthlyMap::Shifted { base: base.clone(), offset: offset(-6.0) };
    world.temperature_max_c = MonthlyMap::Shifted { base, offset: offset(6.0) };
    let mut species = Stratum::ALL.map(|s| plant(&format!("{s:?}"), s));
    species.iter_mut().for_each(|p| p.illumination.range = Interval::new(1.0, 9.0));
    let fit = fitness(&Run::silent(), &species, &world, &FitnessOptions::default()).unwrap();
    let last = |s: usize| (0..60).rev().find(|c| fit.value(s, *c) > 0.0).unwrap();
    assert!((20..=21).contains(&last(0)) && (30..=31).contains(&last(1)) && last(2) == 59);
    let none = FitnessOptions { tree_line_c: None, ..FitnessOptions::default() };
    assert!(fitness(&Run::silent(), &species, &world, &none).unwrap().met.iter().all(|m| m.all == 60));
}

#[test]
fn the_tree_line_lies_higher_on_sunny_slopes() {
    let grid = Grid::new(3, 1, 10.0);
    let mut world = plain(grid);
    let cool = |t: f32| MonthlyMap::Shifted { base: Raster::filled(grid, t), offset: [0.0; MONTHS] };
    (world.temperature_min_c, world.temperature_max_c) = (cool(4.9), cool(14.9));
    let base = Raster { grid, data: vec![0.22, 0.25, 0.29] };
    world.sunlight = MonthlyMap::Shifted { base, offset: [0.0; MONTHS] };
    let fit = fitness(&Run::silent(), &[plant("fir", Stratum::Tree)], &world, &FitnessOptions::default()).unwrap();
    assert_eq!([0, 1, 2].map(|cell| fit.value(0, cell) > 0.0), [false, false, true]);
}

#[test]
fn light_counts_in_the_growing_season() {
    let grid = Grid::new(2, 1, 10.0);
    let mut world = plain(grid);
    // Six warm months with full light and six cold dark ones; the second cell has no warm month.
    let base = Raster { grid, data: vec![0.0, -12.0] };
    let offset = |half: f32| std::array::from_fn(|m| if m < 6 { 15.0 + m as f32 } else { -5.0 } + half);
    world.temperature_min_c = MonthlyMap::Shifted { base: base.clone(), offset: offset(-3.0) };
    world.temperature_max_c = MonthlyMap::Shifted { base, offset: offset(3.0) };
    world.sunlight =
        MonthlyMap::Maps((0..MONTHS).map(|m| Raster::filled(grid, [0.2, 0.3, 0.01][(m / 5).min(2)])).collect());
    let (flora, _) = solve(&[], &world, &FloraOptions::default());
    assert!((flora.left_light.data[0] - (5.0 * 0.2 + 0.3) / 6.0).abs() < 1e-5);
    assert!((flora.left_light.data[1] - (3.0 * 0.2 + 0.3) / 4.0).abs() < 1e-5);
}

#[test]
fn open_water_holds_only_what_lives_in_it() {
    let mut world = plain(Grid::new(10, 1, 10.0));
    world.soil.data[..4].fill(Soil::Water as u8);
    let (mut alder, mut grass) = (plant("alder", Stratum::Tree), plant("grass", Stratum::Herb));
    alder.viability = [0.0, 0.8, 0.0, 0.0, 1.0];
    grass.viability = [1.0, 0.0, 1.0, 1.0, 1.0];
    let (flora, fit) = solve(&[alder, grass], &world, &FloraOptions::default());
    let row = |s: usize| flora.cover_map(s).data;
    assert_eq!(row(0), [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(row(1), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    assert!((fit.value(0, 0) - 0.8).abs() < 1e-9);
}

#[test]
fn ground_kept_bare_stays_bare() {
    let grid = Grid::new(3, 1, 10.0);
    let bare = Raster { grid, data: vec![1.0, 0.5, f32::NAN] };
    let options = FloraOptions { bare: Some(&bare), ..FloraOptions::default() };
    let (flora, _) = solve(&[plant("grass", Stratum::Herb)], &plain(grid), &options);
    assert_eq!(flora.cover_map(0).data, [0.0, 0.5, 1.0]);
}

#[test]
fn a_painted_raise_grows_as_far_as_the_resources_go_and_tells_where_it_could_not() {
    let grid = Grid::new(4, 1, 10.0);
    let mut world = plain(grid);
    let mut oak = plant("oak", Stratum::Tree);
    (oak.illumination.consumption, oak.moisture.consumption) = (5.0, 8.0);
    world.soil.data[3] = Soil::Marl as u8;
    oak.viability = [1.0, 1.0, 0.0, 1.0, 1.0];
    let species = [oak];
    let options = FloraOptions::default();
    let (flora, fit) = solve(&species, &world, &options);
    let wanted = Raster { grid, data: vec![0.25, f32::NAN, 1.0, 0.5] };
    let (flora, done) = flora::paint(&Run::silent(), &species, (&world, &fit), (flora, 0, &wanted), &options).unwrap();
    let covers = flora.cover_map(0).data;
    for (cover, expected) in covers.iter().zip([0.25, 5.0 / 9.0, 5.0 / 8.0, 0.0]) {
        assert!((cover - expected).abs() < 1e-4, "{covers:?}");
    }
    let short = done.shortfall.unwrap();
    assert_eq!((short.cells, short.worst_cell), (2, 3));
    assert!((short.worst - 0.5).abs() < 1e-4 && (short.area_m2 - 87.5).abs() < 0.1, "{short:?}");
    assert!((flora.left_moisture.data[0] - 3.0).abs() < 1e-3, "a reduction leaves surplus");
}

#[test]
fn a_painted_forest_drives_the_meadow_out() {
    let grid = Grid::new(2, 1, 10.0);
    let world = plain(grid);
    let mut grass = plant("grass", Stratum::Herb);
    grass.illumination.range = Interval::new(5.0, 9.0);
    let mut tree = plant("tree", Stratum::Tree);
    tree.moisture.consumption = 4.5;
    let (species, options) = ([grass, tree], FloraOptions::default());
    let (flora, fit) = solve(&species, &world, &options);
    let nothing = Raster::filled(grid, 0.0);
    let edit = |flora, s, wanted: &Raster<f32>| {
        flora::paint(&Run::silent(), &species, (&world, &fit), (flora, s, wanted), &options).unwrap()
    };
    let (felled, _) = edit(flora, 1, &nothing);
    let (meadow, done) = edit(felled, 0, &Raster::filled(grid, 1.0));
    assert_eq!((meadow.cover(0, 0), done.shortfall), (1.0, None));
    let (forest, done) = edit(meadow, 1, &Raster { grid, data: vec![1.0, f32::NAN] });
    assert_eq!((forest.cover(1, 0), forest.cover(0, 0), forest.cover(0, 1)), (1.0, 0.0, 1.0));
    assert_eq!(done.shortfall, None, "the moisture of the meadow came free");
}

#[test]
fn growth_is_area_by_form_and_fitness() {
    let mut grass = plant("grass", Stratum::Herb);
    grass.viability = [0.5; 5];
    let (flora, fit) = solve(std::slice::from_ref(&grass), &plain(Grid::new(1, 1, 20.0)), &FloraOptions::default());
    assert!((flora.growth_kg(&grass, &fit, (0, 0)) - 400.0 * 0.5 * fit.value(0, 0)).abs() < 1e-6);
    assert!((fit.value(0, 0) - 0.5).abs() < 0.002);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let world = plain(Grid::new(2, 2, 10.0));
    let refused = |species: &[PlantSpecies], options: &FloraOptions| {
        let fit = fitness(&Run::silent(), species, &world, &FitnessOptions::default()).unwrap();
        flora::compete(&Run::silent(), species, &world, &fit, options).unwrap_err()
    };
    let mut airy = plant("airy", Stratum::Herb);
    airy.illumination.consumption = 0.0;
    assert!(matches!(refused(&[airy], &FloraOptions::default()), FloraError::NoLightUse { .. }));
    for target in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let p = PlantSpecies { target: Some(target), ..plant("p", Stratum::Herb) };
        assert!(matches!(refused(&[p], &FloraOptions::default()), FloraError::Targets { .. }), "{target}");
    }
    let bare = Raster::filled(Grid::new(3, 2, 10.0), 0.0);
    let options = FloraOptions { bare: Some(&bare), ..FloraOptions::default() };
    let error = refused(&[plant("p", Stratum::Herb)], &options);
    assert_eq!(error, FloraError::Size { expected: 4, found: 6 });
}

#[test]
fn no_species_and_no_data_are_no_trouble() {
    let world = plain(Grid::new(2, 1, 10.0));
    assert!(solve(&[], &world, &FloraOptions::default()).0.covers.is_empty());
    let mut empty = plain(Grid::new(2, 1, 10.0));
    empty.texture.data.fill(f32::NAN);
    let (flora, _) = solve(&[plant("p", Stratum::Herb)], &empty, &FloraOptions::default());
    assert_eq!(flora.totals[0].why_empty, Some(Absence::Texture));
}

#[test]
fn stopped_work_ends_with_stopped() {
    let flag = StopFlag::default();
    flag.stop();
    let world = plain(Grid::new(2, 2, 10.0));
    let species = [PlantSpecies { target: Some(1.0), ..plant("p", Stratum::Herb) }];
    let fit = fitness(&Run::silent(), &species, &world, &FitnessOptions::default()).unwrap();
    assert!(fitness(&Run::stoppable(flag.clone()), &species, &world, &FitnessOptions::default()).is_err());
    let ended = flora::compete(&Run::stoppable(flag), &species, &world, &fit, &FloraOptions::default());
    assert!(matches!(ended, Err(FloraError::Stopped(_))));
}
