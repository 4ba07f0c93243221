//! README, book and crates against what they say.

mod book;
mod crates;
mod figures;
mod words;
