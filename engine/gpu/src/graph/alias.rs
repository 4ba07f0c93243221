//! Sharing of memory between transient targets whose lifetimes do not overlap.

use super::desc::ResourceDesc;

/// The first and last step, inclusive, at which a target is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lifetime {
    first: usize,
    last: usize,
}

/// Extends a lifetime to a step.
pub(super) fn extend(lifetime: &mut Option<Lifetime>, step: usize) {
    *lifetime = match *lifetime {
        None => Some(Lifetime { first: step, last: step }),
        Some(Lifetime { first, last }) => Some(Lifetime { first: first.min(step), last: last.max(step) }),
    };
}

/// Gives each target (index, description, lifetime) of `count` resources a piece of memory:
/// the first free one with its description, in the order of first use. Returns the pieces, and
/// the piece of each resource.
pub(super) fn assign(
    mut targets: Vec<(usize, &ResourceDesc, Lifetime)>,
    count: usize,
) -> (Vec<ResourceDesc>, Vec<Option<usize>>) {
    targets.sort_by_key(|(index, _, lifetime)| (lifetime.first, *index));
    let mut pieces: Vec<(ResourceDesc, usize)> = Vec::new();
    let mut assigned = vec![None; count];
    for (index, desc, lifetime) in targets {
        let free = pieces.iter().position(|(of, last)| of == desc && *last < lifetime.first);
        let piece = free.unwrap_or_else(|| {
            pieces.push((desc.clone(), 0));
            pieces.len() - 1
        });
        pieces[piece].1 = lifetime.last;
        assigned[index] = Some(piece);
    }
    (pieces.into_iter().map(|(desc, _)| desc).collect(), assigned)
}
