//! Results of a run over random rooms: `rooms.json`.

use super::room::RoomFacts;
use crate::bench::results::{Header, LayerError, finite, write_whole};
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Everything that a run found. Every finished room is written at once, so that a run can be taken up again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Where and with what it was measured.
    pub header: Header,
    /// The methods.
    pub methods: Vec<MethodFigures>,
    /// The rooms by their numbers.
    pub rooms: Vec<RoomFigures>,
}

/// A method that is judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MethodFigures {
    /// Its name in tables.
    pub name: String,
    /// Description.
    pub what: String,
    /// All that makes it what it is.
    pub identity: String,
    /// Images that are averaged.
    pub images: u32,
}

/// The results of a room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoomFigures {
    /// Properties of the room.
    pub facts: RoomFacts,
    /// Its reference.
    pub reference: ReferenceFigures,
    /// The errors of each method, in their order.
    pub errors: Vec<RoomError>,
    /// Time that it took [s].
    pub seconds: f64,
}

/// The path-traced image of a room.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceFigures {
    /// Samples a pixel.
    pub samples: u32,
    /// Noise of indirect light, relative to its mean.
    #[serde(with = "finite")]
    pub noise: f64,
    /// Whether the limit of samples was reached before the noise was low enough.
    pub limited: bool,
    /// Mean of direct light [W/(m² sr)].
    pub direct: f64,
    /// Mean of indirect light [W/(m² sr)].
    pub indirect: f64,
    /// Share of the indirect light that has met more than one surface before the visible one.
    #[serde(with = "finite")]
    pub further_bounces: f64,
    /// Share of the pixels that are near a geometric edge.
    pub near_edges: f64,
}

/// Errors of a method in a room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoomError {
    /// Name of the method.
    pub method: String,
    /// Of indirect light.
    pub indirect: LayerError,
    /// One standard error of the nrmse of indirect light, upwards: what the noise of the reference leaves open.
    #[serde(with = "finite")]
    pub uncertainty: f64,
    /// Of all light.
    pub total: LayerError,
    /// Of indirect light near geometric edges; none if there are none.
    pub edges: Option<PartError>,
    /// Of indirect light elsewhere.
    pub elsewhere: Option<PartError>,
}

/// Errors of indirect light in a part of the image, relative to the mean of the whole image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartError {
    /// Root mean square error, without the reference's noise.
    #[serde(with = "finite")]
    pub nrmse: f64,
    /// Mean error; positive: too bright.
    #[serde(with = "finite")]
    pub bias: f64,
}

/// The figures in their file.
pub struct Store {
    path: PathBuf,
    /// The figures.
    pub figures: Figures,
}

impl Store {
    /// Takes up the figures of a folder, or begins new ones.
    ///
    /// # Errors
    /// If the folder holds those of another adapter, program, seed or other settings, or cannot be read.
    pub fn open(folder: &Path, header: Header, methods: Vec<MethodFigures>, fresh: bool) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join("rooms.json");
        let figures = match if fresh { None } else { read(&path)? } {
            None => Figures { header, methods, rooms: Vec::new() },
            Some(old) => {
                old.header.check_same_source(&header, &path)?;
                if old.header.settings != header.settings || old.methods != methods {
                    bail!(
                        "{} holds rooms of other settings or methods ({}, now {}); add --fresh to replace them, or give \
                         another folder",
                        path.display(),
                        old.header.settings,
                        header.settings
                    );
                }
                old
            }
        };
        Ok(Self { path, figures })
    }

    /// Whether a room is measured.
    pub fn has(&self, index: u64) -> bool {
        self.figures.rooms.iter().any(|room| room.facts.index == index)
    }

    /// Adds a room.
    pub fn add(&mut self, room: RoomFigures) {
        self.figures.rooms.push(room);
        self.figures.rooms.sort_by_key(|room| room.facts.index);
    }

    /// Writes all in one step.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.figures)?;
        write_whole(&self.path, text.as_bytes())
    }
}

impl Figures {
    /// The rooms with the greatest errors of indirect light of a method (nrmse), worst first.
    pub fn worst(&self, method: usize, count: usize) -> Vec<&RoomFigures> {
        let mut rooms: Vec<&RoomFigures> = self.rooms.iter().collect();
        rooms.sort_by(|a, b| b.errors[method].indirect.nrmse.total_cmp(&a.errors[method].indirect.nrmse));
        rooms.truncate(count);
        rooms
    }
}

fn read(path: &Path) -> Result<Option<Figures>> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let read = serde_json::from_str(&text);
    read.map(Some).with_context(|| format!("{} holds no rooms; add --fresh to replace it", path.display()))
}
