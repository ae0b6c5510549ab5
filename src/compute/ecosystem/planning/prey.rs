//! Where and when prey can be met: the node of a carnivore is "the current position of the herd
//! they are tracking, extracted from its planning" (L 6.2).

use super::DAY_S;
use super::Planning;
use super::Visit;

/// How far before its prey a hunter may arrive, seconds (ours).
pub(crate) const PATIENCE_S: f64 = 3600.0;

/// A stay of a prey herd that a hunter reaches in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    pub(crate) cell: usize,
    /// When the hunter is there and so is the prey.
    pub(crate) from: f64,
    /// When the prey leaves.
    pub(crate) until: f64,
}

/// The stays of a prey's planning that a hunter who sets out at `now` reaches at least `shortest`
/// before they end, and not more than `patience` before they begin; earliest first. `travel`
/// gives seconds to a cell. All times on the hunter's clock.
pub(crate) fn meetings<E>(
    prey: &Planning,
    now: f64,
    (shortest, patience): (f64, f64),
    mut travel: impl FnMut(usize) -> Result<f64, E>,
) -> Result<Option<Meeting>, E> {
    let mut best: Option<Meeting> = None;
    for stay in stays(prey) {
        let seconds = travel(stay.cell)?;
        if !seconds.is_finite() {
            continue;
        }
        // The same stay today, tomorrow and the day after, on the hunter's clock.
        let there = now + seconds;
        let first = ((there + shortest - stay.leave_s) / DAY_S).ceil() * DAY_S;
        let (arrive, leave) = (stay.arrive_s + first, stay.leave_s + first);
        let meeting = Meeting { cell: stay.cell, from: there.max(arrive), until: leave };
        let sooner = best.is_none_or(|b| (meeting.from, meeting.cell) < (b.from, b.cell));
        if arrive - there <= patience && sooner {
            best = Some(meeting);
        }
    }
    Ok(best)
}

/// Where the prey is and from when to when, whatever it does there: who feeds and then waits at
/// the same place is there all the time, and so is who rests there and feeds the next morning.
fn stays(prey: &Planning) -> Vec<Visit> {
    let together = |a: &Visit, b: &Visit| a.cell == b.cell && a.leave_s == b.arrive_s;
    let merged = |visits: &[Visit]| Visit { leave_s: visits[visits.len() - 1].leave_s, ..visits[0] };
    let mut stays: Vec<Visit> = prey.visits.chunk_by(together).map(merged).collect();
    if let [first, .., last] = stays.as_mut_slice()
        && first.cell == last.cell
    {
        last.leave_s += first.leave_s - first.arrive_s;
        stays.remove(0);
    }
    stays.retain(|stay| stay.leave_s > stay.arrive_s);
    stays
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::planning::Activity;

    const HOUR: f64 = 3600.0;

    fn visit(cell: usize, from: f64, to: f64) -> Visit {
        let (arrive_s, leave_s) = (from * HOUR, to * HOUR);
        Visit { node: 0, cell, arrive_s, leave_s, activity: Activity::Feed, prey: None }
    }

    fn meet(now: f64, seconds: f64) -> Option<Meeting> {
        let prey = Planning { visits: vec![visit(1, 6.0, 9.0), visit(2, 10.0, 20.0), visit(1, 21.0, 30.0)] };
        meetings(&prey, now * HOUR, (600.0, HOUR), |_| Ok::<f64, ()>(seconds)).unwrap()
    }

    #[test]
    fn prey_is_met_where_it_is_when_the_hunter_arrives() {
        let meeting = meet(7.0, HOUR).unwrap();
        assert_eq!((meeting.cell, meeting.from, meeting.until), (1, 8.0 * HOUR, 9.0 * HOUR));
        // Too late for the first stay: it lies in wait at the next.
        let meeting = meet(8.0, HOUR).unwrap();
        assert_eq!((meeting.cell, meeting.from, meeting.until), (2, 10.0 * HOUR, 20.0 * HOUR));
        // After midnight on the hunter's clock the prey still rests, and begins its next day there.
        assert_eq!(meet(26.0, 60.0).unwrap().until, 33.0 * HOUR);
        assert_eq!(meet(31.0, 60.0).unwrap().until, 33.0 * HOUR);
    }

    #[test]
    fn prey_that_feeds_and_then_waits_at_the_same_place_is_there_all_the_time() {
        let prey = Planning { visits: vec![visit(1, 6.0, 9.0), visit(1, 9.0, 11.0), visit(2, 12.0, 20.0)] };
        let met = meetings(&prey, 8.9 * HOUR, (600.0, HOUR), |_| Ok::<f64, ()>(60.0)).unwrap().unwrap();
        assert_eq!((met.cell, met.until), (1, 11.0 * HOUR));
    }

    #[test]
    fn prey_that_cannot_be_reached_is_not_met() {
        assert_eq!(meet(7.0, f64::INFINITY), None);
    }
}
