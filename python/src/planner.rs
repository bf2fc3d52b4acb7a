//! Planners and gains written in Python.

use crate::errors::PlannerFailure;
use crate::plan_input::{self, Grid};
use crate::planner_class::Class;
use crate::shown::{shown, type_of};
use nextview::Error;
use nextview::planner::{Choice, GreedyByView, GreedyConfig, Plan, Situation, ViewGain, ViewPlanner};
use nextview::visibility::{Sight, ViewRays};
use nextview_scan::{Fault, PlannerProvider, ProvidedPlanner, provide_planners};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyTuple};
use std::cell::Cell;

thread_local! {
    static IS_CALLED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is in a method of a planner.
pub fn is_called() -> bool {
    IS_CALLED.get()
}

/// Registers this interpreter as the provider of planners.
pub fn provide() {
    provide_planners(Box::new(Classes));
}

struct Classes;

impl PlannerProvider for Classes {
    fn check(&self, planner: &ProvidedPlanner) -> Result<(), Fault> {
        Python::attach(|py| Class::find(py, planner).map(drop)).map_err(|failure| fault(planner, failure))
    }

    fn build(
        &self,
        planner: &ProvidedPlanner,
        config: GreedyConfig,
        seed: u64,
    ) -> Result<Box<dyn ViewPlanner>, Fault> {
        let built = Python::attach(|py| {
            let Class { class, name, sight } = Class::find(py, planner)?;
            let raised = |error| PlannerFailure::raised(py, &format!("{name}()"), error);
            let instance = class.call0().map_err(raised)?.unbind();
            Ok((Instance { instance, name, seed }, sight))
        });
        let (instance, sight) = built.map_err(|failure| fault(planner, failure))?;
        Ok(match sight {
            None => Box::new(instance),
            Some(sight) => Box::new(GreedyByView::new(config, Gain { instance, sight, begun: None })?),
        })
    }
}

fn fault(planner: &ProvidedPlanner, failure: PlannerFailure) -> Fault {
    let fault = Fault::request(format!("the planner {planner}: {failure}")).with_cause(failure);
    fault.with_remedy(
        "it must be a class in an importable module, created without arguments: a subclass of \
         nextview.Planner or nextview.Gain",
    )
}

/// An object for a single scan.
struct Instance {
    instance: Py<PyAny>,
    name: String,
    seed: u64,
}

impl Instance {
    fn call<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        args: impl pyo3::call::PyCallArgs<'py>,
    ) -> Result<Bound<'py, PyAny>, PlannerFailure> {
        let was_called = IS_CALLED.replace(true);
        let result = self.instance.bind(py).call_method1(method, args);
        IS_CALLED.set(was_called);
        result.map_err(|error| PlannerFailure::raised(py, &format!("{}.{method}", self.name), error))
    }

    fn situation<'py>(
        &self,
        py: Python<'py>,
        situation: &Situation<'_>,
    ) -> Result<Bound<'py, PyAny>, PlannerFailure> {
        let made = plan_input::situation(py, situation, self.seed);
        made.map_err(|error| PlannerFailure::raised(py, "the situation", error))
    }

    fn wrong(&self, method: &str, answer: &Bound<'_, PyAny>, expected: &str) -> PlannerFailure {
        let (shown, kind) = (shown(answer), type_of(answer));
        PlannerFailure::new(format!(
            "{}.{method} returned {shown}, of type {kind}, expected {expected}",
            self.name
        ))
    }

    /// The view in the answer; `None` if no view gains anything.
    fn choice(
        &self,
        answer: &Bound<'_, PyAny>,
        situation: &Situation<'_>,
    ) -> Result<Option<Choice>, PlannerFailure> {
        if answer.is_none() {
            return Ok(None);
        }
        let wrong =
            || self.wrong("plan", answer, "a number of `situation.open_views`, (number, score) or None");
        let (view, score) = match answer.cast::<PyTuple>() {
            Ok(pair) if pair.len() == 2 => {
                let score = pair.get_item(1).and_then(|score| score.extract::<f64>());
                let score = score.ok().filter(|score| score.is_finite()).ok_or_else(wrong)?;
                (pair.get_item(0).map_err(|_| wrong())?, score)
            }
            Ok(_) => return Err(wrong()),
            Err(_) => (answer.clone(), 0.0),
        };
        if view.is_instance_of::<PyBool>() {
            return Err(wrong());
        }
        let view: usize = view.extract().map_err(|_| wrong())?;
        if situation.open_views().binary_search(&view).is_ok() {
            return Ok(Some(Choice::new(view, score)));
        }
        let problem = match view {
            view if view >= situation.views().len() => "there are fewer candidates",
            view if situation.visited().contains(&view) => "it was already taken",
            _ => "it is out of reach",
        };
        let expected = "expected one of `situation.open_views`";
        Err(PlannerFailure::new(format!(
            "{}.plan returned view {view}, but {problem}; {expected}",
            self.name
        )))
    }
}

impl ViewPlanner for Instance {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let choice = Python::attach(|py| {
            let answer = self.call(py, "plan", (self.situation(py, situation)?,))?;
            self.choice(&answer, situation)
        })?;
        situation.cancel().check()?;
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// A gain, and the data shared by its calls for one plan.
struct Gain {
    instance: Instance,
    sight: Sight,
    begun: Option<(Py<PyAny>, Grid)>,
}

impl ViewGain for Gain {
    fn sight(&self) -> Sight {
        self.sight
    }

    fn begin(&mut self, situation: &Situation<'_>) -> Result<(), Error> {
        Python::attach(|py| {
            let given = self.instance.situation(py, situation)?;
            self.instance.call(py, "begin", (&given,))?;
            self.begun = Some((given.unbind(), Grid::of(situation.snapshot())));
            Ok(())
        })
    }

    fn gain(&mut self, _: &Situation<'_>, view: usize, rays: &ViewRays) -> Result<f64, Error> {
        let (situation, grid) = self.begun.as_ref().expect("every plan begins");
        Python::attach(|py| {
            let rays = plan_input::rays(py, view, rays, grid);
            let rays = rays.map_err(|error| PlannerFailure::raised(py, "the rays", error))?;
            let answer = self.instance.call(py, "gain", (situation, rays))?;
            match answer.extract::<f64>() {
                Ok(gain) if gain >= 0.0 && gain.is_finite() => Ok(gain),
                _ => {
                    let expected = format!("a finite number, at least 0, for view {view}");
                    Err(self.instance.wrong("gain", &answer, &expected).into())
                }
            }
        })
    }
}
