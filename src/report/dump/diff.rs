//! Comparing two dumps.
