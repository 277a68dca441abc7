//! Colours of plots, each in light and in dark: a picture follows what the reader's system prefers.

use std::fmt::Write;

use plotters::style::RGBColor;

/// A colour of light pictures, and what stands for it in dark ones.
pub(super) struct Shade {
    pub light: RGBColor,
    dark: RGBColor,
}

const fn shade(light: [u8; 3], dark: [u8; 3]) -> Shade {
    Shade {
        light: RGBColor(light[0], light[1], light[2]),
        dark: RGBColor(dark[0], dark[1], dark[2]),
    }
}

pub(super) const PAPER: Shade = shade([255, 255, 255], [22, 27, 34]);
pub(super) const INK: Shade = shade([40, 40, 40], [225, 228, 232]);
pub(super) const GRID: Shade = shade([225, 225, 225], [56, 62, 71]);

/// Those of series. Distinguishable with any kind of colour vision (after Okabe and Ito), with enough contrast for thin lines.
pub(super) const SERIES: [Shade; 8] = [
    shade([0, 114, 178], [90, 180, 240]),
    shade([213, 94, 0], [255, 140, 60]),
    shade([0, 145, 105], [60, 205, 160]),
    shade([190, 100, 155], [230, 155, 205]),
    shade([210, 145, 0], [240, 190, 70]),
    shade([70, 160, 215], [150, 215, 255]),
    shade([60, 60, 60], [200, 200, 200]),
    shade([150, 150, 150], [125, 130, 138]),
];

/// The SVG with a style sheet in front, which changes the colours for readers who prefer dark pages.
pub(super) fn with_dark_mode(svg: &str) -> String {
    let mut rules = String::new();
    for Shade { light, dark } in [&PAPER, &INK, &GRID].into_iter().chain(&SERIES) {
        let [light, dark] =
            [light, dark].map(|color| format!("#{:02X}{:02X}{:02X}", color.0, color.1, color.2));
        for property in ["fill", "stroke"] {
            // Writing to a string cannot fail.
            let _ = write!(rules, "[{property}=\"{light}\"]{{{property}:{dark}}}");
        }
    }
    let (head, body) = svg.split_once('>').unwrap_or((svg, ""));
    format!("{head}>\n<style>@media (prefers-color-scheme:dark){{{rules}}}</style>{body}")
}
