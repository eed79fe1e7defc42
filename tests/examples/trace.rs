//! Writes a trace of a run for Perfetto, with the layer attached to a subscriber of this program.
//!
//! `cargo run --release --example trace -- trace.json`

use std::error::Error;
use std::path::PathBuf;

use septet::Spec;
use septet::trace::{Detail, layer};
use tracing_subscriber::layer::SubscriberExt;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("trace.json"), PathBuf::from);
    let (layer, file) = layer(&path, Detail::Message)?;
    let subscriber = tracing_subscriber::registry().with(layer);

    let points: Vec<[f64; 2]> =
        (0..2000).map(|i| [f64::from(i * i % 997), f64::from(i * 7 % 1009)]).collect();
    let run =
        tracing::subscriber::with_default(subscriber, || septet::triangulate(&points, &Spec::default()))?;
    let path = file.finish()?;
    println!("{} triangles, trace in {}", run.cell_count(), path.display());
    Ok(())
}
