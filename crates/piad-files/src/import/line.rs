//! A line of a text: its end, and the comment in it.

/// What comments begin with.
const COMMENTS: [&str; 4] = ["#", "//", "%", "!"];

/// The most comment marks that are examined in a line: texts have few of them.
const MOST_MARKS: usize = 100;

/// The line ends of a text. Blanks at their ends are trimmed, among them that of `\r\n`. Old Macintosh files end their
/// lines with it alone.
pub(super) fn line_end(text: &str) -> char {
    match text.contains('\n') {
        true => '\n',
        false => '\r',
    }
}

/// The blanks around lines.
pub(super) fn blank_or_tab(c: char) -> bool {
    c.is_whitespace() || c == '\0'
}

/// A line without a comment, and without blanks around it but for tabs, which may separate columns that are empty.
pub(super) fn without_comment(line: &str) -> &str {
    let is_blank = |c: char| blank_or_tab(c) && c != '\t';
    let line = line.trim_matches(is_blank);
    if line.trim().is_empty() || is_comment(line.trim_start()) {
        return "";
    }
    let marks = line.match_indices('#').map(|(index, _)| index);
    let whole = line.matches('"').count() % 2 == 1;
    // A mark between quotes is one of a text.
    let is_outside = |index: &usize| {
        let before = line.get(..*index).unwrap_or_default();
        whole || before.matches('"').count() % 2 == 0
    };
    let comment = marks.take(MOST_MARKS).find(is_outside);
    let line = comment.map_or(line, |index| line.get(..index).unwrap_or(line));
    line.trim_end_matches(is_blank)
}

/// Returns true if a line begins with what comments begin with.
pub(super) fn is_comment(line: &str) -> bool {
    COMMENTS.iter().any(|mark| line.starts_with(mark))
}
