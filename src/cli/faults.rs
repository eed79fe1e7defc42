//! The option `--fault`: the faults that tests and claims plant in a machine.

use septet_core::spec::{FAULTS, Fault, FaultForm};

use super::text::suggestion;

/// The value of the option `--fault` of `septet reproduce`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultArg {
    /// Lists all faults.
    List,
    /// Plants a fault.
    Planted(Fault),
}

/// Parses a fault. The error names the nearest name, if one is near.
pub fn fault(text: &str) -> Result<Fault, String> {
    text.parse().map_err(|error: septet_core::spec::FaultTextError| {
        format!("{}{error}", suggestion(error.unknown(), error.choices()))
    })
}

/// Parses a fault or the word `list`.
pub fn fault_or_list(text: &str) -> Result<FaultArg, String> {
    if text == "list" { Ok(FaultArg::List) } else { fault(text).map(FaultArg::Planted) }
}

/// Returns the list of all faults, each with its effect.
pub fn listed() -> String {
    let row = |form: &FaultForm| format!("{}\n  {}\n", form.text, form.effect);
    FAULTS.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_fault_has_a_nearest_name() {
        let error = |text: &str| fault_or_list(text).expect_err(text);
        assert!(
            error("flod").starts_with("the nearest is flood; there is no fault `flod`; the faults are slow")
        );
        assert!(error("free:huls").starts_with("the nearest is hulls; fault `free` has no phase `huls`"));
        assert!(error("free").starts_with("fault `free` does not have the form `free:PHASE`"));
        assert!(error("sleep").starts_with("there is no fault `sleep`"));
        assert_eq!(fault_or_list("list"), Ok(FaultArg::List));
        assert_eq!(fault_or_list("flood"), Ok(FaultArg::Planted(Fault::Flood)));
    }
}
