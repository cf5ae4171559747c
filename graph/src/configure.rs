//! From the class of an input to a configuration.

use crate::configuration::Configuration;
use crate::description::{ClassDefault, Description, Setting, Table};
use crate::error::Errors;
use crate::scope::{Env, Evaluation};

impl Description {
    /// What an input with these facts is rendered with: the defaults of its class, changed by a preset, changed by `set`.
    ///
    /// # Errors
    ///
    /// An unknown preset, or a rule whose condition is invalid. [`Self::evaluate`] checks whether the result is legal.
    pub fn configure(
        &self,
        facts: &Table<bool>,
        preset: Option<&str>,
        set: &Table<Setting>,
    ) -> Result<Configuration, Errors> {
        let mut configuration = Configuration { facts: facts.clone(), ..Configuration::default() };
        let of = Evaluation::new(self, &configuration);
        let env = Env::new(&of, &[]);
        let by_hand = |rule: &ClassDefault| rule.unless.iter().any(|name| set.contains_key(name));
        let rules = self.default.iter().filter(|rule| env.holds(&rule.when) && !by_hand(rule));
        let mut made: Table<_> = rules.flat_map(|rule| rule.set.clone()).collect();
        let named = preset.and_then(|name| env.entry(&self.preset, "preset", name));
        made.extend(named.into_iter().flat_map(|preset| preset.set.clone()));
        made.extend(set.clone());
        of.finish()?;
        for (name, setting) in made {
            match setting {
                Setting::Number(number) if !self.axes.contains_key(&name) => {
                    configuration.parameters.insert(name, number);
                }
                setting => drop(configuration.axes.insert(name, setting.to_string())),
            }
        }
        Ok(configuration)
    }
}
