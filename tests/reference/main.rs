//! Light against images of an independent renderer, where `LIGHTWELL_REFERENCE` names their folder.

mod raster_and_paths;
mod sweep;
