//! Tool paths in G-code: straight moves and arcs, each path between rapid moves a part.

mod arc;
mod machine;
mod words;

use super::curves::Curves;
use super::error::{FileError, FileErrors, MOST_ERRORS};
use super::imported::Hints;
use super::line::line_end;
use super::part::Parts;
use machine::{Machine, Units, value};
use words::{Word, words};

/// The most lines above the first move.
const MOST_HEAD: usize = 1000;

/// The most skipped words that are named.
const MOST_NAMES: usize = 10;

/// Returns true if all lines down to a first move by coordinates are words of G-code.
pub(super) fn is_gcode(text: &str) -> bool {
    let lines = blocks(text).take(MOST_HEAD).map(|(_, words)| words);
    let mut is_first = true;
    for words in lines {
        let Ok(words) = words else {
            return false;
        };
        let Some(first) = words.first() else {
            continue;
        };
        if is_first && !"GMNTFSO".contains(first.letter) {
            return false;
        }
        is_first = false;
        if is_move(&words) {
            return true;
        }
    }
    false
}

/// Each path is a part.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let feeds = blocks(text).any(|(_, words)| words.is_ok_and(|words| is_feed(&words)));
    let mut machine = Machine::new(hints.most, feeds);
    let mut errors = Vec::new();
    for (line, words) in blocks(text) {
        let done = match words {
            Ok(words) => machine.block(&words, line),
            Err(detail) => Err(FileError::at(line as usize, detail)),
        };
        errors.extend(done.err());
        if errors.len() >= MOST_ERRORS {
            break;
        }
    }
    if !errors.is_empty() {
        return Err(FileErrors(errors));
    }
    machine.end_path()?;
    finish(machine, feeds)
}

/// The blocks of a text with their lines, from 1. Tape marks (`%`) are skipped.
fn blocks(text: &str) -> impl Iterator<Item = (u32, Result<Vec<Word>, String>)> {
    let lines = text.split(line_end(text)).zip(1..);
    let lines = lines.map(|(line, number)| (number, line.trim()));
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    lines.map(|(number, line)| (number, words(line)))
}

/// Returns true if a block moves by coordinates that it names.
fn is_move(words: &[Word]) -> bool {
    let is_motion = |word: &Word| word.letter == 'G' && [0.0, 1.0, 2.0, 3.0].contains(&word.number);
    words.iter().any(is_motion) && "XYZIJ".chars().any(|it| value(words, it).is_some())
}

/// Returns true if a block feeds material along a move in the plane, as printers do.
fn is_feed(words: &[Word]) -> bool {
    let has = |letter| value(words, letter).is_some();
    has('E') && (has('X') || has('Y'))
}

fn finish(machine: Machine, feeds: bool) -> Result<Parts, FileErrors> {
    let mut notices = Vec::new();
    if let Some(units) = machine.units {
        let units = match units {
            Units::Inches => "inches (G20)",
            Units::Millimetres => "millimetres (G21)",
        };
        notices.push(format!("The coordinates are in {units}."));
    }
    if feeds {
        let notice = "Moves that feed no material (E) separate the paths, as rapid moves do.";
        notices.push(notice.to_owned());
    }
    if machine.plunges {
        let notice = "Moves straight up or down at the ends of paths are left out.";
        notices.push(notice.to_owned());
    }
    let listed = machine.unread.iter().take(MOST_NAMES);
    let listed: Vec<String> = listed
        .map(|(word, count)| format!("{count} {word}"))
        .collect();
    if !listed.is_empty() {
        let more = match machine.unread.len() > MOST_NAMES {
            true => " and others",
            false => "",
        };
        notices.push(format!(
            "Words that are not read: {}{more}.",
            listed.join(", ")
        ));
    }
    let dimension = match height(&machine.curves) {
        Some(height) => {
            if height != 0.0 {
                notices.push(format!("All points have z = {height}, which is left out."));
            }
            2
        }
        None => 3,
    };
    machine.curves.finish(dimension, notices)
}

/// The height of all points, if it is the same.
fn height(curves: &Curves) -> Option<f64> {
    let mut heights = curves.points().map(|[_, _, z]| *z);
    let first = heights.next()?;
    heights.all(|z| z == first).then_some(first)
}

#[cfg(test)]
mod tests;
