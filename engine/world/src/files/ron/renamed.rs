//! Names of components in earlier versions of the format.

/// Components of the engine that had another name in earlier versions, with the one that they have now.
pub(in crate::files) const RENAMED: [(&str, &str); 1] = [("Ghost", "NonSolid")];

/// The present name of a component of the engine that had another one.
pub(in crate::files) fn present_name(old: &str) -> Option<&'static str> {
    RENAMED.iter().find(|(known, _)| *known == old).map(|(_, new)| *new)
}
