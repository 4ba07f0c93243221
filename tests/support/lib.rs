//! Shared helpers of the scene tests.
