//! `BTRK`: the four letters, u32 version 1, u32 animals, u32 steps, then little-endian f32
//! columns: t (a value a step), x, y, z and heading (a value an animal and step, animal by animal).

use super::TrackFile;
use crate::compute::herds::animation::Pose;

const VERSION: u32 = 1;

impl TrackFile<'_> {
    /// The compact binary form; x and y from the origin.
    pub fn to_binary(&self) -> Vec<u8> {
        let steps = self.tracks.times_s.len();
        let mut bytes = Vec::with_capacity(16 + 4 * steps * (1 + 4 * self.tracks.animals));
        bytes.extend(b"BTRK");
        for number in [VERSION, self.tracks.animals as u32, steps as u32] {
            bytes.extend(number.to_le_bytes());
        }
        self.tracks.times_s.iter().for_each(|t| bytes.extend((*t as f32).to_le_bytes()));
        let columns: [fn(&Self, Pose) -> f64; 4] =
            [|f, p| p.place.x - f.origin.x, |f, p| p.place.y - f.origin.y, |_, p| p.z, |_, p| p.heading];
        for column in columns {
            for animal in 0..self.tracks.animals {
                for step in 0..steps {
                    bytes.extend((column(self, self.tracks.pose(step, animal)) as f32).to_le_bytes());
                }
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use crate::codec::map::Georeference;
    use crate::codec::tracks::tests::file;
    use crate::codec::tracks::tests::tracks;

    #[test]
    fn columns_stand_one_after_the_other_animal_by_animal() {
        let (tracks, place) = (tracks(), Georeference::local("test"));
        let bytes = file(&tracks, &place).to_binary();
        assert_eq!(&bytes[..16], b"BTRK\x01\0\0\0\x02\0\0\0\x03\0\0\0");
        let numbers: Vec<f32> =
            bytes[16..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(numbers.len(), 3 + 4 * 6);
        assert_eq!(numbers[..3], [60.0, 60.5, 61.25]);
        assert_eq!(numbers[3..9], [9.0, 10.0, 12.0, 11.0, 11.0, 10.0]);
        assert_eq!(numbers[9..12], [18.0; 3]);
        assert_eq!(numbers[24..], [1.5, 3.1, -3.1]);
    }
}
