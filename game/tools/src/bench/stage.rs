//! The stages of a frame as the thesis names them, and which passes belong to each.

/// A stage: its short name, what it is, and the beginnings of its passes' names.
pub struct Stage {
    /// Short name, as in the thesis's table 7.3 where it has one.
    pub name: &'static str,
    /// Its work.
    pub what: &'static str,
    /// A pass belongs here if its name is one of these, or continues one with a space or a comma.
    passes: &'static [&'static str],
}

/// All stages, in the order of a frame. The one table to change where a pass comes or goes.
pub const STAGES: &[Stage] = &[
    Stage { name: "GB", what: "G-buffer", passes: &["gbuffer"] },
    Stage { name: "SHD", what: "shadow maps", passes: &["shadow"] },
    Stage { name: "DIR", what: "direct light", passes: &["direct", "main light"] },
    Stage { name: "GRSM", what: "reflective shadow maps", passes: &["rsm"] },
    Stage { name: "IL", what: "inject light", passes: &["inject"] },
    Stage { name: "IB", what: "inject blockers that lights see", passes: &["blockers of lights"] },
    Stage { name: "IGB", what: "inject blockers that the camera sees", passes: &["blockers of the camera"] },
    Stage { name: "PRP", what: "merge blockers and propagate", passes: &["blockers", "propagate"] },
    Stage { name: "SRF", what: "place surfels", passes: &["surfels"] },
    Stage {
        name: "OPA",
        what: "opacity of cells and faces, and which of them surfels reach",
        passes: &["coverage", "links", "opacity"],
    },
    Stage {
        name: "RAD",
        what: "radiosity: links of surfels, the lights' first bounce, all further ones",
        passes: &["surfel links", "first bounce", "radiosity", "change of patches"],
    },
    Stage { name: "EMI", what: "emission of surfels, and of their bounces", passes: &["emit", "flux of the bounces"] },
    Stage { name: "SWP", what: "sweep the directions", passes: &["sweep"] },
    Stage { name: "RCV", what: "light received by surfels", passes: &["receive", "add"] },
    Stage {
        name: "REL",
        what: "relight",
        passes: &["relight", "ambient occlusion", "gloss", "sky levels", "sky reflection"],
    },
    Stage {
        name: "GAT",
        what: "final gather by rays, and its filter",
        passes: &["flux of lit texels", "RSM samples", "gather", "gather filter"],
    },
    Stage {
        name: "MIR",
        what: "mirror reflections by rays",
        passes: &["mirror", "mirror strays", "mirror filter, once", "mirror filter", "mirror average"],
    },
    Stage {
        name: "VPL",
        what: "virtual lights: particles, or texels of maps",
        passes: &["particles", "choice", "reach", "place", "virtual lights"],
    },
    Stage { name: "SHV", what: "shade by virtual lights", passes: &["vpl"] },
    Stage {
        name: "NEA",
        what: "light near a surface that virtual lights leave out, and its filter",
        passes: &["near"],
    },
    Stage {
        name: "RNG",
        what: "ranges of stochastically culled lights, by the error bound",
        passes: &["slc error bound", "slc ranges", "slc frames"],
    },
    Stage { name: "CUL", what: "cull lights to tiles or clusters", passes: &["slc cull"] },
    Stage {
        name: "SHS",
        what: "shade by the lights of a tile, or draw them",
        passes: &["slc shade", "slc splat", "slc gather"],
    },
    Stage { name: "FLT", what: "cross bilateral filter", passes: &["slc filter"] },
    Stage { name: "AVG", what: "average over frames", passes: &["average"] },
    Stage { name: "BVH", what: "bounding volume hierarchy, on the host", passes: &[] },
    Stage { name: "TRC", what: "path tracing", passes: &["reference"] },
    Stage { name: "HAZ", what: "light that media scatter: in cells, and towards the eye", passes: &["haze"] },
    Stage {
        name: "LOB",
        what: "second lobes, of clear coats and stretched highlights: what shows them, lights, reflections",
        passes: &["second lobe"],
    },
    Stage {
        name: "GLS",
        what: "what is seen through glass and in it, by rays, and the image behind it",
        passes: &["glass", "compose opaque"],
    },
    Stage { name: "BLD", what: "blended surfaces", passes: &["blend", "ambient"] },
    Stage { name: "CMP", what: "put the light together", passes: &["compose"] },
    Stage { name: "DOF", what: "depth of field", passes: &["depth of field"] },
    Stage { name: "TAA", what: "smooth edges over frames", passes: &["temporal anti-aliasing"] },
    Stage { name: "BLM", what: "bloom", passes: &["bloom"] },
    Stage { name: "TON", what: "tone map", passes: &["tone map"] },
    Stage { name: "FLM", what: "sharpening and grain", passes: &["film"] },
];

/// Where passes go that the table does not know; the report names them.
pub const OTHER: &str = "other";

/// The stage of a pass, if the table knows it.
pub fn stage_of(pass: &str) -> Option<&'static str> {
    let belongs =
        |name: &&str| pass.strip_prefix(*name).is_some_and(|rest| rest.is_empty() || rest.starts_with([' ', ',']));
    STAGES.iter().find(|stage| stage.passes.iter().any(belongs)).map(|stage| stage.name)
}

/// Place of a stage in the order of a frame; unknown ones come last.
pub fn order(stage: &str) -> usize {
    STAGES.iter().position(|known| known.name == stage).unwrap_or(STAGES.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_found_by_the_whole_word() {
        assert_eq!(stage_of("gbuffer"), Some("GB"));
        assert_eq!(stage_of("blockers of the camera, cascade 1"), Some("IGB"));
        assert_eq!(stage_of("blockers, cascade 1"), Some("PRP"));
        assert_eq!(stage_of("rsm spot light 3"), Some("GRSM"));
        assert_eq!(stage_of("inject, cascade 0"), Some("IL"));
        assert_eq!(stage_of("tone map"), Some("TON"));
        assert_eq!(stage_of("directory"), None);
        assert_eq!(stage_of("mystery"), None);
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = STAGES.iter().map(|stage| stage.name).chain([OTHER]).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), STAGES.len() + 1);
    }
}
