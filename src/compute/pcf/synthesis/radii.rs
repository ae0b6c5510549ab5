use crate::compute::random::Purpose;
use crate::compute::random::Stream;

const DRAW: Purpose = Purpose::new("distribution.radii");

/// `count` radii after the exemplar's (T 3.4.3): its whole list as often as it fits, the rest
/// drawn from it without replacement. With equal counts the radii are matched exactly. In
/// random order: see [`crate::compute::pcf::synthesise`], which deals them to its blocks.
pub(super) fn draw(exemplar: &[f64], count: usize, (seed, class): (u64, usize)) -> Vec<f64> {
    let mut random = Stream::new(seed, DRAW, class as u64);
    let mut rest = exemplar.to_vec();
    random.shuffle(&mut rest);
    let whole = count / exemplar.len().max(1);
    let mut radii: Vec<f64> = (0..whole).flat_map(|_| exemplar.iter().copied()).collect();
    radii.extend_from_slice(&rest[..count - radii.len()]);
    random.shuffle(&mut radii);
    radii
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_counts_give_the_radii_of_the_exemplar() {
        let exemplar = [0.3, 0.1, 0.2, 0.2];
        let mut drawn = draw(&exemplar, 4, (1, 0));
        drawn.sort_by(f64::total_cmp);
        assert_eq!(drawn, [0.1, 0.2, 0.2, 0.3]);
        let mut more = draw(&exemplar, 10, (1, 0));
        more.sort_by(f64::total_cmp);
        assert_eq!(more.len(), 10);
        for radius in exemplar {
            let times = |list: &[f64]| list.iter().filter(|r| **r == radius).count();
            assert!((2..=3).contains(&(times(&more) / times(&exemplar))));
        }
        assert!(draw(&exemplar, 0, (1, 0)).is_empty());
    }
}
