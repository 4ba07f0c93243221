//! A frame budget: how large frames are drawn so that they come at a rate, and how often light is brought up to date. The window
//! shows them enlarged.
//!
//! What a frame takes grows with its pixels. Where frames come too late, or there is time to spare, the number of pixels is
//! changed in that ratio. After each change a few frames pass before the next decision, since light that is averaged
//! over frames starts anew in another size; and a larger size that turns out too slow is tried again twice as late as before.
//!
//! What does not depend on the number of pixels comes next: at the least size the light between surfaces is brought up to date over
//! two frames, and then over four. With time to spare it goes the other way, first the light and then the size. Nothing goes
//! below that: a quarter of the width and height, a quarter of the surfels a frame.

use lightwell::render::UpdateRate;
use std::collections::VecDeque;

/// Frames whose median decides.
const FRAMES: usize = 12;
/// Fewer decide where they take so long together \[s\].
const FEW_FRAMES: usize = 3;
const LONG: f32 = 0.5;
/// Frames after a change that are not looked at, and fewer where they take so long together \[s\].
const SETTLING: usize = 4;
const FEW_SETTLING: usize = 1;
const LONG_SETTLING: f32 = 0.2;
/// Frames to pass before a larger size is tried: at first those of a second, and at least so many; at most a multiple.
const LEAST_PATIENCE: usize = 16;
const MOST_PATIENCE: usize = 1 << 6;
/// Share of the time of a frame beyond which frames come too late, below which there is time to spare, and which another size
/// aims at.
const LATE: f32 = 1.1;
const SPARE: f32 = 0.7;
const AIM: f32 = 0.9;
/// Times of a frame that take light to its lowest rate at once.
const MUCH_TOO_LATE: f32 = 1.5;
/// Least scale, and steps that there are to 1.
const LEAST: f32 = 0.25;
const STEPS: f32 = 32.0;
/// Most that a scale shrinks or grows at once.
const SHRINK: f32 = 0.5;
const GROW: f32 = 1.2;
/// Frames per second that software drivers are asked for, and cards where the display does not tell its rate.
const SOFTWARE_RATE: f32 = 10.0;
const CARD_RATE: f32 = 60.0;
/// Scale of the first frame with a software driver.
const FIRST_ON_SOFTWARE: f32 = 0.5;

/// Chooses the scale of frames, and how often light is brought up to date.
#[derive(Debug)]
pub struct FrameBudget {
    /// Time of a frame \[s\].
    frame: f32,
    scale: f32,
    most: f32,
    update: UpdateRate,
    /// Times between frames, and what of them the frame took \[s\].
    times: VecDeque<[f32; 2]>,
    since_change: usize,
    seconds_since_change: f32,
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
            update: UpdateRate::Whole,
            times: VecDeque::new(),
            since_change: 0,
            seconds_since_change: 0.0,
            patience: first_patience(frames_per_second),
            has_grown: false,
            is_late: false,
        })
    }

    /// Size at which the next frame is drawn for a window of a size \[pixels\].
    pub fn size(&self, window: [u32; 2]) -> [u32; 2] {
        window.map(|edge| ((edge as f32 * self.scale).ceil() as u32).clamp(1, edge.max(1)))
    }

    /// How often the next frame brings the light between surfaces up to date.
    pub fn update(&self) -> UpdateRate {
        self.update
    }

    /// Takes note of a frame: the time since the one before, and what of it drawing took \[s\], which is less where the
    /// display sets the rate. Whether the next frame is drawn otherwise.
    pub fn note(&mut self, between: f32, drawing: f32) -> bool {
        if !between.is_finite() || !drawing.is_finite() {
            return false;
        }
        self.since_change += 1;
        if !self.has_settled() {
            self.seconds_since_change += between;
            return false;
        }
        self.times.push_back([between, drawing.min(between)]);
        if self.times.len() > FRAMES {
            self.times.pop_front();
        }
        let all: f32 = self.times.iter().map(|[between, _]| between).sum();
        if self.times.len() < FRAMES && (self.times.len() < FEW_FRAMES || all < LONG) {
            return false;
        }
        let [between, drawing] = [0, 1].map(|which| median(self.times.iter().map(|times| times[which])));
        let is_late = between > LATE * self.frame;
        self.is_late = is_late && self.is_least();
        if is_late {
            self.lower(between)
        } else if drawing < SPARE * self.frame && self.since_change >= self.patience {
            self.raise(drawing)
        } else {
            false
        }
    }

    fn has_settled(&self) -> bool {
        self.since_change > SETTLING || (self.since_change > FEW_SETTLING && self.seconds_since_change > LONG_SETTLING)
    }

    fn least(&self) -> f32 {
        LEAST.min(self.most)
    }

    /// Whether there is nothing left to lower.
    fn is_least(&self) -> bool {
        self.scale <= self.least() && lower(self.update).is_none()
    }

    /// Frames take that long: less is done.
    fn lower(&mut self, between: f32) -> bool {
        if self.scale > self.least() {
            let wanted = self.scale * (AIM * self.frame / between).sqrt().max(SHRINK);
            return self.change(stepped(wanted), self.update);
        }
        let is_far = between > MUCH_TOO_LATE * self.frame;
        let update = if is_far { UpdateRate::ALL.last().copied() } else { lower(self.update) };
        update.is_some_and(|update| self.change(self.scale, update))
    }

    /// Frames take so little: more is done.
    fn raise(&mut self, drawing: f32) -> bool {
        if let Some(update) = higher(self.update) {
            return self.change(self.scale, update);
        }
        let wanted = self.scale * (AIM * self.frame / drawing.max(1e-6)).sqrt().min(GROW);
        self.change(stepped(wanted), self.update)
    }

    fn change(&mut self, wanted: f32, update: UpdateRate) -> bool {
        let scale = wanted.clamp(self.least(), self.most);
        if scale == self.scale && update == self.update {
            return false;
        }
        let grows = scale > self.scale || update < self.update;
        if !grows && self.has_grown {
            self.patience = (2 * self.patience).min(MOST_PATIENCE * first_patience(1.0 / self.frame));
        }
        (self.scale, self.update, self.has_grown) = (scale, update, grows);
        (self.since_change, self.seconds_since_change) = (0, 0.0);
        self.times.clear();
        true
    }

    /// What it chose and why, for the window.
    pub fn status(&self) -> String {
        let rate = 1.0 / self.frame;
        let percent = 100.0 * self.scale;
        let light = match self.update.frames() {
            1 => String::new(),
            frames => format!(", light over {frames} frames"),
        };
        if self.is_late {
            format!("{rate:.0} frames/s are out of reach at {percent:.0} % of the size{light}")
        } else if self.scale < self.most {
            format!("{percent:.0} % of the size{light} for {rate:.0} frames/s")
        } else {
            format!("{rate:.0} frames/s at full size{light}")
        }
    }
}

/// The rate of the display that a window is on \[1/s\], if it tells.
pub fn display_rate(window: &winit::window::Window) -> Option<f32> {
    let rate = window.current_monitor()?.refresh_rate_millihertz()?;
    Some(1e-3 * rate as f32)
}

/// Down to a step of the scale.
fn stepped(scale: f32) -> f32 {
    (scale * STEPS).floor() / STEPS
}

fn lower(update: UpdateRate) -> Option<UpdateRate> {
    UpdateRate::ALL.into_iter().find(|other| *other > update)
}

fn higher(update: UpdateRate) -> Option<UpdateRate> {
    UpdateRate::ALL.into_iter().rfind(|other| *other < update)
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

    /// Draws frames that take `light` beside the rest where all light is brought up to date; how often something changed.
    fn draw_light(budget: &mut FrameBudget, frames: usize, [full, light, fixed]: [f32; 3]) -> usize {
        let mut changes = 0;
        for frame in 0..frames {
            let noise = 1.0 + 0.04 * ((frame * 7 % 5) as f32 - 2.0) / 2.0;
            let light = light / budget.update.frames() as f32;
            let drawing = (fixed + light + full * budget.scale * budget.scale) * noise;
            changes += usize::from(budget.note(drawing, drawing));
        }
        changes
    }

    #[test]
    fn below_the_least_size_light_is_brought_up_to_date_over_frames() {
        for (light, rate) in [(0.08, UpdateRate::Half), (0.15, UpdateRate::Quarter)] {
            let mut budget = FrameBudget::new(10.0, 1.0).expect("a rate");
            draw_light(&mut budget, 200, [0.4, light, 0.03]);
            assert_eq!((budget.scale, budget.update), (LEAST, rate), "{light}");
            assert!(!budget.is_late, "{light}: {}", budget.status());
            let changes = draw_light(&mut budget, 2000, [0.4, light, 0.03]);
            assert!(changes <= 12, "{light}: {changes} changes in 2000 frames");
            // What becomes fast goes back up: light first.
            draw_light(&mut budget, 4000, [0.02, 0.01, 0.01]);
            assert_eq!((budget.scale, budget.update), (1.0, UpdateRate::Whole), "{light}");
        }
        // Size first: where that is enough, light is whole.
        let mut budget = FrameBudget::new(10.0, 1.0).expect("a rate");
        draw_light(&mut budget, 200, [0.4, 0.03, 0.01]);
        assert!(budget.scale > LEAST && budget.update == UpdateRate::Whole, "{}", budget.status());
    }

    #[test]
    fn slow_frames_decide_sooner() {
        let mut budget = FrameBudget::choose(None, 1.0, None, true).expect("a rate");
        let mut seconds = 0.0;
        while !budget.is_least() {
            let drawing = 0.2 + 0.3 * budget.scale * budget.scale;
            seconds += drawing;
            assert!(seconds < 4.0, "{}", budget.status());
            budget.note(drawing, drawing);
        }
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
