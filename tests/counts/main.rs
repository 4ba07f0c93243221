//! Numbers of rays, lights and passes, which do not depend on the machine.

mod slc_cost;
mod thesis_counts;
mod vpl_cost;
