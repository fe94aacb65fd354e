//! The meaning of column names.

/// The meaning of a column, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    X,
    Y,
    /// Also a height or an elevation.
    Z,
    East,
    North,
    Longitude,
    Latitude,
    U,
    V,
    Time,
    Weight,
    /// Names or counters of the points.
    Id,
}

/// Names by their meaning, without units, in lower case.
const MEANINGS: [(Meaning, &[&str]); 12] = [
    (Meaning::X, &["x"]),
    (Meaning::Y, &["y"]),
    (
        Meaning::Z,
        &[
            "z",
            "elev",
            "ele",
            "elevation",
            "height",
            "h",
            "alt",
            "altitude",
        ],
    ),
    (Meaning::East, &["e", "east", "easting", "eastings"]),
    (Meaning::North, &["n", "north", "northing", "northings"]),
    (Meaning::Longitude, &["lon", "lng", "long", "longitude"]),
    (Meaning::Latitude, &["lat", "latitude"]),
    (Meaning::U, &["u"]),
    (Meaning::V, &["v"]),
    (
        Meaning::Time,
        &["t", "time", "timestamp", "datetime", "date"],
    ),
    (Meaning::Weight, &["w", "weight", "weights"]),
    (
        Meaning::Id,
        &[
            "id", "fid", "gid", "oid", "pid", "uid", "objectid", "index", "idx", "no", "nr", "num",
            "number", "name", "code", "row",
        ],
    ),
];

/// Prefixes of names, as in `pos_x`.
const PREFIXES: [&str; 12] = [
    "pos", "position", "pose", "coord", "point", "pt", "p", "utm", "gps", "map", "local", "world",
];

/// Suffixes of names, as in `x_mm`: units and the same words.
const SUFFIXES: [&str; 28] = [
    "m", "mm", "cm", "km", "um", "µm", "ft", "in", "inch", "s", "ms", "us", "ns", "sec", "secs",
    "seconds", "min", "h", "deg", "degrees", "rad", "dd", "pos", "position", "coord", "utm",
    "wgs84", "utc",
];

/// The meaning of a column name, if it is known.
pub(super) fn meaning(name: &str) -> Option<Meaning> {
    let bare = bare(name);
    let of_word = |word: &str| {
        let known = MEANINGS.iter().find(|(_, names)| names.contains(&word));
        known.map(|(meaning, _)| *meaning)
    };
    of_word(&bare).or_else(|| match axis(&bare)? {
        "x" => Some(Meaning::X),
        "y" => Some(Meaning::Y),
        "z" => Some(Meaning::Z),
        _ => None,
    })
}

/// The letter of a name in one word, such as `posx` or `xcoord`.
fn axis(word: &str) -> Option<&str> {
    let words = ["pos", "coord", "point"];
    let ends = |it| word.strip_prefix(it).or_else(|| word.strip_suffix(it));
    words.into_iter().find_map(ends).filter(|it| it.len() == 1)
}

/// A name in lower case, without units and prefixes.
pub(super) fn bare(name: &str) -> String {
    let name = without_unit(name).to_lowercase();
    let words: Vec<&str> = words(&name).collect();
    let mut words = &words[..];
    while let [.., _, last] = words
        && SUFFIXES.contains(last)
    {
        words = words.get(..words.len() - 1).unwrap_or_default();
    }
    while let [first, _, ..] = words
        && PREFIXES.contains(first)
    {
        words = words.get(1..).unwrap_or_default();
    }
    words.join("_")
}

/// Returns true if these are units of columns, as some programs write them below the names.
pub(super) fn are_units<'a>(fields: impl Iterator<Item = &'a str>) -> bool {
    let is_unit = |field: &str| {
        let bare = field.trim_matches(|c: char| "()[]".contains(c));
        let known = SUFFIXES.contains(&bare.to_lowercase().as_str());
        known || bare.is_empty() || bare == "-" || bare.len() < field.len()
    };
    let mut fields = fields.peekable();
    fields.peek().is_some() && fields.all(is_unit)
}

/// The words of a name.
fn words(name: &str) -> impl Iterator<Item = &str> {
    let words = name.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty())
}

/// A name without brackets behind it, unless these contain a number.
fn without_unit(name: &str) -> &str {
    let at = name.find(['(', '[']).filter(|at| *at > 0);
    let parts = at.and_then(|at| name.split_at_checked(at));
    let is_unit = |rest: &str| !rest.contains(|c: char| c.is_ascii_digit());
    match parts.filter(|(_, rest)| is_unit(rest)) {
        Some((name, _)) => name,
        None => name,
    }
}

/// The unit in seconds of a name of times, as in `time_ms`.
pub(super) fn seconds_of_unit(name: &str) -> f64 {
    let name = name.to_lowercase();
    match words(&name).skip(1).last() {
        Some("ms") => 1e-3,
        Some("us" | "µs") => 1e-6,
        Some("ns") => 1e-9,
        Some("min") => 60.0,
        Some("h") => 3600.0,
        _ => 1.0,
    }
}

/// The words before a number at the end of a name, and the number, as in `j1` or `joint[1] (rad)`.
pub(super) fn numbered(name: &str) -> Option<(String, u32)> {
    let name = match name.rsplit_once(['(', '[']) {
        Some((before, unit)) if !unit.contains(|c: char| c.is_ascii_digit()) => before,
        _ => name,
    };
    let name = name
        .trim_end_matches(|c: char| !c.is_alphanumeric())
        .to_lowercase();
    let words = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = name.get(words.len()..)?.parse().ok()?;
    let words = words.trim_end_matches(|c: char| !c.is_alphanumeric());
    (!words.is_empty()).then(|| (words.to_owned(), number))
}
