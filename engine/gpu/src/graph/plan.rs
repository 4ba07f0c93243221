//! A compiled graph: the passes that run, in order, and the memory that they use.

use super::builder::Work;
use super::cache::Target;
use super::desc::ResourceDesc;
use super::handle::Version;
use super::key::{Key, Recipe};
use super::report::{PassReport, PassState, ResourceReport};

/// The result of [`Graph::compile`](super::Graph::compile). It is good for one execution, with the
/// cache that it was compiled against.
pub struct Plan<'a> {
    pub(super) graph: u64,
    pub(super) stamp: u64,
    pub(super) steps: Vec<Step<'a>>,
    pub(super) layout: Layout,
    pub(super) reports: Vec<PassReport>,
}

/// A pass that runs.
pub(super) struct Step<'a> {
    /// Index of the pass and of its report.
    pub pass: usize,
    pub name: String,
    pub reads: Vec<Version>,
    pub writes: Vec<StepWrite>,
    pub recipe: Recipe,
    pub work: Work<'a>,
}

/// A write: from one version to the next.
pub(super) struct StepWrite {
    pub from: Version,
    pub retained: bool,
    /// The key of what it makes.
    pub key: Key,
}

/// All resources, and the memory that transient ones share.
pub(super) struct Layout {
    pub resources: Vec<PlannedResource>,
    pub shared: Vec<ResourceDesc>,
}

pub(super) struct PlannedResource {
    pub name: String,
    pub desc: ResourceDesc,
    pub place: Place,
}

/// Where a resource lies.
pub(super) enum Place {
    /// In a shared piece of memory; `None` if no running pass uses it.
    Shared(Option<usize>),
    /// In the cache's slot of its name.
    Slot { written: bool },
    /// At the caller's.
    Imported(Option<Target>),
}

impl<'a> Plan<'a> {
    pub(super) fn new(
        graph: u64,
        stamp: u64,
        steps: Vec<Step<'a>>,
        layout: Layout,
        mut reports: Vec<PassReport>,
        skipped: Vec<(String, String)>,
    ) -> Self {
        let skipped =
            skipped.into_iter().map(|(name, why)| PassReport::new(name, PassState::Skipped(why.clone()), why));
        reports.extend(skipped);
        Self { graph, stamp, steps, layout, reports }
    }

    /// The state of each pass in the order of declaration; then the skipped ones.
    pub fn passes(&self) -> &[PassReport] {
        &self.reports
    }

    /// The names of the passes that will run, in order.
    pub fn running(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().map(|step| step.name.as_str())
    }

    /// The resources that will have memory, and who shares it.
    pub fn resources(&self) -> Vec<ResourceReport> {
        self.layout.reports()
    }
}

impl Layout {
    pub fn reports(&self) -> Vec<ResourceReport> {
        let used = self.resources.iter().filter(|resource| !matches!(resource.place, Place::Shared(None)));
        used.map(|resource| self.report(resource)).collect()
    }

    fn report(&self, resource: &PlannedResource) -> ResourceReport {
        let shares = |other: &&PlannedResource| match (&resource.place, &other.place) {
            (Place::Shared(Some(a)), Place::Shared(Some(b))) => a == b && other.name != resource.name,
            _ => false,
        };
        ResourceReport {
            name: resource.name.clone(),
            desc: resource.desc.clone(),
            bytes: resource.desc.bytes(),
            aliased_with: self.resources.iter().filter(shares).map(|other| other.name.clone()).collect(),
            retained: matches!(resource.place, Place::Slot { .. }),
            imported: matches!(resource.place, Place::Imported(_)),
        }
    }
}
