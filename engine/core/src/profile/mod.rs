//! Where the time of a frame goes: nested CPU spans, the GPU times beside them, and statistics over the last frames.
//!
//! ```
//! # extern crate lightwell_core as lightwell;
//! let mut profiler = lightwell::profile::Profiler::new();
//! for _ in 0..3 {
//!     profiler.frame(|frame| {
//!         let sum = frame.span("update", |frame| frame.span("animation", |_| (0..100).sum::<u32>()));
//!         frame.gpu("gbuffer", 1.5 + f64::from(sum) * 0.0);
//!     });
//! }
//! assert_eq!(profiler.statistics("gpu/gbuffer").map(|s| s.median), Some(1.5));
//! assert!(profiler.statistics("update/animation").is_some());
//! ```

use std::collections::{BTreeMap, VecDeque};
use std::time::Instant;

/// Number of frames that a [`Profiler`] remembers.
pub const FRAMES: usize = 500;

/// One measured stretch of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Names from the outermost span to this one, joined by `/`; GPU spans begin with `gpu/`.
    pub path: String,
    /// Number of spans around it.
    pub depth: usize,
    /// Start after the begin of the frame \[ms\]; zero for GPU spans, whose clock is another.
    pub start: f64,
    /// Length \[ms\].
    pub duration: f64,
}

/// The spans of one frame in the order in which they began; first the CPU's, then the GPU's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Spans.
    pub spans: Vec<Span>,
    /// Time from begin to end of the frame on the CPU \[ms\].
    pub duration: f64,
}

/// Minimum, median and maximum of a span over the remembered frames \[ms\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Number of frames that have the span.
    pub frames: usize,
    /// Shortest.
    pub min: f64,
    /// Median (the lower of the two middle ones for an even number).
    pub median: f64,
    /// Longest.
    pub max: f64,
}

impl Statistics {
    /// Of a set of times; none of an empty one.
    pub fn of(mut times: Vec<f64>) -> Option<Self> {
        times.sort_by(f64::total_cmp);
        let (min, max) = (*times.first()?, *times.last()?);
        Some(Self { frames: times.len(), min, median: times[(times.len() - 1) / 2], max })
    }
}

/// Records the spans of one frame, from [`FrameRecorder::begin`] to [`FrameRecorder::finish`].
#[derive(Debug)]
pub struct FrameRecorder {
    begin: Instant,
    stack: Vec<usize>,
    spans: Vec<Span>,
    gpu: Vec<Span>,
}

impl FrameRecorder {
    /// Begins a frame.
    pub fn begin() -> Self {
        Self { begin: Instant::now(), stack: Vec::new(), spans: Vec::new(), gpu: Vec::new() }
    }

    /// Ends the frame.
    pub fn finish(mut self) -> Frame {
        let duration = milliseconds(self.begin);
        self.spans.append(&mut self.gpu);
        Frame { spans: self.spans, duration }
    }

    /// Measures `work` under `name`, inside of the span that is open.
    pub fn span<R>(&mut self, name: &str, work: impl FnOnce(&mut Self) -> R) -> R {
        let index = self.spans.len();
        let path = match self.stack.last() {
            Some(&parent) => format!("{}/{name}", self.spans[parent].path),
            None => name.to_owned(),
        };
        let start = milliseconds(self.begin);
        self.spans.push(Span { path, depth: self.stack.len(), start, duration: 0.0 });
        self.stack.push(index);
        let result = work(self);
        self.stack.pop();
        self.spans[index].duration = milliseconds(self.begin) - start;
        result
    }

    /// Adds what another thread did, from `start` until now, outside of all spans. Spans of this thread may lie within.
    pub fn beside(&mut self, name: &str, start: Instant) {
        let duration = milliseconds(start);
        let start = start.saturating_duration_since(self.begin).as_secs_f64() * 1e3;
        let at = self.spans.iter().position(|span| span.start > start).unwrap_or(self.spans.len());
        let index = if self.stack.is_empty() { at } else { self.spans.len() };
        self.spans.insert(index, Span { path: name.to_owned(), depth: 0, start, duration });
    }

    /// Adds a pass's time on the GPU \[ms\].
    pub fn gpu(&mut self, name: &str, duration: f64) {
        self.gpu.push(Span { path: format!("gpu/{name}"), depth: 1, start: 0.0, duration });
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// A ring of the last [`FRAMES`] frames.
#[derive(Debug, Default)]
pub struct Profiler {
    frames: VecDeque<Frame>,
}

impl Profiler {
    /// An empty ring.
    pub fn new() -> Self {
        Self::default()
    }

    /// Measures one frame.
    pub fn frame<R>(&mut self, work: impl FnOnce(&mut FrameRecorder) -> R) -> R {
        let mut recorder = FrameRecorder::begin();
        let result = work(&mut recorder);
        self.push(recorder.finish());
        result
    }

    /// Adds a frame that a [`FrameRecorder`] measured; the oldest goes if the ring is full.
    pub fn push(&mut self, frame: Frame) {
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(frame);
    }

    /// The remembered frames, oldest first.
    pub fn frames(&self) -> impl DoubleEndedIterator<Item = &Frame> + ExactSizeIterator {
        self.frames.iter()
    }

    /// The newest frame.
    pub fn last(&self) -> Option<&Frame> {
        self.frames.back()
    }

    /// Statistics of whole frames.
    pub fn frame_statistics(&self) -> Option<Statistics> {
        Statistics::of(self.frames.iter().map(|f| f.duration).collect())
    }

    /// Statistics of the span of that path. Spans of one path in one frame count together.
    pub fn statistics(&self, path: &str) -> Option<Statistics> {
        Statistics::of(self.frames.iter().filter_map(|f| total(f, path)).collect())
    }

    /// Statistics of all spans, ordered by path.
    pub fn summary(&self) -> BTreeMap<String, Statistics> {
        let mut times: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for frame in &self.frames {
            let mut totals: BTreeMap<&str, f64> = BTreeMap::new();
            for span in &frame.spans {
                *totals.entry(&span.path).or_default() += span.duration;
            }
            for (path, time) in totals {
                times.entry(path).or_default().push(time);
            }
        }
        times.into_iter().filter_map(|(path, t)| Some((path.to_owned(), Statistics::of(t)?))).collect()
    }
}

/// The frames as a trace that Chrome's and Perfetto's viewers read: CPU spans on one track, GPU times on another, one
/// after the other as they are recorded (the device's own clock is not known here).
pub fn chrome_trace(frames: &[Frame]) -> String {
    let mut events = vec![
        r#"{"name":"thread_name","ph":"M","pid":1,"tid":1,"args":{"name":"CPU"}}"#.to_owned(),
        r#"{"name":"thread_name","ph":"M","pid":1,"tid":2,"args":{"name":"GPU"}}"#.to_owned(),
    ];
    let mut event = |name: &str, thread: u32, start: f64, duration: f64| {
        let name = name.replace('\\', "/").replace('"', "'");
        // Chrome counts in microseconds.
        let (start, duration) = (start * 1e3, duration * 1e3);
        events.push(format!(
            r#"{{"name":"{name}","ph":"X","pid":1,"tid":{thread},"ts":{start:.3},"dur":{duration:.3}}}"#
        ));
    };
    let mut begin = 0.0;
    for (number, frame) in frames.iter().enumerate() {
        event(&format!("frame {number}"), 1, begin, frame.duration);
        let mut device = begin;
        for span in &frame.spans {
            let name = span.path.rsplit('/').next().unwrap_or(&span.path);
            if span.path.starts_with("gpu/") {
                event(name, 2, device, span.duration);
                device += span.duration;
            } else {
                event(name, 1, begin + span.start, span.duration);
            }
        }
        begin = (begin + frame.duration).max(device);
    }
    format!("{{\"traceEvents\":[{}]}}\n", events.join(",\n"))
}

fn total(frame: &Frame, path: &str) -> Option<f64> {
    let mut durations = frame.spans.iter().filter(|s| s.path == path).map(|s| s.duration).peekable();
    durations.peek()?;
    Some(durations.sum())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn frame(times: &[(&str, f64)]) -> Frame {
        let span = |&(path, duration): &(&str, f64)| Span { path: path.to_owned(), depth: 0, start: 0.0, duration };
        Frame { spans: times.iter().map(span).collect(), duration: times.iter().map(|t| t.1).sum() }
    }

    #[test]
    fn statistics_are_exact() {
        assert_eq!(Statistics::of(vec![]), None);
        let of = Statistics::of(vec![4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!(of, Statistics { frames: 4, min: 1.0, median: 2.0, max: 4.0 });
    }

    #[test]
    fn traces_name_every_span() {
        let mut first = frame(&[("update", 1.0), ("gpu/gbuffer", 2.5)]);
        first.duration = 2.0;
        let trace = chrome_trace(&[first, frame(&[("a \"b\"", 1.0)])]);
        for part in
            [r#""name":"update","ph":"X","pid":1,"tid":1,"ts":0.000,"dur":1000.000"#, r#""name":"gbuffer""#, "a 'b'"]
        {
            assert!(trace.contains(part), "{trace}");
        }
        assert!(trace.contains(r#""name":"frame 1","ph":"X","pid":1,"tid":1,"ts":2500.000"#), "{trace}");
    }

    #[test]
    fn the_ring_forgets_the_oldest() {
        let mut profiler = Profiler::new();
        for i in 0..FRAMES + 10 {
            profiler.push(frame(&[("a", i as f64)]));
        }
        let of = profiler.statistics("a").unwrap();
        assert_eq!((of.frames, of.min, of.max), (FRAMES, 10.0, (FRAMES + 9) as f64));
        assert_eq!(profiler.frames().len(), FRAMES);
    }

    #[test]
    fn spans_of_one_path_count_together() {
        let mut profiler = Profiler::new();
        profiler.push(frame(&[("a", 1.0), ("b", 5.0), ("a", 2.0)]));
        profiler.push(frame(&[("b", 7.0)]));
        assert_eq!(profiler.statistics("a").unwrap().max, 3.0);
        assert_eq!(profiler.statistics("b").unwrap().frames, 2);
        assert_eq!(profiler.statistics("c"), None);
        assert_eq!(profiler.summary().keys().collect::<Vec<_>>(), ["a", "b"]);
    }

    #[test]
    fn spans_nest() {
        let mut profiler = Profiler::new();
        profiler.frame(|f| {
            f.span("outer", |f| {
                f.span("first", |_| ());
                f.span("second", |_| std::thread::sleep(std::time::Duration::from_millis(2)));
            });
            f.gpu("pass", 0.5);
        });
        let spans = &profiler.last().unwrap().spans;
        let paths: Vec<_> = spans.iter().map(|s| (s.path.as_str(), s.depth)).collect();
        assert_eq!(paths, [("outer", 0), ("outer/first", 1), ("outer/second", 1), ("gpu/pass", 1)]);
        assert!(spans[2].duration >= 2.0 && spans[0].duration >= spans[2].duration);
        assert!(profiler.last().unwrap().duration >= spans[0].duration);
    }
}
