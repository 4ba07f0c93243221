//! Which frames let others have their turn.

use crate::graph::{Counts, FrameReport, Pace, PassReport, PassState};
use wgpu::{AdapterInfo, Backend, DeviceType};

fn pace(kind: DeviceType) -> Pace {
    Pace::new(&AdapterInfo::new(kind, Backend::Vulkan))
}

/// A frame of passes with those times on the device [ms], each recorded in two seconds, as where pipelines compile.
fn frame(times: &[Option<f64>]) -> FrameReport {
    let pass = |gpu_ms: &Option<f64>| PassReport {
        name: "pass".into(),
        state: PassState::Ran,
        why: String::new(),
        counts: Counts::default(),
        gpu_ms: *gpu_ms,
        cpu_ms: 2000.0,
    };
    FrameReport { passes: times.iter().map(pass).collect(), ..Default::default() }
}

#[test]
fn one_slow_frame_does_not_keep_the_pace_on() {
    let pace = pace(DeviceType::Cpu);
    assert!(pace.is_gentle(), "the first frame of a software driver is long");
    pace.adapt(&frame(&[Some(1.0), Some(200.0)]));
    assert!(pace.is_gentle(), "a long pass");
    // 130 short passes take more than 40 ms in all, and longer still while each is waited for.
    pace.adapt(&frame(&[Some(0.5); 130]));
    assert!(!pace.is_gentle(), "no pass is long");
    pace.adapt(&frame(&[Some(0.5), Some(30.0)]));
    assert!(pace.is_gentle(), "one is again");
    pace.adapt(&frame(&[None, None]));
    assert!(pace.is_gentle(), "without times it stays as it was");
}

#[test]
fn hardware_is_never_paced() {
    use DeviceType::{DiscreteGpu, IntegratedGpu, Other, VirtualGpu};
    for kind in [DiscreteGpu, IntegratedGpu, VirtualGpu, Other] {
        let pace = pace(kind);
        assert!(!pace.is_gentle(), "{kind:?}: at first");
        pace.adapt(&frame(&[Some(500.0)]));
        assert!(!pace.is_gentle(), "{kind:?}: after a long pass");
        pace.set_gentle(true);
        assert!(!pace.is_gentle(), "{kind:?}: asked for");
    }
}
