use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;

/// The coordinate system in which a grid's origin is given.
///
/// Where the cells lie is said by the grid itself (south-west corner and cell size); this says
/// on what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Georeference {
    /// A world of its own, in metres: an **engineering CRS** with this name.
    Local {
        /// Its name.
        name: String,
    },
    /// A projected coordinate system in metres, by its EPSG code.
    Projected {
        /// The code, for example 32616 for UTM zone 16 north.
        epsg: u16,
    },
}

impl Georeference {
    /// A world of its own.
    pub fn local(name: impl Into<String>) -> Self {
        Self::Local { name: name.into() }
    }

    /// A projected coordinate system.
    pub const fn epsg(epsg: u16) -> Self {
        Self::Projected { epsg }
    }

    /// The EPSG code, if there is one.
    pub const fn code(&self) -> Option<u16> {
        match self {
            Self::Local { .. } => None,
            Self::Projected { epsg } => Some(*epsg),
        }
    }

    /// Writes it as part of a stored value.
    pub fn write(&self, w: &mut Writer) {
        match self {
            Self::Local { name } => w.u8(0).string(name),
            Self::Projected { epsg } => w.u8(1).u16(*epsg),
        };
    }

    /// Reads what [`Georeference::write`] wrote.
    pub fn read(r: &mut Reader) -> Result<Self, binary::Error> {
        match r.u8()? {
            0 => Ok(Self::Local { name: r.string()? }),
            1 => Ok(Self::Projected { epsg: r.u16()? }),
            _ => Err(binary::Error::Corrupt("an unknown kind of coordinate system")),
        }
    }
}

impl Default for Georeference {
    fn default() -> Self {
        Self::local("local")
    }
}
