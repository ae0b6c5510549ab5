//! How the atoms of a group are put together to the nodes of the graph.
//!
//! A group's **components** are the atoms that touch (tiles that share a side or a corner), so
//! gaps narrower than a tile do not part them. Each large component is split into compact patches
//! by halving it across its longer side; fragments join the patch whose centre is nearest, so
//! that nothing is lost.

use super::atoms::Atom;
use super::atoms::Atoms;

/// Puts each atom of the group (indices into `atoms`, ascending) into one of at most `patches`
/// patches; the answer is aligned with `group`, numbers count from 0 by first atom.
pub(super) fn patches_of(atoms: &Atoms, group: &[usize], patches: usize, min_cells: u32) -> Vec<usize> {
    let wanted = patches.max(1);
    let mut parts = components(atoms, group);
    parts.sort_by_key(|part| (std::cmp::Reverse(area(atoms, part)), part[0]));
    let large = parts.iter().take(wanted).take_while(|part| area(atoms, part) >= u64::from(min_cells)).count();
    let fragments: Vec<usize> = if large == 0 { Vec::new() } else { parts.split_off(large).concat() };
    let parts = if large == 0 { vec![group.to_vec()] } else { parts };
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for (part, n) in parts.iter().zip(shares(&parts.iter().map(|p| area(atoms, p)).collect::<Vec<u64>>(), wanted)) {
        halve(atoms, part.clone(), n, &mut pieces);
    }
    let centres: Vec<(f64, f64)> = pieces.iter().map(|piece| centre(atoms, piece)).collect();
    for atom in fragments {
        pieces[nearest(&centres, atoms.atoms[atom].centre())].push(atom);
    }
    number(group, pieces)
}

/// Components of a group, each ascending.
fn components(atoms: &Atoms, group: &[usize]) -> Vec<Vec<usize>> {
    let mut seen = vec![false; group.len()];
    let mut parts = Vec::new();
    for start in 0..group.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut part, mut stack) = (vec![group[start]], vec![group[start]]);
        while let Some(at) = stack.pop() {
            for next in touching(atoms, &atoms.atoms[at]) {
                let Ok(i) = group.binary_search(&next) else { continue };
                if !std::mem::replace(&mut seen[i], true) {
                    part.push(next);
                    stack.push(next);
                }
            }
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

/// Atoms of the same group in the up to eight tiles around.
fn touching<'a>(atoms: &'a Atoms, atom: &Atom) -> impl Iterator<Item = usize> + 'a {
    let (tiles, group) = (atoms.tiles, atom.group);
    tiles.around(atom.tile as usize).filter_map(move |tile| atoms.find(tile, group))
}

fn area(atoms: &Atoms, part: &[usize]) -> u64 {
    part.iter().map(|a| u64::from(atoms.atoms[*a].cells)).sum()
}

fn centre(atoms: &Atoms, part: &[usize]) -> (f64, f64) {
    let n = area(atoms, part) as f64;
    let sum = part.iter().fold((0.0, 0.0), |s, a| (s.0 + atoms.atoms[*a].columns, s.1 + atoms.atoms[*a].rows));
    (sum.0 / n, sum.1 / n)
}

fn nearest(centres: &[(f64, f64)], at: (f64, f64)) -> usize {
    let distance = |c: &(f64, f64)| (c.0 - at.0).powi(2) + (c.1 - at.1).powi(2);
    (0..centres.len()).min_by(|a, b| distance(&centres[*a]).total_cmp(&distance(&centres[*b]))).unwrap_or(0)
}

/// Shares `total` out by `areas` (largest remainders), at least one each.
fn shares(areas: &[u64], total: usize) -> Vec<usize> {
    let sum: u64 = areas.iter().sum::<u64>().max(1);
    let free = total.saturating_sub(areas.len());
    let exact = |a: &u64| free as f64 * *a as f64 / sum as f64;
    let mut shares: Vec<usize> = areas.iter().map(|a| 1 + exact(a).floor() as usize).collect();
    let mut order: Vec<usize> = (0..areas.len()).collect();
    order.sort_by(|a, b| exact(&areas[*b]).fract().total_cmp(&exact(&areas[*a]).fract()).then(a.cmp(b)));
    let given: usize = shares.iter().sum();
    order.iter().take(total.saturating_sub(given)).for_each(|i| shares[*i] += 1);
    shares
}

/// Splits `part` into `n` pieces of about equal area, halving across the longer side.
fn halve(atoms: &Atoms, mut part: Vec<usize>, n: usize, pieces: &mut Vec<Vec<usize>>) {
    if n <= 1 || part.len() <= 1 {
        pieces.push(part);
        return;
    }
    let tile = |a: usize| {
        let tile = atoms.atoms[a].tile as usize;
        (tile % atoms.tiles.columns, tile / atoms.tiles.columns)
    };
    let spread = |of: &dyn Fn(usize) -> usize| {
        let values = part.iter().map(|a| of(*a));
        values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
    };
    let wide = spread(&|a| tile(a).0) >= spread(&|a| tile(a).1);
    part.sort_by_key(|a| if wide { tile(*a) } else { (tile(*a).1, tile(*a).0) });
    let goal = area(atoms, &part) as f64 * (n / 2) as f64 / n as f64;
    let mut sum = 0.0;
    let at = part.iter().position(|a| {
        sum += f64::from(atoms.atoms[*a].cells);
        sum >= goal
    });
    let rest = part.split_off(at.map_or(1, |i| i + 1).clamp(1, part.len() - 1));
    halve(atoms, part, n / 2, pieces);
    halve(atoms, rest, n - n / 2, pieces);
}

/// The number of the piece that holds each atom of `group`; pieces counted by first atom.
fn number(group: &[usize], mut pieces: Vec<Vec<usize>>) -> Vec<usize> {
    pieces.iter_mut().for_each(|piece| piece.sort_unstable());
    pieces.sort_by_key(|piece| piece.first().copied());
    let mut numbers = vec![0; group.len()];
    for (n, atom) in pieces.iter().enumerate().flat_map(|(n, piece)| piece.iter().map(move |a| (n, a))) {
        if let Ok(i) = group.binary_search(atom) {
            numbers[i] = n;
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Tiling;

    /// Atoms of 10 cells at the marked tiles, all of one group.
    fn drawing(rows: &[&str]) -> (Atoms, Vec<usize>) {
        let columns = rows[0].len();
        let tiles = Tiling { shift: 2, columns, rows: rows.len() };
        let (mut atoms, mut first) = (Vec::new(), vec![0]);
        for (i, mark) in rows.concat().bytes().enumerate() {
            if mark == b'#' {
                let (x, y) = ((i % columns) as f64, (i / columns) as f64);
                atoms.push(Atom { tile: i as u32, group: 0, cells: 10, kg: 1.0, columns: 10.0 * x, rows: 10.0 * y });
            }
            first.push(atoms.len() as u32);
        }
        let group = (0..atoms.len()).collect();
        (Atoms { tiles, atoms, first }, group)
    }

    fn sizes(numbers: &[usize]) -> Vec<usize> {
        let n = numbers.iter().max().map_or(0, |m| m + 1);
        (0..n).map(|k| numbers.iter().filter(|i| **i == k).count()).collect()
    }

    #[test]
    fn two_meadows_are_two_nodes_and_a_tuft_joins_the_nearer_one() {
        let (atoms, group) = drawing(&["####......", "####....##", "####....##", "......#...", "........##"]);
        assert_eq!(sizes(&patches_of(&atoms, &group, 2, 15)), vec![12, 7]);
        assert_eq!(sizes(&patches_of(&atoms, &group, 1, 15)), vec![19]);
    }

    #[test]
    fn a_wide_meadow_is_split_into_compact_equal_patches() {
        let row = "#".repeat(32);
        let (atoms, group) = drawing(&[row.as_str(); 8]);
        let numbers = patches_of(&atoms, &group, 4, 1);
        assert_eq!(sizes(&numbers), vec![64; 4]);
        for patch in 0..4 {
            let columns: Vec<usize> = group.iter().filter(|a| numbers[**a] == patch).map(|a| a % 32).collect();
            assert_eq!(columns.iter().max().unwrap() - columns.iter().min().unwrap(), 7);
        }
    }

    #[test]
    fn fragments_alone_make_patches_by_nearness() {
        let (atoms, group) = drawing(&["#.#.......#.#", ".............", "#.#.......#.#"]);
        assert_eq!(sizes(&patches_of(&atoms, &group, 2, 1000)), vec![4, 4]);
    }
}
