//! Values of options: their words, their text on a command line, and their form in a report.

use serde::{Deserialize, Serialize};

/// The value of an option in a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// The option is not given, and has no default.
    None,
    /// A flag.
    Flag(bool),
    /// A whole number.
    Number(u64),
    /// A number.
    Real(f64),
    /// A word, or a number that may be `auto`.
    Text(String),
    /// Several words.
    List(Vec<String>),
}

impl Setting {
    /// Returns the value as it is given on a command line. Returns `None` for an option that is not given.
    pub fn text(&self) -> Option<String> {
        match self {
            Setting::None | Setting::Flag(false) => None,
            Setting::Flag(true) => Some(String::new()),
            Setting::Number(number) => Some(number.to_string()),
            Setting::Real(number) => Some(number.to_string()),
            Setting::Text(text) => Some(text.clone()),
            Setting::List(words) => Some(words.join(",")),
        }
    }

    /// Returns the type in JSON.
    #[cfg(test)]
    pub(crate) fn json_type(&self) -> &'static str {
        match self {
            Setting::None => "null",
            Setting::Flag(_) => "boolean",
            Setting::Number(_) => "integer",
            Setting::Real(_) => "number",
            Setting::Text(_) => "string",
            Setting::List(_) => "array",
        }
    }
}

/// A word of an option with its meaning, as a sentence without a full stop.
pub type Word = (&'static str, &'static str);

/// A value of an option.
pub trait Value: Sized {
    /// The words of the option, if its values are words.
    const WORDS: &'static [Word] = &[];

    /// The JSON types of the form in a report, as in a JSON schema. `array` is one of texts.
    const TYPES: &'static [&'static str] = &["string"];

    /// Reads a value.
    ///
    /// # Errors
    /// Returns what was expected.
    fn read(text: &str) -> Result<Self, String>;

    /// Returns the form in a report.
    fn setting(&self) -> Setting;
}

/// An enum whose values are words. `words!` implements it, so that every variant has a word.
pub trait Words: Copy + Sized + 'static {
    /// All variants.
    const ALL: &'static [Self];

    /// The word of each variant with its meaning, in the order of [`Words::ALL`].
    const TABLE: &'static [Word];

    /// Returns the word.
    fn name(self) -> &'static str;
}

impl<T: Words> Value for T {
    const WORDS: &'static [Word] = T::TABLE;

    fn read(text: &str) -> Result<Self, String> {
        let words = || T::TABLE.iter().map(|&(word, _)| word).collect::<Vec<_>>().join(", ");
        let found = T::ALL.iter().find(|value| value.name() == text);
        found.copied().ok_or_else(|| format!("expected one of {}", words()))
    }

    fn setting(&self) -> Setting {
        Setting::Text(self.name().to_owned())
    }
}

/// Gives every variant of an enum its word and the meaning of the word. An enum without a word for a variant does not compile.
#[macro_export]
macro_rules! words {
    ($type:ident { $($variant:ident $word:literal $meaning:literal),+ $(,)? }) => {
        impl $crate::spec::Words for $type {
            const ALL: &'static [Self] = &[$($type::$variant),+];
            const TABLE: &'static [$crate::spec::Word] = &[$(($word, $meaning)),+];

            fn name(self) -> &'static str {
                match self {
                    $($type::$variant => $word),+
                }
            }
        }
    };
}

impl Value for bool {
    const TYPES: &'static [&'static str] = &["boolean"];

    fn read(text: &str) -> Result<Self, String> {
        text.parse().map_err(|_| "expected true or false".to_owned())
    }

    fn setting(&self) -> Setting {
        Setting::Flag(*self)
    }
}

/// A whole number, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Whole(pub(super) Option<u64>);

impl Value for Whole {
    const TYPES: &'static [&'static str] = &["integer", "null"];

    fn read(text: &str) -> Result<Self, String> {
        count(text).map(|number| Whole(Some(number)))
    }

    fn setting(&self) -> Setting {
        self.0.map_or(Setting::None, Setting::Number)
    }
}

/// A whole number without an exponent, of which every value is valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seed(pub(super) Option<u64>);

impl Value for Seed {
    const TYPES: &'static [&'static str] = &["integer", "null"];

    fn read(text: &str) -> Result<Self, String> {
        let number = text.parse().map_err(|_| "expected a whole number below 2^64".to_owned());
        number.map(|number| Seed(Some(number)))
    }

    fn setting(&self) -> Setting {
        Whole(self.0).setting()
    }
}

/// A whole number between bounds, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Between<const LEAST: u32, const MOST: u32>(pub(super) Option<u32>);

impl<const LEAST: u32, const MOST: u32> Value for Between<LEAST, MOST> {
    const TYPES: &'static [&'static str] = &["integer", "null"];

    fn read(text: &str) -> Result<Self, String> {
        let number = count(text)?;
        let small = u32::try_from(number).ok().filter(|number| (LEAST..=MOST).contains(number));
        let between = if MOST - LEAST == 1 { "" } else { "a number from " };
        let and = if MOST - LEAST == 1 { "or" } else { "to" };
        let expected = || format!("expected {between}{LEAST} {and} {MOST}");
        small.map(|number| Self(Some(number))).ok_or_else(expected)
    }

    fn setting(&self) -> Setting {
        Whole(self.0.map(u64::from)).setting()
    }
}

/// A whole number, or `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Auto(pub(super) Option<u64>);

impl Value for Auto {
    fn read(text: &str) -> Result<Self, String> {
        if text == "auto" { Ok(Auto(None)) } else { count(text).map(|number| Auto(Some(number))) }
    }

    fn setting(&self) -> Setting {
        Setting::Text(self.0.map_or_else(|| "auto".to_owned(), |number| number.to_string()))
    }
}

/// A number of bytes, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bytes(pub(super) Option<u64>);

impl Value for Bytes {
    const TYPES: &'static [&'static str] = &["integer", "null"];

    fn read(text: &str) -> Result<Self, String> {
        bytes(text).map(|number| Bytes(Some(number)))
    }

    fn setting(&self) -> Setting {
        Whole(self.0).setting()
    }
}

impl<T: Words> Value for Option<T> {
    const WORDS: &'static [Word] = T::TABLE;
    const TYPES: &'static [&'static str] = &["string", "null"];

    fn read(text: &str) -> Result<Self, String> {
        T::read(text).map(Some)
    }

    fn setting(&self) -> Setting {
        self.map_or(Setting::None, |value| value.setting())
    }
}

impl Value for Option<String> {
    const TYPES: &'static [&'static str] = &["string", "null"];

    fn read(text: &str) -> Result<Self, String> {
        Ok(Some(text.to_owned()))
    }

    fn setting(&self) -> Setting {
        self.clone().map_or(Setting::None, Setting::Text)
    }
}

impl Value for Option<Vec<String>> {
    const TYPES: &'static [&'static str] = &["array", "null"];

    fn read(text: &str) -> Result<Self, String> {
        Ok(Some(text.split(',').map(str::to_owned).collect()))
    }

    fn setting(&self) -> Setting {
        self.clone().map_or(Setting::None, Setting::List)
    }
}

/// Numbers, of which some may be absent: the word `none`. Or no list.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reals(pub(super) Option<Vec<Option<f64>>>);

impl Value for Reals {
    const TYPES: &'static [&'static str] = &["array", "null"];

    fn read(text: &str) -> Result<Self, String> {
        let number = |word: &str| match word {
            "none" => Ok(None),
            _ => word
                .parse()
                .map(Some)
                .map_err(|_| format!("expected numbers with commas between them, not {word}")),
        };
        text.split(',').map(number).collect::<Result<Vec<_>, _>>().map(|numbers| Reals(Some(numbers)))
    }

    fn setting(&self) -> Setting {
        let word =
            |number: &Option<f64>| number.map_or_else(|| "none".to_owned(), |number| number.to_string());
        self.0.as_ref().map_or(Setting::None, |numbers| Setting::List(numbers.iter().map(word).collect()))
    }
}

/// Reads a whole number, possibly with an exponent.
///
/// # Errors
/// Returns what was expected.
pub fn count(text: &str) -> Result<u64, String> {
    let parsed = match text.split_once(['e', 'E']) {
        None => text.parse().ok(),
        Some((mantissa, exponent)) => exponent
            .parse()
            .ok()
            .and_then(|e| 10u64.checked_pow(e))
            .and_then(|power| mantissa.parse::<u64>().ok()?.checked_mul(power)),
    };
    parsed.ok_or_else(|| "expected a whole number, such as 1000 or 1e6".to_owned())
}

/// Reads a number of bytes; K, M, G and T stand for powers of 1024.
///
/// # Errors
/// Returns what was expected.
pub fn bytes(text: &str) -> Result<u64, String> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let text = text.strip_suffix('i').unwrap_or(text);
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'm' | 'M')) => (&text[..at], 20),
        Some((at, 'g' | 'G')) => (&text[..at], 30),
        Some((at, 't' | 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let value = digits.parse::<f64>().ok().filter(|v| *v >= 0.0 && v.is_finite());
    let value = value.ok_or_else(|| "expected a number of bytes, such as 500M or 2G".to_owned())?;
    Ok((value * (1u64 << shift) as f64) as u64)
}
