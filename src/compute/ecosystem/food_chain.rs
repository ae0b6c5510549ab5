//! **Food-chain levels** from diets (L 3.1): plants are level 0, an animal one more than the
//! highest of its foods.

use crate::compute::ecosystem::species::DietItem;
use crate::compute::ecosystem::species::Food;

/// The level of each animal, given what each eats; or a cycle, as the indices of its members in
/// the order of who eats whom. An index that a diet names must exist. An animal that eats
/// nothing is of level 1.
pub fn levels<'a>(diets: impl IntoIterator<Item = &'a [DietItem]>) -> Result<Vec<usize>, Vec<usize>> {
    let prey: Vec<Vec<usize>> = diets.into_iter().map(animals_of).collect();
    let mut level = vec![0; prey.len()];
    // Each round settles at least one animal, or the rest lies on or above a cycle.
    for _ in 0..prey.len() {
        let settled = |i: &usize| level[*i] > 0;
        let next: Vec<(usize, usize)> = (0..prey.len())
            .filter(|i| level[*i] == 0 && prey[*i].iter().all(settled))
            .map(|i| (i, 1 + prey[i].iter().map(|p| level[*p]).max().unwrap_or(0)))
            .collect();
        next.iter().for_each(|(i, l)| level[*i] = *l);
    }
    match level.iter().position(|l| *l == 0) {
        None => Ok(level),
        Some(start) => Err(cycle(&prey, &level, start)),
    }
}

fn animals_of(diet: &[DietItem]) -> Vec<usize> {
    diet.iter().filter_map(|item| if let Food::Animal(i) = item.food { Some(i) } else { None }).collect()
}

/// Follows unsettled prey from `start` until an animal comes up again.
fn cycle(prey: &[Vec<usize>], level: &[usize], start: usize) -> Vec<usize> {
    let mut path = vec![start];
    for _ in 0..prey.len() {
        let last = path[path.len() - 1];
        let Some(&next) = prey[last].iter().find(|p| level[**p] == 0) else { break };
        if let Some(first) = path.iter().position(|p| *p == next) {
            return path.split_off(first);
        }
        path.push(next);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eats(foods: &[Food]) -> Vec<DietItem> {
        foods.iter().map(|food| DietItem { food: *food, preference: 1.0 }).collect()
    }

    fn of(diets: &[Vec<DietItem>]) -> Result<Vec<usize>, Vec<usize>> {
        levels(diets.iter().map(Vec::as_slice))
    }

    #[test]
    fn a_chain_gets_rising_levels_whatever_its_order() {
        let diets = [eats(&[Food::Animal(1)]), eats(&[Food::Animal(2), Food::Plant(0)]), eats(&[Food::Plant(0)])];
        assert_eq!(of(&diets), Ok(vec![3, 2, 1]));
    }

    #[test]
    fn a_cycle_is_named_without_those_who_only_eat_from_it() {
        let diets = [eats(&[Food::Animal(1)]), eats(&[Food::Animal(2)]), eats(&[Food::Animal(1)])];
        assert_eq!(of(&diets), Err(vec![1, 2]));
        assert_eq!(of(&[eats(&[Food::Animal(0)])]), Err(vec![0]));
    }
}
