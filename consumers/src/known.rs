//! Modules that a consumer refuses by its own fault, each with what it says: they are counted by themselves, and one that it
//! takes by now is reported.

use crate::tint::Verdict;

/// What a consumer refuses although it is valid.
struct Known {
    consumer: &'static str,
    pass: &'static str,
    /// A value that its identifier has.
    value: &'static str,
    /// A part of the message.
    message: &'static str,
    why: &'static str,
}

const KNOWN: [Known; 1] = [Known {
    consumer: "tint-spirv",
    pass: "shade",
    value: "tile",
    message: "'workgroupBarrier' must only be called from uniform control flow",
    why: "in SPIR-V Tint does not take what workgroupUniformLoad gives for uniform (docs/platform.md)",
}];

/// How many of a consumer's verdicts are known refusals, how many it should have refused and takes, and why.
pub(crate) struct Counted {
    /// Refused as known.
    pub(crate) refused: usize,
    /// Taken by now.
    pub(crate) taken: usize,
    /// Why they are refused.
    pub(crate) why: Vec<&'static str>,
}

/// Counts the known refusals of a consumer.
pub(crate) fn counted(consumer: &str, verdicts: &[&Verdict]) -> Counted {
    let mut counted = Counted { refused: 0, taken: 0, why: Vec::new() };
    for known in KNOWN.iter().filter(|known| known.consumer == consumer) {
        let of_known = verdicts.iter().filter(|verdict| known.is_about(verdict));
        let (refused, taken) = of_known.fold((0, 0), |(refused, taken), verdict| {
            (
                refused + usize::from(known.refuses(verdict)),
                taken + usize::from(verdict.state == "valid"),
            )
        });
        counted.refused += refused;
        counted.taken += taken;
        if refused + taken > 0 {
            counted.why.push(known.why);
        }
    }
    counted
}

/// Whether a refusal is known.
pub(crate) fn is_known(consumer: &str, verdict: &Verdict) -> bool {
    KNOWN.iter().any(|known| {
        known.consumer == consumer && known.is_about(verdict) && known.refuses(verdict)
    })
}

impl Known {
    fn is_about(&self, verdict: &Verdict) -> bool {
        let mut words = verdict.name.split('-');
        words.next() == Some(self.pass) && words.any(|word| word == self.value)
    }

    fn refuses(&self, verdict: &Verdict) -> bool {
        let said = |message: &String| message.contains(self.message);
        verdict.state == "invalid" && verdict.messages.iter().any(said)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(name: &str, state: &str, message: &str) -> Verdict {
        Verdict {
            name: name.to_owned(),
            state: state.to_owned(),
            pipelines: 0,
            messages: vec![message.to_owned()],
        }
    }

    #[test]
    fn a_refusal_is_known_by_its_module_and_its_message() {
        let message = format!("error: {}, 4>", KNOWN[0].message);
        let all = [
            verdict("shade-disc-tile", "invalid", &message),
            verdict("shade-disc-tile", "invalid", "another error"),
            verdict("shade-disc", "invalid", &message),
            verdict("cut_lights-tile", "invalid", &message),
            verdict("shade-lobe-tile", "valid", ""),
        ];
        let known: Vec<bool> = all.iter().map(|one| is_known("tint-spirv", one)).collect();
        assert_eq!(known, [true, false, false, false, false]);
        assert!(!is_known("tint", &all[0]));
        let counted = counted("tint-spirv", &all.each_ref());
        assert_eq!((counted.refused, counted.taken, counted.why.len()), (1, 1, 1));
    }
}
