//! Notation of kinds and samples on the command line.

use std::str::FromStr;

use super::kind::Kind;
use super::request::{GenerateError, Request};

impl FromStr for Kind {
    type Err = GenerateError;

    fn from_str(name: &str) -> Result<Self, GenerateError> {
        let wanted = if name == "graded-point" { "graded" } else { name };
        let found = Kind::all().find(|kind| kind.name() == wanted);
        found.ok_or_else(|| GenerateError::UnknownKind { name: name.into() })
    }
}

/// Parses `KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`. The defaults are dimension 3, seed 0 and the default
/// constants. `N` may have an exponent, as in `1e6`.
///
/// # Errors
///
/// Returns an error that names the part that cannot be parsed or the unknown kind. [`super::generate`] checks the
/// ranges.
pub fn parse_sample(spec: &str) -> Result<Request, GenerateError> {
    let fail = |reason: String| GenerateError::Spec { spec: spec.into(), reason };
    let (kind, rest) =
        spec.split_once(':').ok_or_else(|| fail("expected KIND:N, such as uniform:1000".into()))?;
    let kind = kind.trim().parse()?;
    let mut parts = rest.split(',').map(str::trim);
    let count = parts.next().unwrap_or_default();
    let n = parse_count(count)
        .ok_or_else(|| fail(format!("`{count}` is not a number of points, such as 1000 or 1e6")))?;
    let mut request = Request { kind, n, dimension: 3, seed: 0, lipschitz: None, ratio: None };
    for part in parts {
        let (key, value) =
            part.split_once('=').ok_or_else(|| fail(format!("expected KEY=VALUE instead of `{part}`")))?;
        let bad = || fail(format!("`{value}` is not a valid value for {key}"));
        match key {
            "d" => request.dimension = value.parse().map_err(|_| bad())?,
            "seed" => request.seed = value.parse().map_err(|_| bad())?,
            "lipschitz" => request.lipschitz = Some(value.parse().map_err(|_| bad())?),
            "ratio" => request.ratio = Some(value.parse().map_err(|_| bad())?),
            _ => return Err(fail(format!("unknown key `{key}`: expected d, seed, lipschitz or ratio"))),
        }
    }
    Ok(request)
}

/// Parses a whole number, optionally with an exponent.
fn parse_count(text: &str) -> Option<u64> {
    match text.split_once(['e', 'E']) {
        None => text.parse().ok(),
        Some((mantissa, exponent)) => {
            let power = 10u64.checked_pow(exponent.parse().ok()?)?;
            mantissa.parse::<u64>().ok()?.checked_mul(power)
        }
    }
}
