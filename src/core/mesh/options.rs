//! The options of a mesh: one row for each, besides the rows of its runs.

use super::request::{Boundary, MeshSpec, SingularityRequest, SingularityShape};
use crate::spec::{Commands, Heading, Matters, Row, Setting, Value, Words, option};

/// A positive length in the unit of the domain, or none.
struct Length(Option<f64>);

impl Value for Length {
    const TYPES: &'static [&'static str] = &["number", "null"];

    fn read(text: &str) -> Result<Self, String> {
        number(text, "a positive length", |x| x > 0.0).map(|x| Length(Some(x)))
    }

    fn setting(&self) -> Setting {
        self.0.map_or(Setting::None, Setting::Real)
    }
}

/// The upper limit of the size, or the request for a triangulation as it is.
enum Upper {
    /// No triangle and no cell is divided because of its size or its shape.
    AsItIs,
    /// The limit, if there is one.
    Most(Option<f64>),
}

/// The word for a triangulation as it is.
const AS_IT_IS: &str = "none";

impl Value for Upper {
    const TYPES: &'static [&'static str] = &["number", "string", "null"];

    fn read(text: &str) -> Result<Self, String> {
        if text == AS_IT_IS {
            return Ok(Upper::AsItIs);
        }
        let length = Length::read(text).map_err(|expected| format!("{expected}, or `{AS_IT_IS}`"))?;
        Ok(Upper::Most(length.0))
    }

    fn setting(&self) -> Setting {
        match *self {
            Upper::AsItIs => Setting::Text(AS_IT_IS.to_owned()),
            Upper::Most(most) => Length(most).setting(),
        }
    }
}

/// An angle in degrees.
struct Degrees(f64);

impl Value for Degrees {
    const TYPES: &'static [&'static str] = &["number"];

    fn read(text: &str) -> Result<Self, String> {
        number(text, "an angle from 0 to 180 degrees", |x| (0.0..=180.0).contains(&x)).map(Degrees)
    }

    fn setting(&self) -> Setting {
        Setting::Real(self.0)
    }
}

/// A Lipschitz constant L.
struct Lipschitz(f64);

impl Value for Lipschitz {
    const TYPES: &'static [&'static str] = &["number"];

    fn read(text: &str) -> Result<Self, String> {
        number(text, "a number between 0 and 1, both exclusive", |x| x > 0.0 && x < 1.0).map(Lipschitz)
    }

    fn setting(&self) -> Setting {
        Setting::Real(self.0)
    }
}

/// A radius-edge ratio B.
struct Ratio(f64);

impl Ratio {
    /// Returns `L = 1 - 1/B`.
    fn lipschitz(&self) -> f64 {
        1.0 - 1.0 / self.0
    }
}

impl Value for Ratio {
    const TYPES: &'static [&'static str] = &["number"];

    fn read(text: &str) -> Result<Self, String> {
        // L must lie strictly between 0 and 1 after rounding.
        let is_valid = |b| b > 1.0 && Ratio(b).lipschitz() > 0.0 && Ratio(b).lipschitz() < 1.0;
        number(text, "a number above 1", is_valid).map(Ratio)
    }

    fn setting(&self) -> Setting {
        Setting::Real(self.0)
    }
}

impl Value for Option<SingularityRequest> {
    const TYPES: &'static [&'static str] = &["string", "null"];

    fn read(text: &str) -> Result<Self, String> {
        singularity(text)
            .map(Some)
            .ok_or_else(|| "expected `point`, `line`, `point:X,Y[,Z]` or `line:X,Y[,Z],X,Y[,Z]`".to_owned())
    }

    fn setting(&self) -> Setting {
        let text = |request: &SingularityRequest| {
            let at: Vec<String> = request.at.iter().map(f64::to_string).collect();
            let colon = if at.is_empty() { "" } else { ":" };
            Setting::Text(format!("{}{colon}{}", request.shape.name(), at.join(",")))
        };
        self.as_ref().map_or(Setting::None, text)
    }
}

/// Parses a number and checks a condition.
fn number(text: &str, expected: &str, is_valid: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&x: &f64| x.is_finite() && is_valid(x));
    number.ok_or_else(|| format!("expected {expected}"))
}

fn singularity(text: &str) -> Option<SingularityRequest> {
    let (name, place) = text.split_once(':').map_or((text, None), |(name, place)| (name, Some(place)));
    let shape = SingularityShape::read(name).ok()?;
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let at: Vec<f64> = place.map_or(Some(Vec::new()), |place| place.split(',').map(number).collect())?;
    let is_valid = place.is_none()
        || [2, 3].contains(&(at.len() / shape.points())) && at.len().is_multiple_of(shape.points());
    is_valid.then_some(SingularityRequest { shape, at })
}

/// The options of a mesh, in the order in which they are set and listed.
pub static MESH_OPTIONS: &[Row<MeshSpec>] = &[
    option!(
        MeshSpec, "weld", "weld",
        "Join points within this distance, in the unit of the domain\n\nNo point moves further. Points with equal coordinates \
         always count as one.",
        Length,
        |s| Length(s.tolerance.weld),
        |s, Length(distance)| { s.tolerance.weld = distance; Ok(()) },
        { form: "EPS", commands: Commands::MESH, heading: Heading::Boundary, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "repair", "repair",
        "Repair the domain, and list what was done\n\nEdges are divided at points on them (T-junctions), double and flat facets \
         are dropped, small holes are closed, and bent polygons of surfaces are divided into triangles.",
        bool,
        |s| s.tolerance.repair,
        |s, is_set| { s.tolerance.repair = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Boundary, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "strict", "strict",
        "Refuse domains that are not exact\n\nEqual points, facets that are planar only within the digits of their coordinates, \
         and edges of surfaces with four facets are then defects.",
        bool,
        |s| s.tolerance.strict,
        |s, is_set| { s.tolerance.strict = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Boundary, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "boundary", "boundary",
        "Treatment of the boundary [default: exact for .poly and .smesh, remesh for surfaces]",
        Option<Boundary>,
        |s| s.boundary,
        |s, boundary| { s.boundary = boundary; Ok(()) },
        { commands: Commands::MESH, heading: Heading::Boundary, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "size", "size",
        "Upper limit of the size; edges can be about twice as long\n\nWith `none`, the domain is triangulated as it is: \
         every edge and every facet is kept. In space, points are added on edges that cannot be kept otherwise.",
        Upper,
        |s| if s.as_it_is { Upper::AsItIs } else { Upper::Most(s.sizes.most) },
        |s, upper| {
            (s.as_it_is, s.sizes.most) = match upper {
                Upper::AsItIs => (true, None),
                Upper::Most(most) => (false, most),
            };
            Ok(())
        },
        { form: "H|none", commands: Commands::MESH, heading: Heading::Sizes, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "singularity", "singularity",
        "Grade sizes down to {min-size} at a point or on a line\n\nCoordinates follow after a colon, as in \
         `point:0,0,1`. By default, the point is the centre of the bounding box, and the line is the middle third of \
         the box along x.",
        Option<SingularityRequest>,
        |s| s.sizes.singularity.clone(),
        |s, singularity| { s.sizes.singularity = singularity; Ok(()) },
        { form: "point|line[:X,Y,..]", commands: Commands::MESH, heading: Heading::Sizes, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "lipschitz", "lipschitz",
        "Growth rate of sizes, between 0 and 1\n\nAway from the boundary, radius-edge ratios are at most 1/(1-L).",
        Lipschitz,
        |s| Lipschitz(s.sizes.lipschitz),
        |s, Lipschitz(rate)| { s.sizes.lipschitz = rate; Ok(()) },
        { form: "L", commands: Commands::MESH, heading: Heading::Sizes, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "radius-edge", "radius_edge",
        "Largest radius-edge ratio away from the boundary, above 1\n\nIt sets the growth rate of sizes to L = 1 - 1/B.",
        Ratio,
        |s| Ratio(s.radius_edge()),
        |s, ratio| { s.sizes.lipschitz = ratio.lipschitz(); Ok(()) },
        { form: "B", commands: Commands::MESH, heading: Heading::Sizes, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "min-size", "min_size",
        "Lower limit of the size; overrides every other size",
        Length,
        |s| Length(s.sizes.least),
        |s, Length(size)| { s.sizes.least = size; Ok(()) },
        { form: "H", commands: Commands::MESH, heading: Heading::Sizes, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "keep-surface", "keep_surface",
        "Place no points on the boundary for sizes and shapes\n\nThe boundary is exact. A point on an edge of the input is \
         added only where the edge cannot be kept otherwise. Cells at the boundary are as good as its triangles allow.",
        bool,
        |s| s.keep_surface,
        |s, is_set| { s.keep_surface = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Boundary, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "feature-angle", "feature_angle",
        "Angle in degrees above which an edge of a surface is a ridge\n\nThe angle is the one by which the surface turns there.",
        Degrees,
        |s| Degrees(s.feature_angle),
        |s, Degrees(angle)| { s.feature_angle = angle; Ok(()) },
        { form: "DEG", commands: Commands::MESH, heading: Heading::Boundary, matters: Matters::Cells, needs: Some(("boundary", "remesh")) }
    ),
    option!(
        MeshSpec, "max-distance", "max_distance",
        "Largest distance between a surface and its remeshed boundary\n\nBy default, refinement aims at a tenth of the \
         local size at face centres, and the limit is half the size.",
        Length,
        |s| Length(s.max_distance),
        |s, Length(distance)| { s.max_distance = distance; Ok(()) },
        { form: "D", commands: Commands::MESH, heading: Heading::Boundary, is_common: true, matters: Matters::Cells, needs: Some(("boundary", "remesh")) }
    ),
    option!(
        MeshSpec, "conforming", "conforming",
        "Place points by Section 5 of the paper\n\nWithout the option, the constrained triangulation of a domain is refined: in \
         the plane until no angle is below 20 degrees, and in space until no circumradius exceeds 1.46 times the shortest \
         edge, except near small angles of the domain. This needs a fraction of the cells. Remeshing always uses Section 5.",
        bool,
        |s| s.conforming,
        |s, is_set| { s.conforming = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Sizes, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "improve", "improve",
        "Remove cells with small angles (the default)\n\nCells are flipped, and vertices are moved, inserted and merged, until \
         no angle is below 16 degrees, if possible.",
        bool,
        |s| s.improve,
        |s, is_set| { s.improve = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Sizes, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "no-improve", "no_improve",
        "Keep the Delaunay mesh of the generator with its slivers",
        bool,
        |s| !s.improve,
        |s, is_set| { s.improve = !is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Sizes, is_common: true, matters: Matters::Cells }
    ),
    option!(
        MeshSpec, "by-recursion", "by_recursion",
        "Count triangulations by the paper's recursion\n\nThe mesh is the same, but takes several times as long. Without \
         the option, the direct path triangulates, and each worker counts its operations one after the other.",
        bool,
        |s| s.by_recursion,
        |s, is_set| { s.by_recursion = is_set; Ok(()) },
        { is_flag: true, commands: Commands::MESH, heading: Heading::Machine, matters: Matters::Counts }
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Sizes;

    #[test]
    fn every_field_has_a_row() {
        // A new field does not compile here until it is named.
        let MeshSpec {
            run: _,
            tolerance: _,
            boundary: _,
            sizes,
            // The option `size` sets it.
            as_it_is: _,
            keep_surface: _,
            feature_angle: _,
            max_distance: _,
            conforming: _,
            improve: _,
            by_recursion: _,
        } = MeshSpec::default();
        // The field of sizes is read from a file.
        let Sizes { most: _, least: _, field: _, singularity: _, lipschitz: _ } = sizes;
        let names: Vec<&str> = MESH_OPTIONS.iter().map(|row| row.name).collect();
        let fields = "weld repair strict boundary size singularity lipschitz radius-edge min-size keep-surface feature-angle \
                      max-distance conforming improve no-improve by-recursion";
        assert_eq!(names.join(" "), fields);
    }

    #[test]
    fn values_survive_a_round_trip() {
        let values = [
            ("boundary", "exact"),
            ("weld", "0.001"),
            ("size", "none"),
            ("size", "0.25"),
            ("singularity", "line:0,0,1,1,0.5,1"),
            ("lipschitz", "0.25"),
            ("min-size", "0.001"),
            ("feature-angle", "45"),
            ("max-distance", "0.01"),
            ("radius-edge", "1.6"),
        ];
        let mut spec = MeshSpec::default();
        for (name, text) in values {
            let row = MESH_OPTIONS.iter().find(|row| row.name == name).unwrap();
            row.set(&mut spec, text).unwrap();
            assert_eq!(row.get(&spec).text().as_deref(), Some(text), "{name}");
            assert!(row.is_changed(&spec), "{name}");
            for value in [row.get(&spec), row.get(&MeshSpec::default())] {
                assert!(row.types.contains(&value.json_type()), "{name}: {value:?}");
            }
        }
        assert_eq!(spec.sizes.lipschitz, 1.0 - 1.0 / 1.6);
    }

    #[test]
    fn values_that_options_do_not_have_are_refused() {
        let refused = [
            ("size", "0"),
            ("size", "-1"),
            ("size", "inf"),
            ("size", "nothing"),
            ("lipschitz", "1"),
            ("radius-edge", "1"),
            ("radius-edge", "1e300"),
            ("feature-angle", "181"),
            ("singularity", "cube"),
            ("singularity", "point:1"),
            ("singularity", "line:1,2,3"),
            ("singularity", "point:1,2,3,4"),
            ("singularity", "point:1,x"),
            ("boundary", "keep"),
        ];
        for (name, text) in refused {
            let row = MESH_OPTIONS.iter().find(|row| row.name == name).unwrap();
            assert!(row.check(text).is_err(), "{name} {text}");
        }
    }
}
