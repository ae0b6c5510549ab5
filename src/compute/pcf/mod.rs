//! Pair correlation functions: learn how things are arranged from an example, arrange new ones alike.
