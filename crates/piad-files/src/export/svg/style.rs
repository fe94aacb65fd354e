//! Colours and lines of drawings, on light pages and on dark ones.

/// The style sheet. Programs that know no media queries draw on white.
pub(super) const STYLE: &str = "\
text{font:12px system-ui,sans-serif;fill:#495057}\
.title{font-size:15px;font-weight:600;fill:#212529}\
.page{fill:#fff}\
.curve{fill:none;stroke:#1864ab;stroke-width:2;stroke-linecap:round;stroke-linejoin:round}\
.heat{fill:none;stroke-width:9;stroke-linejoin:round;stroke-opacity:.75}\
.net{fill:none;stroke:#868e96;stroke-width:.8;stroke-opacity:.8;stroke-linejoin:round}\
.control{fill:#fff;stroke:#868e96;stroke-width:.8}\
.data{fill:#212529;stroke:#fff;stroke-width:.6}\
.outlier{fill:none;stroke:#d00;stroke-width:1.5}\
circle.end{fill:#1864ab}\
text.end{font-weight:600;fill:#1864ab}\
.axis{fill:none;stroke:#495057}\
.grid{fill:none;stroke:#dee2e6}\
@media (prefers-color-scheme:dark){\
text{fill:#adb5bd}\
.title{fill:#f1f3f5}\
.page{fill:#16181d}\
.curve{stroke:#74c0fc}\
.control{fill:#16181d}\
.data{fill:#f8f9fa;stroke:#16181d}\
circle.end,text.end{fill:#74c0fc}\
.axis{stroke:#adb5bd}\
.grid{stroke:#343a40}}";
