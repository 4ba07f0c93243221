//! The editor: a scene in a window, with panels around the picture to look at it and to change it.
//!
//! In come a scene by file or name ([`Opening`]) and the components of a game that it may hold and its systems ([`EditedGame`]); out
//! go scene files that were saved, screenshots and exported animations.
//!
//! | to | look at |
//! | --- | --- |
//! | open a scene in the editor | [`Display::edit`] |
//! | show a component of a game in the inspector | [`CustomComponent::of`] |
//! | have the editor play a game | [`PlayedGame`], [`EditedGame`]; `src/play/playing.rs` |
//! | add a panel, a dialog, a key | `src/editor`: panels, selection and history, which know neither device nor window |
//! | change what the window does with what the panels ask for | `src/play`: the window, the thread that draws, exports |
//! | change how the reference is shown beside the picture | `src/comparison.rs` |

mod comparison;
mod editor;
mod play;

pub use editor::CustomComponent;
pub use play::{Display, EditedGame, NewGame, Opening, Overlay, PlayedGame};
