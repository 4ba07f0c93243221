//! A frame budget: how large frames are drawn so that they come at a rate. The window shows them enlarged.
//!
//! What a frame takes grows with its pixels. Where frames come too late, or there is time to spare, the number of pixels is
//! changed in that ratio. After each change a few frames pass before the next decision, since light that is averaged
//! over frames starts anew in another size; and a larger size that turns out too slow is tried again twice as late as before.

use std::collections::VecDeque;

/// Frames whose median decides.
const FRAMES: usize = 12;
/// Frames after a change that are not looked at.
const SETTLING: usize = 4;
/// Frames to pass before a larger size is tried: at first those of a second, and at least so many; at most a multiple.
const LEAST_PATIENCE: usize = 16;
const MOST_PATIENCE: usize = 1 << 6;
/// Share of the time of a frame beyond which frames come too late, below which there is time to spare, and which another size
/// aims at.
const LATE: f32 = 1.1;
const SPARE: f32 = 0.7;
const AIM: f32 = 0.9;
/// Least scale, and steps that there are to 1.
const LEAST: f32 = 0.25;
const STEPS: f32 = 32.0;
/// Most that a scale shrinks or grows at once.
const SHRINK: f32 = 0.6;
const GROW: f32 = 1.2;
/// Frames per second that software drivers are asked for, and cards where the display does not tell its rate.
const SOFTWARE_RATE: f32 = 10.0;
const CARD_RATE: f32 = 60.0;
/// Scale of the first frame with a software driver.
const FIRST_ON_SOFTWARE: f32 = 0.5;

/// Chooses the scale of frames.
#[derive(Debug)]
pub struct FrameBudget {
    /// Time of a frame \[s\].
    frame: f32,
    scale: f32,
    most: f32,
    /// Times between frames, and what of them the frame took \[s\].
    times: VecDeque<[f32; 2]>,
    since_change: usize,
    patience: usize,
    /// Whether the last change was to a larger size.
    has_grown: bool,
    is_late: bool,
}

impl FrameBudget {
    /// For the rate that is asked for, where 0 is for none; else for that of the display, or ten frames a second with a
    /// software driver, which begins with half the size.
    pub fn choose(asked: Option<f32>, most: f32, display: Option<f32>, is_software: bool) -> Option<Self> {
        match (asked, is_software) {
            (Some(rate), _) => Self::new(rate, most),
            (None, false) => Self::new(display.filter(|rate| *rate >= 1.0).unwrap_or(CARD_RATE), most),
            (None, true) => {
                let budget = Self::new(SOFTWARE_RATE, most)?;
                Some(Self { scale: most.min(FIRST_ON_SOFTWARE.max(LEAST)), ..budget })
            }
        }
    }

    /// For frames per second, at most that scale of the window's size. None if the rate is no positive number.
    pub fn new(frames_per_second: f32, most: f32) -> Option<Self> {
        let frame = 1.0 / frames_per_second;
        (frame > 0.0 && frame.is_finite()).then(|| Self {
            frame,
            scale: most,
            most,
            times: VecDeque::new(),
            since_change: 0,
            patience: first_patience(frames_per_second),
            has_grown: false,
            is_late: false,
        })
    }

    /// Size at which the next frame is drawn for a window of a size \[pixels\].
    pub fn size(&self, window: [u32; 2]) -> [u32; 2] {
        window.map(|edge| ((edge as f32 * self.scale).ceil() as u32).clamp(1, edge.max(1)))
    }

    /// Takes note of a frame: the time since the one before, and what of it drawing took \[s\], which is less where the
    /// display sets the rate. Whether the next frame has another size.
    pub fn note(&mut self, between: f32, drawing: f32) -> bool {
        self.since_change += 1;
        if self.since_change <= SETTLING || !between.is_finite() || !drawing.is_finite() {
            return false;
        }
        self.times.push_back([between, drawing.min(between)]);
        if self.times.len() > FRAMES {
            self.times.pop_front();
        }
        if self.times.len() < FRAMES {
            return false;
        }
        let [between, drawing] = [0, 1].map(|which| median(self.times.iter().map(|times| times[which])));
        let is_late = between > LATE * self.frame;
        self.is_late = is_late && self.scale <= LEAST;
        let wanted = if is_late {
            self.scale * (AIM * self.frame / between).sqrt().max(SHRINK)
        } else if drawing < SPARE * self.frame && self.since_change >= self.patience {
            self.scale * (AIM * self.frame / drawing.max(1e-6)).sqrt().min(GROW)
        } else {
            return false;
        };
        self.change((wanted * STEPS).floor() / STEPS)
    }

    fn change(&mut self, wanted: f32) -> bool {
        let scale = wanted.clamp(LEAST.min(self.most), self.most);
        if scale == self.scale {
            return false;
        }
        let grows = scale > self.scale;
        if !grows && self.has_grown {
            self.patience = (2 * self.patience).min(MOST_PATIENCE * first_patience(1.0 / self.frame));
        }
        (self.scale, self.has_grown, self.since_change) = (scale, grows, 0);
        self.times.clear();
        true
    }

    /// What it chose and why, for the window.
    pub fn status(&self) -> String {
        let rate = 1.0 / self.frame;
        let percent = 100.0 * self.scale;
        if self.is_late {
            format!("{rate:.0} frames/s are out of reach at {percent:.0} % of the size")
        } else if self.scale < self.most {
            format!("{percent:.0} % of the size for {rate:.0} frames/s")
        } else {
            format!("{rate:.0} frames/s at full size")
        }
    }
}

/// The rate of the display that a window is on \[1/s\], if it tells.
pub fn display_rate(window: &winit::window::Window) -> Option<f32> {
    let rate = window.current_monitor()?.refresh_rate_millihertz()?;
    Some(1e-3 * rate as f32)
}

fn first_patience(frames_per_second: f32) -> usize {
    (frames_per_second as usize).max(LEAST_PATIENCE)
}

fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws frames that take so long at full size, beside a fixed part; how often the size changed, and the last scale.
    fn draw(budget: &mut FrameBudget, frames: usize, full: f32, fixed: f32, display: f32) -> (usize, f32) {
        let (mut changes, mut before) = (0, budget.scale);
        for frame in 0..frames {
            let noise = 1.0 + 0.04 * ((frame * 7 % 5) as f32 - 2.0) / 2.0;
            let drawing = (fixed + full * budget.scale * budget.scale) * noise;
            budget.note(drawing.max(display), drawing);
            changes += usize::from(budget.scale != before);
            before = budget.scale;
        }
        (changes, budget.scale)
    }

    #[test]
    fn a_slow_scene_is_drawn_smaller_until_frames_are_in_time_and_stays_so() {
        for full in [0.03, 0.08, 0.15] {
            let mut budget = FrameBudget::new(60.0, 1.0).expect("a rate");
            draw(&mut budget, 200, full, 0.002, 0.0);
            let time = 0.002 + full * budget.scale * budget.scale;
            assert!(time < LATE / 60.0, "{full}: {time} s a frame at {}", budget.scale);
            assert!(time > 0.5 / 60.0 || budget.scale == LEAST, "{full}: {time} s a frame at {}", budget.scale);
            let (changes, _) = draw(&mut budget, 3000, full, 0.002, 0.0);
            assert!(changes <= 8, "{full}: {changes} changes in 3000 frames");
        }
    }

    #[test]
    fn a_fast_scene_keeps_its_size_and_grows_back_to_it() {
        let mut budget = FrameBudget::new(60.0, 1.0).expect("a rate");
        assert_eq!(draw(&mut budget, 500, 0.005, 0.001, 1.0 / 60.0), (0, 1.0));
        draw(&mut budget, 100, 0.06, 0.001, 1.0 / 60.0);
        assert!(budget.scale < 0.6, "{}", budget.scale);
        let (_, scale) = draw(&mut budget, 2000, 0.005, 0.001, 1.0 / 60.0);
        assert_eq!(scale, 1.0);
    }

    #[test]
    fn what_is_out_of_reach_is_said() {
        let mut budget = FrameBudget::new(60.0, 1.0).expect("a rate");
        draw(&mut budget, 400, 2.0, 0.05, 0.0);
        assert_eq!(budget.scale, LEAST);
        assert!(budget.status().contains("out of reach"), "{}", budget.status());
        // A single late frame changes nothing.
        let mut budget = FrameBudget::new(60.0, 1.0).expect("a rate");
        draw(&mut budget, 100, 0.01, 0.0, 0.0);
        budget.note(0.5, 0.5);
        assert_eq!(budget.scale, 1.0);
    }

    #[test]
    fn a_rate_is_chosen_for_what_draws() {
        let rate = |budget: Option<FrameBudget>| budget.map(|budget| (1.0 / budget.frame).round());
        assert_eq!(rate(FrameBudget::choose(None, 1.0, Some(144.0), false)), Some(144.0));
        assert_eq!(rate(FrameBudget::choose(None, 1.0, None, false)), Some(60.0));
        assert_eq!(rate(FrameBudget::choose(Some(30.0), 1.0, Some(144.0), true)), Some(30.0));
        assert_eq!(rate(FrameBudget::choose(Some(0.0), 1.0, Some(144.0), true)), None, "0 is for no budget");
        let mut software = FrameBudget::choose(None, 1.0, Some(60.0), true).expect("a rate");
        assert_eq!(software.size([800, 600]), [400, 300], "the first frame comes soon");
        let (_, scale) = draw(&mut software, 200, 0.02, 0.0, 0.0);
        assert_eq!(scale, 1.0, "and what is fast grows within seconds");
    }

    #[test]
    fn sizes_and_rates_are_sane() {
        let mut budget = FrameBudget::new(30.0, 0.5).expect("a rate");
        assert_eq!(budget.size([101, 1]), [51, 1]);
        budget.note(f32::NAN, f32::INFINITY);
        assert_eq!(budget.size([0, 640]), [1, 320]);
        for rate in [0.0, -3.0, f32::NAN, f32::INFINITY] {
            assert!(FrameBudget::new(rate, 1.0).is_none(), "{rate}");
        }
    }
}
