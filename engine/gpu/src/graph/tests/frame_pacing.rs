//! Which frames let others have their turn.

use crate::graph::{Counts, FramePacing, FrameReport, PassReport, PassState};
use wgpu::{AdapterInfo, Backend, DeviceType};

fn pacing(kind: DeviceType) -> FramePacing {
    FramePacing::new(&AdapterInfo::new(kind, Backend::Vulkan))
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
fn one_slow_frame_does_not_keep_frames_interruptible() {
    let pacing = pacing(DeviceType::Cpu);
    assert!(pacing.is_interruptible(), "the first frame of a software driver is long");
    pacing.adapt(&frame(&[Some(1.0), Some(200.0)]));
    assert!(pacing.is_interruptible(), "a long pass");
    // 130 short passes take more than 40 ms in all, and longer still while each is waited for.
    pacing.adapt(&frame(&[Some(0.5); 130]));
    assert!(!pacing.is_interruptible(), "no pass is long");
    pacing.adapt(&frame(&[Some(0.5), Some(30.0)]));
    assert!(pacing.is_interruptible(), "one is again");
    pacing.adapt(&frame(&[None, None]));
    assert!(pacing.is_interruptible(), "without times it stays as it was");
}

#[test]
fn hardware_is_never_paced() {
    use DeviceType::{DiscreteGpu, IntegratedGpu, Other, VirtualGpu};
    for kind in [DiscreteGpu, IntegratedGpu, VirtualGpu, Other] {
        let pacing = pacing(kind);
        assert!(!pacing.is_interruptible(), "{kind:?}: at first");
        pacing.adapt(&frame(&[Some(500.0)]));
        assert!(!pacing.is_interruptible(), "{kind:?}: after a long pass");
        pacing.set_interruptible(true);
        assert!(!pacing.is_interruptible(), "{kind:?}: asked for");
    }
}
