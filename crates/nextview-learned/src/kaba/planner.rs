use super::{BOUNDARY_WEIGHTS, Policy, Surveyor};
use nextview::Error;
use nextview::planner::{Plan, Situation, ViewPlanner};

/// Takes the view with the largest gain minus a weight times the boundary it leaves; a learned policy chooses
/// the weight before each view.
#[derive(Clone, Debug)]
pub struct Kaba {
    surveyor: Surveyor,
    rule: Rule,
}

#[derive(Clone, Debug)]
enum Rule {
    Learned(Policy),
    Fixed(f64),
}

impl Kaba {
    /// Creates a planner with the library's policy. `ray_spacing` is the distance between rays at the far
    /// side of the box, in voxels of the finest size, at least 0.1.
    pub fn new(ray_spacing: f64) -> Result<Self, Error> {
        Self::with_policy(ray_spacing, Policy::default())
    }

    /// Creates a planner with a custom policy.
    pub fn with_policy(ray_spacing: f64, policy: Policy) -> Result<Self, Error> {
        Ok(Self { surveyor: Surveyor::new(ray_spacing)?, rule: Rule::Learned(policy) })
    }

    /// Creates a planner with a fixed weight, at least 0; with 0, it is greedy.
    pub fn with_boundary_weight(ray_spacing: f64, boundary_weight: f64) -> Result<Self, Error> {
        if !(boundary_weight >= 0.0 && boundary_weight.is_finite()) {
            return Err(Error::InvalidParameter {
                name: "boundary_weight",
                value: boundary_weight.to_string(),
                expected: "a finite number, at least 0",
            });
        }
        Ok(Self { surveyor: Surveyor::new(ray_spacing)?, rule: Rule::Fixed(boundary_weight) })
    }
}

impl ViewPlanner for Kaba {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let survey = self.surveyor.survey(situation)?;
        let choice = survey.and_then(|survey| {
            survey.choice(match &self.rule {
                Rule::Learned(policy) => BOUNDARY_WEIGHTS[policy.choice(survey.features())],
                Rule::Fixed(weight) => *weight,
            })
        });
        Ok(Plan { choice, ..Plan::default() })
    }
}
