use crate::compute::random::Purpose;
use crate::compute::random::Stream;

const HERDS: Purpose = Purpose::new("animals.herds");

/// Shares `individuals` of a species out to herds of `group_min` to `group_max`.
///
/// There are about as many herds as groups of the middle size would make; what they hold above
/// the smallest size is drawn at random. The sizes add up to `individuals` exactly. `place` names
/// the territory, so that every one draws numbers of its own.
pub fn herds_of(individuals: u64, (group_min, group_max): (u32, u32), (seed, place): (u64, u64)) -> Vec<u32> {
    let (least, most) = (u64::from(group_min.max(1)), u64::from(group_max.max(group_min).max(1)));
    if individuals < least {
        return Vec::new();
    }
    let middle = (2 * individuals).div_ceil(least + most);
    let herds = middle.max(individuals.div_ceil(most)).min(individuals / least);
    let mut sizes = vec![least; herds as usize];
    let mut rest = individuals - herds * least;
    let mut stream = Stream::new(seed, HERDS, place);
    for i in 0..sizes.len() {
        let after = (sizes.len() - i - 1) as u64;
        let room = most - least;
        let low = rest.saturating_sub(after * room);
        let fair = rest as f64 / (after + 1) as f64;
        let drawn = (fair * stream.range(0.0, 2.0)).round() as u64;
        let extra = drawn.min(room).max(low).min(rest);
        sizes[i] += extra;
        rest -= extra;
    }
    sizes.into_iter().map(|n| n as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn herds_add_up_and_keep_to_the_sizes_of_groups() {
        for seed in 0..200u64 {
            let (min, max) = (1 + seed as u32 % 30, 1 + seed as u32 % 30 + (seed as u32 * 7) % 50);
            let individuals = u64::from(min) * (1 + seed * 13 % 97);
            let herds = herds_of(individuals, (min, max), (seed, 3));
            assert_eq!(herds.iter().map(|n| u64::from(*n)).sum::<u64>(), individuals);
            assert!(herds.iter().all(|n| (min..=max).contains(n)), "{herds:?} {min} {max}");
        }
    }

    #[test]
    fn solitary_animals_are_herds_of_one_and_too_few_make_none() {
        assert_eq!(herds_of(3, (1, 1), (0, 0)), vec![1, 1, 1]);
        assert_eq!(herds_of(4, (5, 9), (0, 0)), Vec::<u32>::new());
    }

    #[test]
    fn sizes_vary_and_depend_on_the_seed() {
        let a = herds_of(400, (5, 40), (1, 0));
        assert!(a.iter().max() > a.iter().min());
        assert_ne!(a, herds_of(400, (5, 40), (2, 0)));
    }
}
