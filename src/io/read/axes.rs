//! The names of columns that mean an axis.
//!
//! A name is compared in lower case, without quotes and without a unit in brackets at its end. It means an axis if one of
//! its words does, and its other words are in [`AFFIXES`]: `x`, `X [mm]`, `x_m`, `POINT_X` and `x_coord` mean x. Words
//! are separated by blanks, underscores, hyphens or points, and may be glued (`pointx`).

/// The words of a coordinate system that mean its axes. Longitudes and eastings are x, in any order of the columns.
struct System {
    words: [&'static [&'static str]; 3],
}

/// Words for heights above the ground plane.
const HEIGHTS: &[&str] = &["z", "elevation", "elev", "altitude", "alt", "height"];

/// Words for heights in German.
const GERMAN_HEIGHTS: &[&str] = &["z", "höhe", "hoehe"];

/// The coordinate systems. The first one that a header names is used.
const SYSTEMS: [System; 5] = [
    System { words: [&["x"], &["y"], &["z"]] },
    System { words: [&["lon", "long", "lng", "longitude"], &["lat", "latitude"], HEIGHTS] },
    System { words: [&["easting", "eastings"], &["northing", "northings"], HEIGHTS] },
    System { words: [&["rechtswert"], &["hochwert"], GERMAN_HEIGHTS] },
    System { words: [&["points:0", "points_0"], &["points:1", "points_1"], &["points:2", "points_2"]] },
];

/// Words that a name may have besides the word of its axis.
pub(super) const AFFIXES: [&str; 16] = [
    "m",
    "mm",
    "cm",
    "km",
    "ft",
    "deg",
    "degree",
    "degrees",
    "decimal",
    "utm",
    "wgs84",
    "coord",
    "coordinate",
    "pos",
    "position",
    "point",
];

/// A column that means an axis of a system: its position, and the words besides that of the axis.
struct Meaning {
    position: usize,
    affixes: String,
}

/// Returns the positions of x and y, and of z if there is one, among names in lower case. Returns `None` if no names, or
/// several sets of names, mean x and y.
pub(super) fn axes(names: &[String]) -> Option<Vec<usize>> {
    if let Found::One(axes) = SYSTEMS[0].axes(names) {
        return Some(axes);
    }
    let mut found = SYSTEMS.iter().map(|system| system.axes(names)).filter(|found| *found != Found::None);
    match (found.next(), found.next()) {
        (Some(Found::One(axes)), None) => Some(axes),
        _ => None,
    }
}

/// Returns the position of the only name in lower case that means a height.
pub(super) fn height(names: &[String]) -> Option<usize> {
    match &meanings(names, &[HEIGHTS, &GERMAN_HEIGHTS[1..]].concat())[..] {
        [height] => Some(height.position),
        _ => None,
    }
}

/// The axes that the names of a header mean in a system.
#[derive(PartialEq)]
enum Found {
    /// No names mean x and y.
    None,
    /// These columns.
    One(Vec<usize>),
    /// Several columns mean the same axis.
    Several,
}

impl System {
    fn axes(&self, names: &[String]) -> Found {
        let [xs, ys, zs] = self.words.map(|words| meanings(names, words));
        if xs.is_empty() || ys.is_empty() {
            return Found::None;
        }
        let Some((x, y)) = pair(&xs, &ys) else { return Found::Several };
        let like_x: Vec<&Meaning> = zs.iter().filter(|z| z.affixes == x.affixes).collect();
        let z = match (&like_x[..], &zs[..]) {
            ([z], _) => Some(*z),
            ([], [z]) => Some(z),
            ([], []) => None,
            _ => return Found::Several,
        };
        Found::One([Some(x), Some(y), z].into_iter().flatten().map(|of| of.position).collect())
    }
}

/// Returns the columns that one of the words means.
fn meanings(names: &[String], words: &[&str]) -> Vec<Meaning> {
    let of = |(position, name): (usize, &String)| Some(Meaning { position, affixes: affixes(name, words)? });
    names.iter().enumerate().filter_map(of).collect()
}

/// Returns the only x and y, or those with the same affixes if only one pair has the same, or no affixes.
fn pair<'a>(xs: &'a [Meaning], ys: &'a [Meaning]) -> Option<(&'a Meaning, &'a Meaning)> {
    if let ([x], [y]) = (xs, ys) {
        return Some((x, y));
    }
    let with = |all: &'a [Meaning], affixes: &str| {
        let mut found = all.iter().filter(move |of| of.affixes == affixes);
        found.next().filter(|_| found.next().is_none())
    };
    let bare = with(xs, "").zip(with(ys, ""));
    let mut pairs = xs.iter().filter_map(|x| with(xs, &x.affixes).zip(with(ys, &x.affixes)));
    bare.or_else(|| pairs.next().filter(|_| pairs.next().is_none()))
}

/// Returns the words of a name besides the word of the axis, or `None` if the name does not mean the axis.
fn affixes(name: &str, words: &[&str]) -> Option<String> {
    if words.contains(&name) {
        return Some(String::new());
    }
    let is_end = |c: char| matches!(c, ' ' | '_' | '-' | '.');
    let mut parts: Vec<&str> = name.split(is_end).filter(|part| !part.is_empty()).collect();
    let axis = parts.iter().position(|part| words.contains(part) || glued(part, words).is_some())?;
    let own = parts.remove(axis);
    if let Some(affix) = glued(own, words) {
        parts.push(affix);
    }
    parts.iter().all(|part| AFFIXES.contains(part)).then(|| parts.join(" "))
}

/// Returns the affix of a word that consists of the word of an axis and an affix of three or more letters.
fn glued<'a>(part: &'a str, words: &[&str]) -> Option<&'a str> {
    let affix = |word: &&str| part.strip_prefix(word).or_else(|| part.strip_suffix(word));
    words.iter().filter_map(affix).find(|affix| affix.len() > 2 && AFFIXES.contains(affix))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &str) -> Option<Vec<usize>> {
        axes(&names.split(',').map(str::to_lowercase).collect::<Vec<_>>())
    }

    #[test]
    fn names_mean_axes() {
        for (names, positions) in [
            ("x,y", &[0, 1][..]),
            ("id,z,y,x", &[3, 2, 1]),
            ("FID,POINT_X,POINT_Y", &[1, 2]),
            ("x_m,y_m,z_m", &[0, 1, 2]),
            ("x_coord,y_coord,z", &[0, 1, 2]),
            ("xcoord,ycoord", &[0, 1]),
            ("x,y,x_utm,y_utm", &[0, 1]),
            ("x,y,elevation", &[0, 1]),
            ("lat,lon", &[1, 0]),
            ("name,latitude,longitude,elevation", &[2, 1, 3]),
            ("decimalLatitude,decimalLongitude", &[1, 0]),
            ("Northing,Easting,Elevation", &[1, 0, 2]),
            ("Hochwert,Rechtswert,Höhe", &[1, 0, 2]),
            ("pressure,Points:0,Points:1,Points:2", &[1, 2, 3]),
            ("Point ID,Points_0,Points_1,Points_2,Points_Magnitude", &[1, 2, 3]),
            ("lon,lat,x,y", &[2, 3]),
        ] {
            assert_eq!(of(names).as_deref(), Some(positions), "{names}");
        }
        for names in [
            "x,x,y",
            "x,y,z,z",
            "a,b,c",
            "ra,dec,z",
            "P,N,E,Z,D",
            "x,z",
            "x1,y1",
            "index,exit,why",
            "lon,lat,easting,northing",
            "x_m,y_m,x_ft,y_ft",
            "max x,max y",
            "lon,lat,lat",
        ] {
            assert_eq!(of(names), None, "{names}");
        }
    }
}
