//! The page: what is shown, packed, between a style and a program of our own.

use std::io::{self, Write};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};

use crate::document::{document, escape};
use crate::ladder::BUDGET;
use crate::stage::Stage;
use crate::{Bodies, Up};

/// Its parts, in the order in which they follow one another.
const PROGRAM: [&str; 9] = [
    include_str!("page/data.js"),
    include_str!("page/camera.js"),
    include_str!("page/controls.js"),
    include_str!("page/pick.js"),
    include_str!("page/pairs.js"),
    include_str!("page/robot.js"),
    include_str!("page/webgl.js"),
    include_str!("page/software.js"),
    include_str!("page/main.js"),
];

/// What a page shows.
pub struct View {
    pub(crate) title: String,
    /// Layers that things are drawn in, and what they are.
    pub(crate) key: Vec<(&'static str, String)>,
    pub(crate) stage: Stage,
    pub(crate) steps: Vec<Value>,
    /// The step that is shown first.
    pub(crate) start: usize,
    /// What the steps are steps of.
    pub(crate) slider: &'static str,
    /// The poses of a body that moves, at equal steps of time.
    pub(crate) times: Option<Vec<usize>>,
    /// Of a scene, what its bodies are called.
    pub(crate) names: Option<Vec<String>>,
    /// Of a robot, its joints and shapes.
    pub(crate) robot: Option<Value>,
    pub(crate) up: Up,
}

impl View {
    /// The steps of a query of these bodies, with the one that is shown first; `layers` come after A and B.
    pub(crate) fn of_query(
        what: &str,
        bodies: &Bodies,
        layers: &[(&'static str, &str)],
        stage: Stage,
        (steps, start): (Vec<Value>, usize),
    ) -> Self {
        let layers = layers.iter().map(|&(layer, text)| (layer, text.to_owned()));
        let (title, key) = (
            bodies.title(what),
            bodies.key().into_iter().chain(layers).collect(),
        );
        Self {
            title,
            key,
            stage,
            steps,
            start,
            slider: BUDGET,
            times: None,
            names: None,
            robot: None,
            up: Up::Guess,
        }
    }

    /// Which way is up in the picture, [`Up::Guess`] without this.
    #[must_use]
    pub fn up(self, up: Up) -> Self {
        Self { up, ..self }
    }

    /// The page, which needs no other file and no network.
    ///
    /// # Errors
    /// If its texts alone take 4 GB.
    pub fn html(&self) -> io::Result<String> {
        let body = include_str!("page/body.html")
            .replace("<!--title-->", &escape(&self.title))
            .replace("<!--data-->", &BASE64_STANDARD.encode(self.packed()?))
            .replace("<!--program-->", &PROGRAM.concat());
        Ok(document(&self.title, include_str!("page/view.css"), &body))
    }

    /// Deflated: the length of a JSON text, that text, and the arrays that it names, all in words of 32 bits, little-endian.
    fn packed(&self) -> io::Result<Vec<u8>> {
        let Self {
            key,
            stage,
            steps,
            start,
            slider,
            times,
            names,
            robot,
            up,
            ..
        } = self;
        let mut text = json!({
            "key": key, "stage": stage.describe(), "steps": steps, "start": start, "slider": slider, "times": times,
            "names": names, "robot": robot, "up": up.axis(stage.up),
        })
        .to_string();
        // So that the arrays are aligned.
        text += &" ".repeat(text.len().wrapping_neg() % 4);
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
        let length = u32::try_from(text.len()).map_err(io::Error::other)?;
        packer.write_all(&length.to_le_bytes())?;
        packer.write_all(text.as_bytes())?;
        packer.write_all(&stage.arrays.bytes().collect::<Vec<u8>>())?;
        packer.finish()
    }
}
