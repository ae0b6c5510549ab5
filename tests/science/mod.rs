//! What must be true: closed forms, invariants, conserved sums, outside checks.
