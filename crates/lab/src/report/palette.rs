//! Colours of plots, each in light and in dark: a picture follows what the reader's system prefers.

/// Classes of elements, and their colours in light and in dark pictures.
pub(super) const COLORS: [(&str, &str, &str); 3 + SERIES] = [
    ("paper", "#ffffff", "#161b22"),
    ("ink", "#282828", "#e1e4e8"),
    ("grid", "#e1e1e1", "#383e47"),
    // Those of series. Distinguishable with any kind of colour vision (after Okabe and Ito), with
    // enough contrast for thin lines.
    ("s0", "#0072b2", "#5ab4f0"),
    ("s1", "#d55e00", "#ff8c3c"),
    ("s2", "#009169", "#3ccda0"),
    ("s3", "#be649b", "#e69bcd"),
    ("s4", "#d29100", "#f0be46"),
    ("s5", "#46a0d7", "#96d7ff"),
    ("s6", "#3c3c3c", "#c8c8c8"),
    ("s7", "#969696", "#7d828a"),
];

/// Number of colours of series.
pub(super) const SERIES: usize = 8;

const SHAPES: &str = "\
.plot text{fill:currentColor;font:14.4px sans-serif}.plot .title{font-size:16px}\
.plot .middle{text-anchor:middle}.plot .end{text-anchor:end}\
.plot .line{fill:none;stroke:currentColor;stroke-width:2}.plot .dashed{stroke-dasharray:7 5}\
.plot .thin{stroke-width:1}.plot .dot{fill:currentColor}\
.plot .band{fill:currentColor;opacity:.2}.plot .column{fill:currentColor;opacity:.6}";

/// The style sheet of a picture.
pub(super) fn style() -> String {
    let [light, dark] = [0, 1].map(|scheme| {
        let rule = |&(class, light, dark): &(&str, &str, &str)| {
            format!(".plot .{class}{{color:{}}}", [light, dark][scheme])
        };
        COLORS.iter().map(rule).collect::<String>()
    });
    format!("<style>{SHAPES}{light}@media(prefers-color-scheme:dark){{{dark}}}</style>")
}
