//! README, book, crates and wording against their rules.

mod book;
mod crates;
mod figures;
mod methods;
mod words;
