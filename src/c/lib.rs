//! septet-c: the C library. `include/septet.h` describes its functions.
//!
//! `ffi` has the exported functions and all `unsafe`: it makes slices and references of pointers, and calls the other modules.
//!
//! | what | module |
//! | --- | --- |
//! | the exported functions | [`ffi`] |
//! | the options, the triangulation behind a handle | `handle` |
//! | the status of a call, the last failure of a thread | `last` |
//! | the flag of a caller that ends a call | `watch` |

pub mod ffi;
mod handle;
mod last;
mod watch;

pub use handle::Handle;
