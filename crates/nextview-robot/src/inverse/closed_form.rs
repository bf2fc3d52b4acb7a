use super::axis::SixAxes;
use super::free::Free;
use super::parallel_axes::ParallelAxes;
use super::wrist::Wrist;
use nextview::geometry::Pose;

enum Form {
    Wrist(Wrist),
    ParallelAxes(ParallelAxes),
}

/// A closed-form solution for six turning axes.
pub(super) struct ClosedForm {
    form: Form,
    /// Whether the form solves the arm in reverse, from the flange to the base.
    is_reversed: bool,
    flange_from_base: Pose,
}

impl ClosedForm {
    /// Returns the form that fits the axes, if any.
    pub fn of(arm: &SixAxes) -> Option<Self> {
        let flange_from_base = arm.base_from_flange.inverse();
        let mut backward = arm.axes.map(|axis| axis.reversed());
        backward.reverse();
        [(false, &arm.axes), (true, &backward)].into_iter().find_map(|(is_reversed, axes)| {
            let wrist = Wrist::of(axes).map(Form::Wrist);
            let form = wrist.or_else(|| ParallelAxes::of(axes).map(Form::ParallelAxes))?;
            Some(Self { form, is_reversed, flange_from_base })
        })
    }

    /// Returns all candidate angles, up to full turns, that bring the flange to a pose, and some that nearly
    /// do.
    pub fn solve(&self, base_from_flange: &Pose, near: Option<[f64; 6]>) -> Vec<[f64; 6]> {
        let motion = *base_from_flange * self.flange_from_base;
        let free = Free::new(near);
        if !self.is_reversed {
            return self.form.solve(&motion, &free);
        }
        let mut solutions = self.form.solve(&motion.inverse(), &free.reversed());
        solutions.iter_mut().for_each(|angles| angles.reverse());
        solutions
    }
}

impl Form {
    fn solve(&self, motion: &Pose, free: &Free) -> Vec<[f64; 6]> {
        match self {
            Self::Wrist(form) => form.solve(motion, free),
            Self::ParallelAxes(form) => form.solve(motion, free),
        }
    }
}
