//! Regions, the Resource Access Graph with its herds, stocks and travel times.

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::fauna;
use crate::compute::ecosystem::fauna::Population;
use crate::compute::ecosystem::fauna::Stock;
use crate::compute::ecosystem::fauna::Stocks;
use crate::compute::ecosystem::rag::Area;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::Food;
use crate::compute::geometry::Point;
use crate::jobs::ecosystem::chain::Times;
use crate::jobs::ecosystem::stored::Stored;
use crate::jobs::ecosystem::stored::read_indices;
use crate::jobs::ecosystem::stored::read_u32;
use crate::jobs::ecosystem::stored::write_all;
use crate::jobs::ecosystem::stored::write_indices;
use crate::jobs::ecosystem::stored::write_u32;

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
