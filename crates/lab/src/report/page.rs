//! One HTML page with its pictures inside: no script, no other file, readable on a telephone and on paper.

use punctual_view::{document, escape};

/// A page of sections.
pub struct Page {
    /// Its heading.
    pub title: String,
    /// Paragraphs.
    pub intro: Vec<String>,
    /// What comes after them, with a table of contents in front.
    pub sections: Vec<Section>,
}

/// What was measured, and what for.
#[derive(Clone)]
pub struct Section {
    /// Short and without blanks: the name of the place on the page.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// What the section is about.
    pub lead: Lead,
    /// What was measured.
    pub measured: String,
    /// Pictures, tables and words below.
    pub blocks: Vec<Block>,
}

impl Section {
    /// A section that shows something, without a claim.
    pub fn shows(
        id: &str,
        title: &str,
        what: impl Into<String>,
        measured: impl Into<String>,
        blocks: Vec<Block>,
    ) -> Self {
        Self {
            id: id.to_owned(),
            title: title.to_owned(),
            lead: Lead::Shows(what.into()),
            measured: measured.into(),
            blocks,
        }
    }

    /// A section about a claim.
    pub fn claims(
        id: &str,
        title: &str,
        (claim, verdict): (impl Into<String>, Verdict),
        measured: impl Into<String>,
        blocks: Vec<Block>,
    ) -> Self {
        let lead = Lead::Claim(claim.into(), verdict);
        Self {
            lead,
            ..Self::shows(id, title, "", measured, blocks)
        }
    }
}

/// What a section begins with.
#[derive(Clone)]
pub enum Lead {
    /// A claim, and whether it agrees with what was measured.
    Claim(String, Verdict),
    /// What is shown, where nothing is claimed.
    Shows(String),
}

/// What stands below a section's words.
#[derive(Clone)]
pub enum Block {
    /// A picture's `<svg>` element.
    Picture(String),
    /// A table.
    Table(Table),
    /// A paragraph.
    Text(String),
    /// A line that unfolds into more.
    Details(String, Vec<Block>),
}

/// A table of texts, the first column to the left and the others to the right.
#[derive(Clone)]
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

impl From<bool> for Verdict {
    fn from(holds: bool) -> Self {
        if holds {
            Self::Holds
        } else {
            Self::DoesNotHold
        }
    }
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

impl Page {
    /// The whole page.
    pub fn html(&self) -> String {
        let mut html = format!("<h1>{}</h1>\n", escape(&self.title));
        html.extend(
            self.intro
                .iter()
                .map(|text| format!("<p>{}</p>\n", escape(text))),
        );
        html += &self.contents();
        for section in &self.sections {
            html += &section.html();
        }
        document(&self.title, "", &html)
    }

    /// The sections, with the verdicts on what is claimed.
    fn contents(&self) -> String {
        let mut html = String::from("<table class=\"contents\">\n");
        for section in &self.sections {
            let (class, text) = match section.lead {
                Lead::Claim(_, verdict) => (verdict.class(), verdict.text()),
                Lead::Shows(_) => ("", ""),
            };
            let (id, title) = (&section.id, escape(&section.title));
            html += &format!(
                "<tr><td><a href=\"#{id}\">{title}</a></td><td class=\"verdict {class}\">{text}</td></tr>\n"
            );
        }
        html + "</table>\n"
    }
}

impl Section {
    fn html(&self) -> String {
        let Self {
            id,
            title,
            lead,
            measured,
            blocks,
        } = self;
        let side = |name: &str, class: &str, text: &str| {
            format!(
                "<div><h3>{name}</h3><p class=\"{class}\">{}</p></div>\n",
                escape(text)
            )
        };
        let measured = side("Measured", "", measured);
        let sides = match lead {
            Lead::Claim(claim, verdict) => {
                let verdict = side(
                    "Verdict",
                    &format!("verdict {}", verdict.class()),
                    verdict.text(),
                );
                side("Claim", "", claim) + &measured + &verdict
            }
            Lead::Shows(what) => side("Shown", "", what) + &measured,
        };
        let title = escape(title);
        let blocks: String = blocks.iter().map(Block::html).collect();
        format!(
            "<section>\n<h2 id=\"{id}\">{title}</h2>\n<div class=\"sides\">\n{sides}</div>\n{blocks}</section>\n"
        )
    }
}

impl Block {
    fn html(&self) -> String {
        match self {
            Self::Picture(svg) => inline(svg),
            Self::Table(table) => table.html(),
            Self::Text(text) => format!("<p>{}</p>\n", escape(text)),
            Self::Details(summary, blocks) => {
                let blocks: String = blocks.iter().map(Self::html).collect();
                format!(
                    "<details><summary>{}</summary>\n{blocks}</details>\n",
                    escape(summary)
                )
            }
        }
    }
}

impl Table {
    /// `rows` have as many cells as the header.
    pub fn new<H: Into<String>>(
        header: impl IntoIterator<Item = H>,
        rows: Vec<Vec<String>>,
    ) -> Self {
        Self {
            header: header.into_iter().map(Into::into).collect(),
            rows,
        }
    }

    fn html(&self) -> String {
        let row = |cells: &[String], tag: &str| {
            let cells = cells
                .iter()
                .map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let rows: String = self.rows.iter().map(|cells| row(cells, "td")).collect();
        format!(
            "<div class=\"scroll\"><table>\n{}{rows}</table></div>\n",
            row(&self.header, "th")
        )
    }
}

/// A picture as it stands in a page: the element alone, which takes its size from the page.
fn inline(svg: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    format!("<figure>{}</figure>\n", &svg[start..])
}
