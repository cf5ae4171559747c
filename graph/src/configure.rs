//! From the class of an input to a configuration.

use crate::configuration::Configuration;
use crate::description::{Description, Setting, Table};
use crate::error::Errors;
use crate::scope::{Env, Evaluation};

impl Description {
    /// What an input with these facts is rendered with: the defaults of its class, changed by a preset, changed by `set`.
    /// A rule sees the axes as `set`, the preset and the rules before it leave them.
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
        let named = preset.and_then(|name| env.entry(&self.preset, "preset", name));
        let mut later = named.map(|preset| preset.set.clone()).unwrap_or_default();
        later.extend(set.clone());
        let mut made = Table::new();
        for rule in &self.default {
            let axes = made.iter().chain(&later).map(|(name, of)| (name.clone(), of.to_string()));
            let axes = axes.collect();
            let holds = Env { axes: Some(&axes), ..env.clone() }.holds(&rule.when);
            if holds && !rule.unless.iter().any(|name| set.contains_key(name)) {
                made.extend(rule.set.clone());
            }
        }
        made.extend(later);
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
