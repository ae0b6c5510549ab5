//! What is known of a plant or an animal species, as the stages need it.
//!
//! Where each number comes from is kept beside the species by the caller (`jobs`); the stages
//! only compute with it. Names and units: T appendix A, L 4.1.

/// A closed interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub min: f64,
    /// Upper end, not below `min`.
    pub max: f64,
}

impl Interval {
    /// The interval from `min` to `max`.
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// Whether `value` lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

/// The **fitness range** of a plant for one resource and what it consumes, on the scale 1–9.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// F(s, r): where growth is not limited (L 4.1).
    pub range: Interval,
    /// c(s, r): yearly consumption of a unit, in scale units (T table A.1); 0 for none.
    pub consumption: f64,
}

/// The **stratum** a plant belongs to, from the tallest down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stratum {
    /// Trees: shade shrubs and herbs.
    Tree,
    /// Shrubs: shade herbs.
    Shrub,
    /// Herbs: shade nothing.
    Herb,
}

impl Stratum {
    /// All strata, from the tallest down.
    pub const ALL: [Self; 3] = [Self::Tree, Self::Shrub, Self::Herb];
}

/// A **soil type** of T table A.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Soil {
    /// Limestone.
    Limestone = 0,
    /// Standing or flowing water.
    Water = 1,
    /// Marl.
    Marl = 2,
    /// Fallen rocks (scree).
    FallenRocks = 3,
    /// Alluvium.
    Alluvium = 4,
}

impl Soil {
    /// All types, in the order of their codes.
    pub const ALL: [Self; 5] = [Self::Limestone, Self::Water, Self::Marl, Self::FallenRocks, Self::Alluvium];
}

/// A plant species.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantSpecies {
    /// Unique name.
    pub name: String,
    /// Stratum.
    pub stratum: Stratum,
    /// Light.
    pub illumination: Need,
    /// Temperature (scale); nothing is consumed.
    pub temperature: Need,
    /// Soil moisture.
    pub moisture: Need,
    /// Soil texture; nothing is consumed.
    pub texture: Need,
    /// Viability in 0..=1 per [`Soil`], in the order of its codes; multiplies the fitness.
    pub viability: [f64; 5],
    /// Fitness is 0 where the coldest month's minimum is below this, in °C. `None`: no bound.
    pub survival_min_c: Option<f64>,
    /// Yearly growth in kg of dry matter per covered square metre at fitness 1.
    pub growth_kg_per_m2: f64,
    /// The share of the growth that animals may take, 0..=1.
    pub offtake: f64,
    /// Share of the covered area of all plants that the user wants, any positive unit.
    /// `None` for all species: competition without targets (L Algorithm 2).
    pub target: Option<f64>,
}

/// What an animal eats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Food {
    /// The plant species with this index.
    Plant(usize),
    /// The animal species with this index.
    Animal(usize),
}

/// One alternative in a diet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DietItem {
    /// What is eaten.
    pub food: Food,
    /// How much it is liked against the other items, positive; 1 is neutral.
    pub preference: f64,
}

/// How an animal moves, and what stops it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mobility {
    /// Walking speed on flat ground, m/s.
    pub speed_m_per_s: f64,
    /// Steepest slope climbed, rise over run.
    pub max_slope_up: f64,
    /// Steepest slope descended, rise over run.
    pub max_slope_down: f64,
    /// Deepest water waded through, m.
    pub ford_depth_m: f64,
    /// Tree cover above which the vegetation is closed to it, 0..=1 (1: never closed).
    pub max_tree_cover: f64,
}

/// An animal species.
#[derive(Debug, Clone, PartialEq)]
pub struct AnimalSpecies {
    /// Unique name.
    pub name: String,
    /// Food-chain level: 1 eats plants, 2 eats level 1, and so on.
    pub level: usize,
    /// Mean mass of an individual, kg.
    pub mass_kg: f64,
    /// Individuals in the smallest typical group: the **population unit**.
    pub group_min: u32,
    /// Individuals in the largest typical group.
    pub group_max: u32,
    /// What it eats: alternatives with preferences.
    pub diet: Vec<DietItem>,
    /// Food an individual needs a year, kg (dry matter of plants, or mass of prey).
    pub food_kg_per_year: f64,
    /// Whether a region must hold water it can reach.
    pub needs_water: bool,
    /// Births per individual and year: the **growth rate**.
    pub growth_per_year: f64,
    /// The share of the births that animals of the next level may take, 0..=1.
    pub offtake: f64,
    /// How it moves.
    pub mobility: Mobility,
    /// Start of the active day, seconds of the local solar day.
    pub active_from_s: f64,
    /// Length of the active day, seconds, at most 86 400.
    pub active_s: f64,
    /// Share of the individuals of its level that the user wants, any positive unit.
    pub target: Option<f64>,
}
