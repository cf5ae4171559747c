//! What configurations have in common on the device, made once and when it is needed.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use sglow_runtime::indirect::Indirect;
use sglow_runtime::settings::Settings;

use super::bench::{RUNS, Runs, Timed};
use super::configuration;
use super::subject::{FrontierError, Subject};
use crate::cache::{Cache, Key};

/// The shadow maps and the reflection of lights.
pub(super) struct Shared<'a, 's> {
    pub(super) subject: &'a Subject<'s>,
    shadings: RefCell<BTreeMap<String, Rc<Indirect>>>,
    visibilities: RefCell<BTreeMap<String, Rc<Indirect>>>,
}

impl<'a, 's> Shared<'a, 's> {
    pub(super) fn new(subject: &'a Subject<'s>) -> Self {
        Self { subject, shadings: RefCell::default(), visibilities: RefCell::default() }
    }

    pub(super) fn shading(&self, settings: &Settings) -> Result<Rc<Indirect>, FrontierError> {
        let id = self.subject.depends.shading_id(settings);
        if let Some(made) = self.shadings.borrow().get(&id) {
            return Ok(made.clone());
        }
        let made = Rc::new(self.subject.shading(settings)?);
        self.shadings.borrow_mut().insert(id, made.clone());
        Ok(made)
    }

    pub(super) fn visibility(
        &self,
        settings: &Settings,
    ) -> Result<Option<Rc<Indirect>>, FrontierError> {
        let id = self.subject.depends.visibility_id(settings);
        if let Some(made) = self.visibilities.borrow().get(&id) {
            return Ok(Some(made.clone()));
        }
        let made = self.subject.visibility(settings)?.map(Rc::new);
        if let Some(made) = &made {
            self.visibilities.borrow_mut().insert(id, made.clone());
        }
        Ok(made)
    }
}

/// Makes something and times it in so many runs.
type Make<'a> = dyn Fn(usize) -> Result<(Indirect, Runs), FrontierError> + 'a;

/// A stage that lights are made by: its time, which may come from the cache, and its result, which is made on demand.
pub(super) struct Step<'a> {
    pub(super) timed: Timed,
    made: OnceCell<Indirect>,
    make: Box<Make<'a>>,
}

impl<'a> Step<'a> {
    /// A step that `make` makes and times; nothing is made if its time is kept.
    fn new(
        cache: &Cache,
        key: &Key,
        make: impl Fn(usize) -> Result<(Indirect, Runs), FrontierError> + 'a,
    ) -> Result<Self, FrontierError> {
        let made = OnceCell::new();
        let timed = cache.get(key, || {
            let (indirect, runs) = make(RUNS)?;
            let _ = made.set(indirect);
            Ok::<_, FrontierError>(Timed::of(&runs))
        })?;
        Ok(Self { timed, made, make: Box::new(make) })
    }

    fn get(&self) -> Result<&Indirect, FrontierError> {
        if let Some(made) = self.made.get() {
            return Ok(made);
        }
        let (made, _) = (self.make)(0)?;
        Ok(self.made.get_or_init(|| made))
    }

    /// Level 0 of moments and density, as a configuration has them.
    pub(super) fn maps(
        subject: &'a Subject<'_>,
        configuration: &Settings,
        cache: &Cache,
    ) -> Result<Self, FrontierError> {
        let settings = subject.depends.of_maps(configuration);
        let key = key(subject, "maps", &settings)?;
        Self::new(cache, &key, move |runs| subject.maps(&settings, runs))
    }
}

/// Lights, and by what they are shadowed.
pub(super) struct Lights<'a> {
    pub(super) step: Step<'a>,
    /// By what they are shadowed now, as the subject's [`super::depends::Depends::visibility_id`] has it.
    shadowed: RefCell<Option<String>>,
}

impl<'a> Lights<'a> {
    /// The lights that a configuration makes of maps.
    pub(super) fn new(
        subject: &'a Subject<'_>,
        configuration: &Settings,
        maps: &'a Step<'_>,
        cache: &Cache,
    ) -> Result<Self, FrontierError> {
        let settings = subject.depends.of_lights(configuration);
        let key = key(subject, "lights", &settings)?;
        let make = move |runs| subject.lights(&settings, maps.get()?, runs);
        Ok(Self { step: Step::new(cache, &key, make)?, shadowed: RefCell::new(None) })
    }

    /// The lights, after their shadow maps were drawn by `visibility` with the settings of a configuration.
    pub(super) fn shadowed(
        &self,
        subject: &Subject<'_>,
        visibility: Option<&Indirect>,
        configuration: &Settings,
    ) -> Result<&Indirect, FrontierError> {
        let lights = self.step.get()?;
        let id = subject.depends.visibility_id(configuration);
        if let Some(visibility) = visibility
            && self.shadowed.borrow().as_ref() != Some(&id)
        {
            subject.shadow(visibility, lights)?;
            *self.shadowed.borrow_mut() = Some(id);
        }
        Ok(lights)
    }
}

fn key(subject: &Subject<'_>, what: &str, settings: &Settings) -> Result<Key, FrontierError> {
    subject.key_of_lights(what, &configuration::name(settings, &subject.base), settings)
}
