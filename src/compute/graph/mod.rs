//! Graphs and the problems solved on them: shortest paths over a grid, components, assignment.
