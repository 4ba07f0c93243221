//! What README, book and crates say and hold.

mod book;
mod crates;
mod figures;
