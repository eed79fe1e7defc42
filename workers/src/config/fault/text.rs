//! Faults as text.

use std::fmt;
use std::str::FromStr;

use septet_geometry::separator::Ablation;
use septet_protocol::ids::{Group, NodeId, Phase};
use septet_protocol::message::kinds::KINDS;
use thiserror::Error;

use super::Fault;
use super::factor::Factor;
use super::flip::Flip;
use super::forms::{FAULTS, FaultForm};
use super::law::Law;

/// A text that is not the text of a fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FaultTextError {
    /// No fault has this name.
    #[error("there is no fault `{name}`; the faults are {}", names(&self.choices()))]
    Name {
        /// The unknown name.
        name: String,
    },
    /// The parameters do not fit the fault.
    #[error("fault `{text}` does not have the form `{form}`")]
    Form {
        /// The text.
        text: String,
        /// The form of faults with this name.
        form: &'static str,
    },
    /// No phase has this name, or the fault does not act on it.
    #[error("fault `{fault}` has no phase `{name}`; its phases are {}", names(&self.choices()))]
    Phase {
        /// The name of the fault.
        fault: &'static str,
        /// The text that should be a phase.
        name: String,
    },
    /// No kind of messages has this name.
    #[error("there is no kind of messages `{name}`; the kinds are {}", names(&self.choices()))]
    Kind {
        /// The unknown name.
        name: String,
    },
    /// No law has this name.
    #[error("there is no law `{name}`; the laws are {}", names(&self.choices()))]
    Law {
        /// The unknown name.
        name: String,
    },
    /// The factor is not a number within the range of the fault.
    #[error("the factor of fault `{fault}` is `{number}`: it must be {needed}")]
    Factor {
        /// The name of the fault.
        fault: &'static str,
        /// The text that should be a factor.
        number: String,
        /// The range.
        needed: &'static str,
    },
}

fn names(all: &[&str]) -> String {
    all.join(" ")
}

impl FaultTextError {
    /// Returns the unknown name, or an empty string if all names are known.
    pub fn unknown(&self) -> &str {
        match self {
            FaultTextError::Name { name }
            | FaultTextError::Phase { name, .. }
            | FaultTextError::Kind { name }
            | FaultTextError::Law { name } => name,
            FaultTextError::Form { .. } | FaultTextError::Factor { .. } => "",
        }
    }

    /// Returns the known names that could replace the unknown one.
    pub fn choices(&self) -> Vec<&'static str> {
        match self {
            FaultTextError::Name { .. } => FAULTS.iter().map(FaultForm::name).collect(),
            FaultTextError::Phase { fault, .. } => {
                Phase::ALL.into_iter().filter(|&phase| acts(fault, phase)).map(Phase::name).collect()
            }
            FaultTextError::Kind { .. } => KINDS.to_vec(),
            FaultTextError::Law { .. } => Law::ALL.into_iter().map(Law::name).collect(),
            FaultTextError::Form { .. } | FaultTextError::Factor { .. } => Vec::new(),
        }
    }
}

/// Returns `true` if the fault with this name acts on the phase. Faults of charges act on the phases of the paper and on the
/// choice.
fn acts(fault: &str, phase: Phase) -> bool {
    matches!(fault, "die" | "panic") || matches!(phase.group(), Group::Paper | Group::Selection)
}

/// The parameters of a fault with a known form.
struct Parameters<'a> {
    text: &'a str,
    form: &'static FaultForm,
    words: Vec<&'a str>,
}

impl Parameters<'_> {
    /// Returns the error for parameters of the wrong number or type.
    fn misfit(&self) -> FaultTextError {
        FaultTextError::Form { text: self.text.to_string(), form: self.form.text }
    }

    /// Returns the parameter with this index as a number.
    fn number<T: FromStr>(&self, at: usize) -> Result<T, FaultTextError> {
        self.words.get(at).and_then(|word| word.parse().ok()).ok_or_else(|| self.misfit())
    }

    fn phase(&self, at: usize) -> Result<Phase, FaultTextError> {
        let (fault, name) = (self.form.name(), self.words[at]);
        let mut all = Phase::ALL.into_iter().filter(|&phase| acts(fault, phase));
        all.find(|phase| phase.name() == name)
            .ok_or_else(|| FaultTextError::Phase { fault, name: name.to_string() })
    }

    fn law(&self, at: usize) -> Result<Law, FaultTextError> {
        let name = self.words[at];
        let law = Law::ALL.into_iter().find(|law| law.name() == name);
        law.ok_or_else(|| FaultTextError::Law { name: name.to_string() })
    }

    /// Returns the parameter with this index as a factor of at least `least`.
    fn factor(&self, at: usize, least: f64) -> Result<Factor, FaultTextError> {
        let number = self.words[at];
        let needed = if least > 0.0 { "at least 1 and at most 1e6" } else { "positive and at most 1e6" };
        number.parse().ok().filter(|factor: &Factor| factor.value() >= least).ok_or_else(|| {
            FaultTextError::Factor { fault: self.form.name(), number: number.to_string(), needed }
        })
    }

    fn flip(&self) -> Result<Fault, FaultTextError> {
        let (name, seed) = (self.words[0], self.number(1)?);
        let unknown = || FaultTextError::Kind { name: name.to_string() };
        Flip::new(name, seed).map(Fault::Flip).ok_or_else(unknown)
    }

    fn nodes(&self) -> Result<Fault, FaultTextError> {
        let (first, last) = self.words[0].split_once('-').unwrap_or((self.words[0], self.words[0]));
        let node = |text: &str| text.parse().map(NodeId).map_err(|_| self.misfit());
        Ok(Fault::RefuseSplit { first: node(first)?, last: node(last)? })
    }

    fn every(&self) -> Result<Fault, FaultTextError> {
        let every: u32 = self.number(0)?;
        if every == 0 { Err(self.misfit()) } else { Ok(Fault::RefuseDraws { every }) }
    }

    fn fault(&self) -> Result<Fault, FaultTextError> {
        Ok(match (self.form.name(), self.words.len()) {
            ("slow", 2) => Fault::Slow { phase: self.phase(0)?, law: self.law(1)?, factor: Factor::ONE },
            ("slow", 3) => {
                Fault::Slow { phase: self.phase(0)?, law: self.law(1)?, factor: self.factor(2, 0.0)? }
            }
            ("work", 2) => Fault::Work { phase: self.phase(0)?, factor: self.factor(1, 0.0)? },
            ("free", 1) => Fault::Free { phase: self.phase(0)? },
            ("far-ghosts", 1) => Fault::FarGhosts { factor: self.factor(0, 1.0)? },
            ("refuse", 1) => self.nodes()?,
            ("refuse-draws", 1) => self.every()?,
            ("spoil", 1) => Fault::SpoilStar { rank: self.number(0)? },
            ("die", 2) => Fault::DieAt { rank: self.number(0)?, phase: self.phase(1)? },
            ("flip", 2) => self.flip()?,
            ("panic", 2) => Fault::PanicAt { rank: self.number(0)?, phase: self.phase(1)? },
            (name, 0) => plain(name).ok_or_else(|| self.misfit())?,
            _ => return Err(self.misfit()),
        })
    }
}

/// Returns the fault without parameters that has this name.
fn plain(name: &str) -> Option<Fault> {
    Some(match name {
        "flood" => Fault::Flood,
        "half-ghosts" => Fault::HalfGhosts,
        "half-separators" => Fault::HalfSeparators,
        "halve-alpha" => Fault::HalveAlpha,
        "blind-probes" => Fault::BlindProbes,
        "first-ball" => Fault::FirstBall,
        "worst-choice" => Fault::WorstChoice,
        "always-punt" => Fault::AlwaysPunt,
        "slow-hub" => Fault::SlowHub,
        "old-spheres" => Fault::OldSpheres,
        "small-sphere" => Fault::SmallSphere,
        "sequential-leaf" => Fault::SequentialLeaf,
        "free-loop" => Fault::FreeLoop,
        "one-clock" => Fault::OneClock,
        _ => Fault::Ablate(Ablation::ALL.into_iter().find(|ablation| ablation.name() == name)?),
    })
}

impl FromStr for Fault {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let mut words = text.split(':');
        let name = words.next().unwrap_or_default();
        let form = FaultForm::of(name).ok_or_else(|| FaultTextError::Name { name: name.to_string() })?;
        Parameters { text, form, words: words.collect() }.fault()
    }
}

impl TryFrom<String> for Fault {
    type Error = FaultTextError;

    fn try_from(text: String) -> Result<Self, FaultTextError> {
        text.parse()
    }
}

impl From<Fault> for String {
    fn from(fault: Fault) -> String {
        fault.to_string()
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::RefuseSplit { first, last } => write!(f, "refuse:{}-{}", first.0, last.0),
            Fault::RefuseDraws { every } => write!(f, "refuse-draws:{every}"),
            Fault::SpoilStar { rank } => write!(f, "spoil:{rank}"),
            Fault::DieAt { rank, phase } => write!(f, "die:{rank}:{}", phase.name()),
            Fault::PanicAt { rank, phase } => write!(f, "panic:{rank}:{}", phase.name()),
            Fault::Flip(flip) => write!(f, "flip:{}:{}", flip.kind(), flip.seed()),
            Fault::Flood => f.write_str("flood"),
            Fault::FarGhosts { factor } => write!(f, "far-ghosts:{factor}"),
            Fault::HalfGhosts => f.write_str("half-ghosts"),
            Fault::HalfSeparators => f.write_str("half-separators"),
            Fault::HalveAlpha => f.write_str("halve-alpha"),
            Fault::BlindProbes => f.write_str("blind-probes"),
            Fault::FirstBall => f.write_str("first-ball"),
            Fault::WorstChoice => f.write_str("worst-choice"),
            Fault::AlwaysPunt => f.write_str("always-punt"),
            Fault::SlowHub => f.write_str("slow-hub"),
            Fault::OldSpheres => f.write_str("old-spheres"),
            Fault::SmallSphere => f.write_str("small-sphere"),
            Fault::Ablate(ablation) => f.write_str(ablation.name()),
            Fault::Slow { phase, law, factor } => {
                write!(f, "slow:{}:{}:{factor}", phase.name(), law.name())
            }
            Fault::Work { phase, factor } => write!(f, "work:{}:{factor}", phase.name()),
            Fault::Free { phase } => write!(f, "free:{}", phase.name()),
            Fault::SequentialLeaf => f.write_str("sequential-leaf"),
            Fault::FreeLoop => f.write_str("free-loop"),
            Fault::OneClock => f.write_str("one-clock"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texts of all forms.
    const TEXTS: [&str; 31] = [
        "slow:partition:log2:3",
        "slow:separator-sets:root3:0.1",
        "slow:hulls:log:1",
        "work:graph:0.5",
        "free:merge",
        "sequential-leaf",
        "free-loop",
        "one-clock",
        "flood",
        "far-ghosts:3",
        "half-ghosts",
        "half-separators",
        "halve-alpha",
        "blind-probes",
        "first-ball",
        "worst-choice",
        "always-punt",
        "slow-hub",
        "old-spheres",
        "small-sphere",
        "random-planes",
        "median-planes",
        "no-centrepoint",
        "no-map",
        "no-scoring",
        "refuse:2-3",
        "refuse-draws:3",
        "spoil:1",
        "die:2:hulls",
        "panic:1:load",
        "flip:sample-stars:7",
    ];

    #[test]
    fn faults_survive_the_text() {
        for text in TEXTS {
            let fault: Fault = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(fault.to_string(), text);
            let line = serde_json::to_string(&fault).unwrap();
            assert_eq!(serde_json::from_str::<Fault>(&line).unwrap(), fault, "{line}");
        }
        assert_eq!("refuse:5".parse::<Fault>().unwrap().to_string(), "refuse:5-5");
        assert_eq!("slow:graph:log".parse::<Fault>().unwrap().to_string(), "slow:graph:log:1");
        assert_eq!("work:graph:3e-1".parse::<Fault>().unwrap().to_string(), "work:graph:0.3");
    }

    #[test]
    fn every_form_has_a_text() {
        for form in FAULTS {
            let has_name = |text: &&str| text.split(':').next() == Some(form.name());
            assert!(TEXTS.iter().any(has_name), "{}", form.text);
            assert!(form.effect.ends_with('.') && !form.effect.contains('\n'), "{}", form.effect);
        }
    }

    #[test]
    fn the_text_of_flips_names_every_kind() {
        let flip = FAULTS.iter().find(|form| form.name() == "flip").unwrap();
        let named = flip.effect.split_once("KIND is ").unwrap().1.trim_end_matches('.').replace(" or ", ", ");
        assert!(named.split(", ").eq(KINDS), "{named}");
    }

    #[test]
    fn errors_name_the_part_that_is_wrong() {
        let error = |text: &str| text.parse::<Fault>().expect_err(text);
        for text in ["", "sleep:3", "floods", "Flood"] {
            assert!(matches!(error(text), FaultTextError::Name { .. }), "{text}");
            assert!(error(text).to_string().contains(" free-loop one-clock flood "), "{text}");
        }
        for text in [
            "refuse",
            "refuse:x",
            "refuse:1-",
            "refuse-draws:0",
            "spoil:-1",
            "die:2",
            "flood:2",
            "slow:hulls",
            "free",
            "free:hulls:1",
            "far-ghosts",
            "flip:move",
            "flip:move:x",
            "slow:hulls:log:1:1",
        ] {
            assert!(matches!(error(text), FaultTextError::Form { .. }), "{text}");
        }
        for text in ["die:2:lunch", "free:repair", "work:load:2", "slow:halo:log"] {
            assert!(matches!(error(text), FaultTextError::Phase { .. }), "{text}");
        }
        assert!(error("free:huls").choices().contains(&"hulls"));
        assert!(!error("free:huls").choices().contains(&"repair"));
        assert!(error("die:1:huls").choices().contains(&"repair"));
        assert_eq!(error("slow:hulls:lg").choices(), ["log", "log2", "root3"]);
        assert!(error("flip:mov:1").choices().contains(&"move"));
        for text in [
            "work:hulls:0",
            "work:hulls:-1",
            "work:hulls:inf",
            "work:hulls:1e7",
            "far-ghosts:0.5",
            "slow:hulls:log:x",
        ] {
            assert!(matches!(error(text), FaultTextError::Factor { .. }), "{text}");
        }
        assert_eq!(
            error("far-ghosts:0.5").to_string(),
            "the factor of fault `far-ghosts` is `0.5`: it must be at least 1 and at most 1e6"
        );
    }
}
