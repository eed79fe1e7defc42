//! Workloads and measurements of septet. See `README.md`.
