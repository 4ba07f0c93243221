//! Light that a scene asks for and its method leaves out, said with the name of the entity: for the frame's warnings.

use super::IndirectMethod;
use crate::render::frame::Frame;

/// The light that a frame leaves out under a method.
pub(in crate::render) fn of(frame: &Frame, method: &dyn IndirectMethod) -> Vec<String> {
    let mut lost = method.lost_light(frame);
    if let Some(medium) = frame.scene.media.first().filter(|_| !method.scatters_in_media(frame.scene)) {
        lost.push(format!(
            "`{}`: the fog scatters light of the lights alone, and light between surfaces passes it as clear air; `clpv` \
             with `transport: Sweep` takes it into account",
            medium.name
        ));
    }
    lost
}

/// The entity that holds a method's settings, as a message names it.
pub(super) fn entity(name: &str, component: &str) -> String {
    if name.is_empty() { format!("the scene's `{component}` component") } else { format!("`{name}`") }
}
