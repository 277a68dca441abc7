//! One HTML page with its pictures inside: no script, no other file, readable on a telephone and on paper.

use super::Picture;
use std::fmt::Write;

/// A page of sections.
pub struct Page {
    /// Its heading.
    pub title: String,
    /// Paragraphs.
    pub intro: Vec<String>,
    /// What comes after them, with a table of contents in front.
    pub sections: Vec<Section>,
}

/// A claim, what was measured, and whether they agree.
pub struct Section {
    /// Short and without blanks: the name of the place on the page.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// What is claimed.
    pub claim: String,
    /// What was measured.
    pub measured: String,
    /// Whether they agree.
    pub verdict: Verdict,
    /// Pictures, tables and words below.
    pub blocks: Vec<Block>,
}

/// What stands below a section's words.
pub enum Block {
    /// A picture's `<svg>` element.
    Picture(String),
    /// A table.
    Table(Table),
    /// A paragraph.
    Text(String),
}

/// A table of texts, the first column to the left and the others to the right.
pub struct Table {
    /// A cell for each column.
    pub header: Vec<String>,
    /// The cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// Whether a claim agrees with what was measured.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Verdict {
    /// It does.
    Holds,
    /// Within limits that are told.
    HoldsInPart,
    /// It does not.
    DoesNotHold,
}

impl Verdict {
    /// The verdict in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::HoldsInPart => "holds in part",
            Self::DoesNotHold => "does not hold",
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Holds => "yes",
            Self::HoldsInPart => "part",
            Self::DoesNotHold => "no",
        }
    }
}

impl From<&Picture> for Block {
    fn from(picture: &Picture) -> Self {
        Self::Picture(picture.svg.clone())
    }
}

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 60rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { font-size: 1.25rem; margin-top: 2.5rem; border-top: 1px solid #ddd; padding-top: 1rem; }
a { color: #00629b; }
.sides { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: .75rem; margin: 1rem 0; }
.sides > div { border: 1px solid #ddd; border-radius: .4rem; padding: .6rem .8rem; }
.sides h3 { font-size: .8rem; text-transform: uppercase; letter-spacing: .05em; color: #555; margin: 0 0 .3rem; }
.sides p { margin: 0; }
.verdict { font-weight: 600; } .yes { color: #006b4b; } .part { color: #8a5a00; } .no { color: #b02a00; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: .9rem; }
th, td { text-align: right; padding: .2rem .6rem; border-bottom: 1px solid #e5e5e5; white-space: nowrap; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; overflow-x: auto; } svg { display: block; width: 100%; min-width: 28rem; max-width: 42rem; height: auto; } rect { shape-rendering: crispEdges; }
.contents td { white-space: normal; }
";

impl Page {
    /// The whole page.
    pub fn html(&self) -> String {
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
            escape(&self.title)
        );
        for paragraph in &self.intro {
            push(&mut html, format_args!("<p>{}</p>\n", escape(paragraph)));
        }
        html += &self.contents();
        for section in &self.sections {
            html += &section.html();
        }
        html + "</body>\n</html>\n"
    }

    /// All verdicts at a glance.
    fn contents(&self) -> String {
        let mut html = String::from("<table class=\"contents\">\n");
        for Section { id, title, verdict, .. } in &self.sections {
            let (title, class, text) = (escape(title), verdict.class(), verdict.text());
            let row = format_args!(
                "<tr><td><a href=\"#{id}\">{title}</a></td><td class=\"verdict {class}\">{text}</td></tr>\n"
            );
            push(&mut html, row);
        }
        html + "</table>\n"
    }
}

impl Section {
    fn html(&self) -> String {
        let Self { id, title, claim, measured, verdict, blocks } = self;
        let mut html = format!(
            "<section>\n<h2 id=\"{id}\">{}</h2>\n<div class=\"sides\">\n<div><h3>Claim</h3><p>{}</p></div>\n\
             <div><h3>Measured</h3><p>{}</p></div>\n\
             <div><h3>Verdict</h3><p class=\"verdict {}\">{}</p></div>\n</div>\n",
            escape(title),
            escape(claim),
            escape(measured),
            verdict.class(),
            verdict.text()
        );
        for block in blocks {
            match block {
                Block::Picture(svg) => html += &inline(svg),
                Block::Table(table) => html += &table.html(),
                Block::Text(text) => push(&mut html, format_args!("<p>{}</p>\n", escape(text))),
            }
        }
        html + "</section>\n"
    }
}

impl Table {
    /// `rows` have as many cells as the header.
    pub fn new<H: Into<String>>(header: impl IntoIterator<Item = H>, rows: Vec<Vec<String>>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows }
    }

    fn html(&self) -> String {
        let row = |cells: &[String], tag: &str| {
            let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let rows: String = self.rows.iter().map(|cells| row(cells, "td")).collect();
        format!("<div class=\"scroll\"><table>\n{}{rows}</table></div>\n", row(&self.header, "th"))
    }
}

/// A picture as it stands in a page: the element alone, which takes its size from the page.
fn inline(svg: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    format!("<figure>{}</figure>\n", &svg[start..])
}

fn push(html: &mut String, text: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = html.write_fmt(text);
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
