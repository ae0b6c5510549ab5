//! The stored form of what each stage hands on, so that a solve that repeats a stage reads it
//! instead. Writer and reader of a type stand side by side.

use bytes::Bytes;

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::fauna;
use crate::compute::ecosystem::fauna::Population;
use crate::compute::ecosystem::fauna::Stock;
use crate::compute::ecosystem::fauna::Stocks;
use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Met;
use crate::compute::ecosystem::flora::Absence;
use crate::compute::ecosystem::flora::Crowded;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Painted;
use crate::compute::ecosystem::flora::Reached;
use crate::compute::ecosystem::flora::Shortfall;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::paths::Path;
use crate::compute::ecosystem::paths::Paths;
use crate::compute::ecosystem::planning;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Cause;
use crate::compute::ecosystem::planning::Herd;
use crate::compute::ecosystem::planning::Planning;
use crate::compute::ecosystem::planning::Plannings;
use crate::compute::ecosystem::planning::Reason;
use crate::compute::ecosystem::planning::Track;
use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::rag::Area;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::trails::Stretch;
use crate::compute::ecosystem::trails::Trail;
use crate::compute::ecosystem::trails::Trails;
use crate::compute::ecosystem::water::Water;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Stage;
use crate::jobs::ecosystem::chain::Days;
use crate::jobs::ecosystem::chain::Grown;
use crate::jobs::ecosystem::chain::Times;

/// Version of the whole stored form.
const VERSION: u16 = 1;

/// A value that has a stored form.
pub trait Stored: Sized {
    /// Four letters that name the kind.
    const KIND: [u8; 4];
    /// Writes it.
    fn write(&self, w: &mut Writer);
    /// Reads what [`Stored::write`] wrote.
    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error>;
}

/// The result of a stage: the stored one when it has run before, otherwise that of `work`, which
/// is then stored. Work that is done is not read back.
pub fn stage<T: Stored>(
    context: &JobContext<'_>,
    stage: Stage,
    work: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Failure> {
    let mut fresh = None;
    let bytes = context.memo(stage, || {
        let value = work()?;
        let mut w = Writer::for_run(T::KIND, VERSION, &context.run);
        value.write(&mut w);
        context.run.check()?;
        fresh = Some(value);
        Ok(Bytes::from(w.finish()))
    })?;
    match fresh {
        Some(value) => Ok(value),
        None => decode(&bytes).map_err(Failure::fault),
    }
}

fn decode<T: Stored>(bytes: &[u8]) -> Result<T, binary::Error> {
    let mut r = Reader::new(bytes, T::KIND, VERSION)?;
    let value = T::read(&mut r)?;
    r.finish().map(|()| value)
}

fn write_grid(w: &mut Writer, grid: &Grid) {
    w.u32(grid.width as u32).u32(grid.height as u32).f64(grid.cell_m).f64(grid.origin.x).f64(grid.origin.y);
}

fn read_grid(r: &mut Reader<'_>) -> Result<Grid, binary::Error> {
    let (width, height) = (r.u32()? as usize, r.u32()? as usize);
    Ok(Grid { width, height, cell_m: r.f64()?, origin: Point::new(r.f64()?, r.f64()?) })
}

const UNFIT: binary::Error = binary::Error::Corrupt("a map does not fit its grid");

/// Rasters, by the type of their values.
macro_rules! rasters {
    ($($write:ident $read:ident $many:ident $number:ty;)*) => {$(
        fn $write(w: &mut Writer, raster: &Raster<$number>) {
            write_grid(w, &raster.grid);
            w.$many(&raster.data);
        }

        fn $read(r: &mut Reader<'_>) -> Result<Raster<$number>, binary::Error> {
            let grid = read_grid(r)?;
            Raster::from_data(grid, r.$many()?).ok_or(UNFIT)
        }
    )*};
}

rasters! {
    write_f32 read_f32 f32s f32;
    write_u8 read_u8 u8s u8;
    write_u16 read_u16 u16s u16;
    write_u32 read_u32 u32s u32;
}

/// A list whose items write themselves by a function of no return value.
fn write_all<T>(w: &mut Writer, items: &[T], mut write: impl FnMut(&mut Writer, &T)) {
    w.u64(items.len() as u64);
    items.iter().for_each(|item| write(w, item));
}

fn write_monthly(w: &mut Writer, map: &MonthlyMap) {
    match map {
        MonthlyMap::Shifted { base, offset } => {
            w.u8(0).f32s(offset);
            write_f32(w, base);
        }
        MonthlyMap::Maps(maps) => {
            w.u8(1);
            write_all(w, maps, write_f32);
        }
    }
}

fn read_monthly(r: &mut Reader<'_>) -> Result<MonthlyMap, binary::Error> {
    const MONTHLY: binary::Error = binary::Error::Corrupt("a monthly map does not have twelve months");
    match r.u8()? {
        0 => {
            let offset: [f32; MONTHS] = r.f32s()?.try_into().map_err(|_| MONTHLY)?;
            Ok(MonthlyMap::Shifted { base: read_f32(r)?, offset })
        }
        1 => {
            let maps = r.list(read_f32)?;
            if maps.len() == MONTHS { Ok(MonthlyMap::Maps(maps)) } else { Err(MONTHLY) }
        }
        _ => Err(binary::Error::Corrupt("an unknown kind of monthly map")),
    }
}

impl Stored for Water {
    const KIND: [u8; 4] = *b"EWAT";

    fn write(&self, w: &mut Writer) {
        for map in [&self.depth_m, &self.stream_width_m, &self.drainage_m2, &self.above_water_m] {
            write_f32(w, map);
        }
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            depth_m: read_f32(r)?,
            stream_width_m: read_f32(r)?,
            drainage_m2: read_f32(r)?,
            above_water_m: read_f32(r)?,
        })
    }
}

impl Stored for Resources {
    const KIND: [u8; 4] = *b"ERES";

    fn write(&self, w: &mut Writer) {
        for map in [&self.temperature_min_c, &self.temperature_max_c, &self.sunlight, &self.moisture] {
            write_monthly(w, map);
        }
        write_f32(w, &self.texture);
        write_u8(w, &self.soil);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            temperature_min_c: read_monthly(r)?,
            temperature_max_c: read_monthly(r)?,
            sunlight: read_monthly(r)?,
            moisture: read_monthly(r)?,
            texture: read_f32(r)?,
            soil: read_u8(r)?,
        })
    }
}

fn write_met(w: &mut Writer, m: &Met) {
    w.u64(m.illumination)
        .u64(m.temperature)
        .u64(m.moisture)
        .u64(m.texture)
        .u64(m.soil)
        .u64(m.survival)
        .u64(m.tree_line)
        .u64(m.all);
}

fn read_met(r: &mut Reader<'_>) -> Result<Met, binary::Error> {
    Ok(Met {
        illumination: r.u64()?,
        temperature: r.u64()?,
        moisture: r.u64()?,
        texture: r.u64()?,
        soil: r.u64()?,
        survival: r.u64()?,
        tree_line: r.u64()?,
        all: r.u64()?,
    })
}

impl Stored for Fitness {
    const KIND: [u8; 4] = *b"EFIT";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.levels, write_u8);
        write_all(w, &self.met, write_met);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self { levels: r.list(read_u8)?, met: r.list(read_met)? })
    }
}

fn write_absence(w: &mut Writer, absence: &Absence) {
    match absence {
        Absence::NotAsked => w.u8(0),
        Absence::Soil => w.u8(1),
        Absence::Texture => w.u8(2),
        Absence::Temperature => w.u8(3),
        Absence::Winter => w.u8(4),
        Absence::Moisture => w.u8(5),
        Absence::Illumination => w.u8(6),
        Absence::KeptOut => w.u8(7),
        Absence::TreeLine => w.u8(10),
        Absence::NeverTogether(met) => {
            w.u8(8);
            write_met(w, met);
            w
        }
        Absence::Outcompeted(c) => w.u8(9).u64(c.dark).u64(c.shaded).u64(c.full).u64(c.dry).u64(c.free),
    };
}

fn read_absence(r: &mut Reader<'_>) -> Result<Absence, binary::Error> {
    Ok(match r.u8()? {
        0 => Absence::NotAsked,
        1 => Absence::Soil,
        2 => Absence::Texture,
        3 => Absence::Temperature,
        4 => Absence::Winter,
        5 => Absence::Moisture,
        6 => Absence::Illumination,
        7 => Absence::KeptOut,
        10 => Absence::TreeLine,
        8 => Absence::NeverTogether(read_met(r)?),
        9 => Absence::Outcompeted(Crowded {
            dark: r.u64()?,
            shaded: r.u64()?,
            full: r.u64()?,
            dry: r.u64()?,
            free: r.u64()?,
        }),
        _ => return Err(binary::Error::Corrupt("an unknown reason of absence")),
    })
}

fn write_total(w: &mut Writer, total: &Total) {
    w.f64(total.cover_m2).u64(total.cells).bool(total.why_empty.is_some());
    if let Some(absence) = &total.why_empty {
        write_absence(w, absence);
    }
}

fn read_total(r: &mut Reader<'_>) -> Result<Total, binary::Error> {
    Ok(Total { cover_m2: r.f64()?, cells: r.u64()?, why_empty: r.option(read_absence)? })
}

fn write_indices(w: &mut Writer, indices: &[usize]) {
    w.u64s(&indices.iter().map(|i| *i as u64).collect::<Vec<_>>());
}

fn read_indices(r: &mut Reader<'_>) -> Result<Vec<usize>, binary::Error> {
    Ok(r.u64s()?.into_iter().map(|i| i as usize).collect())
}

fn write_reached(w: &mut Writer, reached: &Reached) {
    w.f64s(&reached.asked).f64s(&reached.reached).f64(reached.distance).bool(reached.held_back);
    write_indices(w, &reached.left_out);
    write_indices(w, &reached.out_of_room);
}

fn read_reached(r: &mut Reader<'_>) -> Result<Reached, binary::Error> {
    Ok(Reached {
        asked: r.f64s()?,
        reached: r.f64s()?,
        distance: r.f64()?,
        held_back: r.bool()?,
        left_out: read_indices(r)?,
        out_of_room: read_indices(r)?,
    })
}

fn write_flora(w: &mut Writer, flora: &Flora) {
    write_all(w, &flora.covers, write_u16);
    write_f32(w, &flora.left_light);
    write_f32(w, &flora.left_moisture);
    write_all(w, &flora.totals, write_total);
    w.bool(flora.reached.is_some());
    if let Some(reached) = &flora.reached {
        write_reached(w, reached);
    }
}

fn read_flora(r: &mut Reader<'_>) -> Result<Flora, binary::Error> {
    Ok(Flora {
        covers: r.list(read_u16)?,
        left_light: read_f32(r)?,
        left_moisture: read_f32(r)?,
        totals: r.list(read_total)?,
        reached: r.option(read_reached)?,
    })
}

fn write_painted(w: &mut Writer, (species, painted): &(usize, Painted)) {
    w.u64(*species as u64).f64(painted.lowered_m2).f64(painted.raised_m2);
    w.option(painted.shortfall.as_ref(), |w, s| w.u64(s.cells).f64(s.area_m2).u64(s.worst_cell as u64).f32(s.worst));
}

fn read_painted(r: &mut Reader<'_>) -> Result<(usize, Painted), binary::Error> {
    let species = r.u64()? as usize;
    let (lowered_m2, raised_m2) = (r.f64()?, r.f64()?);
    let shortfall = r.option(|r| {
        Ok(Shortfall { cells: r.u64()?, area_m2: r.f64()?, worst_cell: r.u64()? as usize, worst: r.f32()? })
    })?;
    Ok((species, Painted { lowered_m2, raised_m2, shortfall }))
}

impl Stored for Grown {
    const KIND: [u8; 4] = *b"EFLO";

    fn write(&self, w: &mut Writer) {
        write_flora(w, &self.flora);
        write_all(w, &self.painted, write_painted);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self { flora: read_flora(r)?, painted: r.list(read_painted)? })
    }
}

impl Stored for Regions {
    const KIND: [u8; 4] = *b"EREG";

    fn write(&self, w: &mut Writer) {
        write_u32(w, &self.part);
        w.u32s(&self.part_cells);
        write_all(w, &self.region_of_part, |w, regions| {
            w.list(regions, |w, region| w.option(region.as_ref(), |w, r| w.u32(*r)));
        });
        write_all(w, &self.region_cells, |w, cells| {
            w.u32s(cells);
        });
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            part: read_u32(r)?,
            part_cells: r.u32s()?,
            region_of_part: r.list(|r| r.list(|r| r.option(Reader::u32)))?,
            region_cells: r.list(Reader::u32s)?,
        })
    }
}

fn write_resource(w: &mut Writer, resource: Resource) {
    match resource {
        Resource::Water => w.u8(0).u64(0),
        Resource::Food(Food::Plant(i)) => w.u8(1).u64(i as u64),
        Resource::Food(Food::Animal(i)) => w.u8(2).u64(i as u64),
        Resource::WayPoint(i) => w.u8(3).u64(i as u64),
    };
}

fn read_resource(r: &mut Reader<'_>) -> Result<Resource, binary::Error> {
    let (kind, index) = (r.u8()?, r.u64()? as usize);
    match kind {
        0 => Ok(Resource::Water),
        1 => Ok(Resource::Food(Food::Plant(index))),
        2 => Ok(Resource::Food(Food::Animal(index))),
        3 => Ok(Resource::WayPoint(index)),
        _ => Err(binary::Error::Corrupt("an unknown kind of resource")),
    }
}

fn write_node(w: &mut Writer, node: &Node) {
    w.u64(node.level as u64).u64(node.cell as u64).f64(node.place.x).f64(node.place.y);
    w.f64(node.area_m2).f64(node.quantity_kg).f64(node.draws);
    write_resource(w, node.resource);
    let (first, length): (Vec<u32>, Vec<u32>) = node.area.runs.iter().copied().unzip();
    w.u32s(&first).u32s(&length);
    write_indices(w, &node.below);
}

fn read_node(r: &mut Reader<'_>) -> Result<Node, binary::Error> {
    let (level, cell) = (r.u64()? as usize, r.u64()? as usize);
    let place = Point::new(r.f64()?, r.f64()?);
    let (area_m2, quantity_kg, draws) = (r.f64()?, r.f64()?, r.f64()?);
    let resource = read_resource(r)?;
    let area = Area { runs: r.u32s()?.into_iter().zip(r.u32s()?).collect() };
    Ok(Node { level, resource, area, cell, place, area_m2, quantity_kg, draws, below: read_indices(r)? })
}

fn write_territory(w: &mut Writer, t: &Territory) {
    w.u64(t.species as u64).u64(t.region as u64).f32s(&t.times_s).u32s(&t.herds);
    write_indices(w, &t.nodes);
}

fn read_territory(r: &mut Reader<'_>) -> Result<Territory, binary::Error> {
    let (species, region) = (r.u64()? as usize, r.u64()? as usize);
    let (times_s, herds) = (r.f32s()?, r.u32s()?);
    Ok(Territory { species, region, times_s, herds, nodes: read_indices(r)? })
}

fn write_stock(w: &mut Writer, stock: &Stock) {
    w.f64(stock.offtake).f64s(&stock.growth_kg).f64s(&stock.eaten_kg);
}

fn read_stock(r: &mut Reader<'_>) -> Result<Stock, binary::Error> {
    Ok(Stock { offtake: r.f64()?, growth_kg: r.f64s()?, eaten_kg: r.f64s()? })
}

fn write_nobody(w: &mut Writer, absence: &fauna::Absence) {
    match absence {
        fauna::Absence::NotWanted => w.u8(0),
        fauna::Absence::NoRegion => w.u8(1),
        fauna::Absence::NoWater => w.u8(2),
        fauna::Absence::NoRoom => w.u8(3),
        fauna::Absence::NoFood { needed_kg, found_kg } => w.u8(4).f64(*needed_kg).f64(*found_kg),
        fauna::Absence::Displaced => w.u8(5),
    };
}

fn read_nobody(r: &mut Reader<'_>) -> Result<fauna::Absence, binary::Error> {
    Ok(match r.u8()? {
        0 => fauna::Absence::NotWanted,
        1 => fauna::Absence::NoRegion,
        2 => fauna::Absence::NoWater,
        3 => fauna::Absence::NoRoom,
        4 => fauna::Absence::NoFood { needed_kg: r.f64()?, found_kg: r.f64()? },
        5 => fauna::Absence::Displaced,
        _ => return Err(binary::Error::Corrupt("an unknown reason of absence")),
    })
}

impl Stored for Population {
    const KIND: [u8; 4] = *b"EPOP";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.rag.nodes, write_node);
        write_all(w, &self.rag.territories, write_territory);
        write_all(w, &self.stocks.plants, write_stock);
        write_all(w, &self.stocks.animals, write_stock);
        write_all(w, &self.absent, |w, absent| {
            w.bool(absent.is_some());
            absent.iter().for_each(|reason| write_nobody(w, reason));
        });
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        let rag = Rag { nodes: r.list(read_node)?, territories: r.list(read_territory)? };
        let stocks = Stocks { plants: r.list(read_stock)?, animals: r.list(read_stock)? };
        Ok(Self { rag, stocks, absent: r.list(|r| r.option(read_nobody))? })
    }
}

impl Stored for Times {
    const KIND: [u8; 4] = *b"ETIM";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.0, |w, times| {
            w.f32s(times);
        });
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self(r.list(Reader::f32s)?))
    }
}

fn write_points(w: &mut Writer, points: &[Point]) {
    w.f64s(&points.iter().map(|p| p.x).collect::<Vec<_>>()).f64s(&points.iter().map(|p| p.y).collect::<Vec<_>>());
}

fn read_points(r: &mut Reader<'_>) -> Result<Vec<Point>, binary::Error> {
    let (x, y) = (r.f64s()?, r.f64s()?);
    if x.len() == y.len() {
        Ok(x.into_iter().zip(y).map(|(x, y)| Point::new(x, y)).collect())
    } else {
        Err(binary::Error::Corrupt("a line has more of one coordinate than of the other"))
    }
}

fn write_stretch(w: &mut Writer, s: &Stretch) {
    w.u64(*s.points.start() as u64).u64(*s.points.end() as u64);
    w.f64(s.kg_per_year).f64(s.width_m).f64(s.depth_m);
    w.list(&s.species, |w, (species, share)| w.u64(*species as u64).f64(*share));
}

fn read_stretch(r: &mut Reader<'_>) -> Result<Stretch, binary::Error> {
    let points = r.u64()? as usize..=r.u64()? as usize;
    let (kg_per_year, width_m, depth_m) = (r.f64()?, r.f64()?, r.f64()?);
    let species = r.list(|r| Ok((r.u64()? as usize, r.f64()?)))?;
    Ok(Stretch { points, kg_per_year, species, width_m, depth_m })
}

impl Stored for Trails {
    const KIND: [u8; 4] = *b"ETRA";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.lines, |w, trail| {
            write_points(w, &trail.points);
            write_all(w, &trail.stretches, write_stretch);
        });
        for map in [&self.usage, &self.worn, &self.carving_m] {
            write_f32(w, map);
        }
        w.list(self.paths.list(), |w, path| w.u64(path.species as u64).f64(path.seconds).u32s(&path.cells));
        w.f64(self.kept_share).u64(self.without_way as u64);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        let lines = r.list(|r| Ok(Trail { points: read_points(r)?, stretches: r.list(read_stretch)? }))?;
        let (usage, worn, carving_m) = (read_f32(r)?, read_f32(r)?, read_f32(r)?);
        let path = |r: &mut Reader<'_>| Ok(Path { species: r.u64()? as usize, seconds: r.f64()?, cells: r.u32s()? });
        let paths = Paths::new(r.list(path)?);
        Ok(Self { lines, usage, worn, carving_m, paths, kept_share: r.f64()?, without_way: r.u64()? as usize })
    }
}

const ACTIVITIES: [Activity; 6] =
    [Activity::Drink, Activity::Feed, Activity::Hunt, Activity::Rest, Activity::Wait, Activity::Pass];

const CAUSES: [Cause; 6] = [Cause::NoWay, Cause::TooFar, Cause::TooSmall, Cause::NoRoom, Cause::NoTime, Cause::NoPrey];

fn write_activity(w: &mut Writer, activity: Activity) {
    w.u8(ACTIVITIES.iter().position(|a| *a == activity).unwrap_or(0) as u8);
}

fn read_activity(r: &mut Reader<'_>) -> Result<Activity, binary::Error> {
    let code = usize::from(r.u8()?);
    ACTIVITIES.get(code).copied().ok_or(binary::Error::Corrupt("an unknown activity"))
}

fn write_herd(w: &mut Writer, h: &Herd) {
    w.u64(h.species as u64).u64(h.territory as u64).u64(h.region as u64).u64(h.number as u64).u32(h.size);
}

fn read_herd(r: &mut Reader<'_>) -> Result<Herd, binary::Error> {
    let (species, territory) = (r.u64()? as usize, r.u64()? as usize);
    let (region, number) = (r.u64()? as usize, r.u64()? as usize);
    Ok(Herd { species, territory, region, number, size: r.u32()? })
}

fn write_visit(w: &mut Writer, v: &Visit) {
    w.u64(v.node as u64).u64(v.cell as u64).f64(v.arrive_s).f64(v.leave_s);
    write_activity(w, v.activity);
    w.option(v.prey.as_ref(), |w, prey| w.u64(*prey as u64));
}

fn read_visit(r: &mut Reader<'_>) -> Result<Visit, binary::Error> {
    let (node, cell) = (r.u64()? as usize, r.u64()? as usize);
    let (arrive_s, leave_s) = (r.f64()?, r.f64()?);
    let activity = read_activity(r)?;
    Ok(Visit { node, cell, arrive_s, leave_s, activity, prey: r.option(|r| Ok(r.u64()? as usize))? })
}

fn write_reason(w: &mut Writer, reason: &Reason) {
    match reason {
        Reason::Crowded(seconds) => {
            w.u8(0).f64(*seconds);
        }
        Reason::NoRoomToRest => {
            w.u8(1);
        }
        Reason::Missed(activity, cause) => {
            w.u8(2);
            write_activity(w, *activity);
            w.u8(CAUSES.iter().position(|c| c == cause).unwrap_or(0) as u8);
        }
        Reason::PreyOutOfReach(seconds) => {
            w.u8(3).f64(*seconds);
        }
    }
}

fn read_reason(r: &mut Reader<'_>) -> Result<Reason, binary::Error> {
    match r.u8()? {
        0 => Ok(Reason::Crowded(r.f64()?)),
        1 => Ok(Reason::NoRoomToRest),
        2 => {
            let (activity, cause) = (read_activity(r)?, usize::from(r.u8()?));
            let cause = CAUSES.get(cause).copied().ok_or(binary::Error::Corrupt("an unknown cause"))?;
            Ok(Reason::Missed(activity, cause))
        }
        3 => Ok(Reason::PreyOutOfReach(r.f64()?)),
        _ => Err(binary::Error::Corrupt("an unknown reason")),
    }
}

impl Stored for Days {
    const KIND: [u8; 4] = *b"EDAY";

    fn write(&self, w: &mut Writer) {
        let Plannings { herds, days, warnings } = &self.plannings;
        write_all(w, herds, write_herd);
        write_all(w, days, |w, day| write_all(w, &day.visits, write_visit));
        write_all(w, warnings, |w, warning| {
            w.u64(warning.herd as u64);
            write_reason(w, &warning.reason);
        });
        write_all(w, &self.tracks, |w, track| {
            w.u64(track.herd as u64).f64(track.from_s).f64(track.step_s).f32s(&track.heights_m);
            write_points(w, &track.places);
        });
        w.list(&self.conflicts, |w, (herd, sentence)| w.u64(*herd as u64).string(sentence));
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        let herds = r.list(read_herd)?;
        let days = r.list(|r| Ok(Planning { visits: r.list(read_visit)? }))?;
        let warnings = r.list(|r| Ok(planning::Warning { herd: r.u64()? as usize, reason: read_reason(r)? }))?;
        let tracks = r.list(|r| {
            let (herd, from_s, step_s, heights_m) = (r.u64()? as usize, r.f64()?, r.f64()?, r.f32s()?);
            Ok(Track { herd, from_s, step_s, heights_m, places: read_points(r)? })
        })?;
        let conflicts = r.list(|r| Ok((r.u64()? as usize, r.string()?)))?;
        Ok(Self { plannings: Plannings { herds, days, warnings }, tracks, conflicts })
    }
}
