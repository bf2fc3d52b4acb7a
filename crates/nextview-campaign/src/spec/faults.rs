use nextview_scan::{Fault, Faults, Positions};

/// The distinct faults of a specification.
#[derive(Debug, Default)]
pub(crate) struct FaultList(Vec<Fault>);

impl FaultList {
    /// Adds a fault about this key of the specification, once: a fault in `scan` recurs in every variant.
    pub fn add(&mut self, key: &str, fault: Fault) {
        self.add_without_key(Fault { key: Some(key.to_owned()), ..without_place(fault) });
    }

    /// Adds a fault without a key of the specification.
    pub fn add_without_key(&mut self, fault: Fault) {
        if !self.0.contains(&fault) {
            self.0.push(fault);
        }
    }

    /// Adds the fault of a result, if any.
    pub fn check(&mut self, key: &str, result: Result<(), Fault>) {
        if let Err(fault) = result {
            self.add(key, fault);
        }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value if there are no faults.
    pub fn or<T>(self, value: T) -> Result<T, Faults> {
        Faults::of(self.0).map_or(Ok(value), Err)
    }

    /// Adds the places of the faults, in the order of the lines.
    pub fn placed(mut self, positions: &Positions) -> Self {
        let mut faults: Vec<Fault> = self.0.into_iter().map(|fault| positions.place(fault, "")).collect();
        faults.sort_by_key(|fault| fault.place.as_ref().and_then(|place| place.position));
        self.0 = faults;
        self
    }
}

/// Moves the fault's file into its message: its place must become that of the key.
pub(super) fn without_place(fault: Fault) -> Fault {
    Fault { message: fault.to_string(), place: None, ..fault }
}
