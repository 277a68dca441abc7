//! Draws bodies as an SVG file: all faces towards the viewer, the farthest first.

use std::cmp::Ordering;
use std::fmt::Write;

use punctual::glam::{DMat3, DVec3};
use punctual_scene::Body;

/// Pixels of a unit of length, and of a panel.
const SCALE: f64 = 50.0;
const WIDTH: f64 = 370.0;
const HEIGHT: f64 = 370.0;

/// Panels side by side, a moment each.
#[derive(Default)]
pub struct Picture {
    panels: Vec<String>,
}

impl Picture {
    /// Adds a panel, seen from the front, the right and above; of the bin only the floor.
    pub fn add<'b>(&mut self, bodies: impl Iterator<Item = &'b Body>, caption: &str) {
        let turn = DMat3::from_rotation_x(-1.2) * DMat3::from_rotation_z(-0.5);
        let mut faces = Vec::new();
        let is_drawn = |&(i, _): &(usize, _)| i == 0 || i >= crate::FIXED;
        for (i, Body { tree, pose, .. }) in bodies.enumerate().filter(is_drawn) {
            let mesh = tree.mesh();
            for triangle in 0..mesh.len() {
                let corners = mesh
                    .triangle(triangle)
                    .map(|p| turn * pose.transform_point(p));
                let normal = (corners[1] - corners[0])
                    .cross(corners[2] - corners[0])
                    .normalize_or_zero();
                if normal.z > 0.0 {
                    let light = 0.35 + 0.6 * normal.dot(DVec3::new(-0.4, 0.7, 0.6)).max(0.0);
                    let depth = (corners[0] + corners[1] + corners[2]).z;
                    faces.push((
                        (i > 0, (turn * pose.translation()).z, depth),
                        corners,
                        color(i, light),
                    ));
                }
            }
        }
        // The floor first, then body by body.
        faces.sort_by(|(x, ..), (y, ..)| x.partial_cmp(y).unwrap_or(Ordering::Equal));
        let mut panel = String::new();
        for (_, corners, color) in faces {
            let [p, q, r] = corners.map(|p| {
                format!(
                    "{:.0},{:.0}",
                    0.5 * WIDTH + SCALE * p.x,
                    0.68 * HEIGHT - SCALE * p.y
                )
            });
            writeln!(panel, "<path color=\"{color}\" d=\"M{p} {q} {r}z\"/>")
                .expect("room in memory");
        }
        writeln!(
            panel,
            "<text x=\"{}\" y=\"{}\">{caption}</text>",
            0.5 * WIDTH,
            HEIGHT - 10.0
        )
        .expect("room in memory");
        self.panels.push(panel);
    }

    pub fn svg(&self) -> String {
        let whole = WIDTH * self.panels.len() as f64;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {whole} {HEIGHT}\" font-family=\"sans-serif\" \
             font-size=\"34\" text-anchor=\"middle\"><style>path {{ fill: currentColor; stroke: currentColor }} \
             .back {{ fill: #fff }} text {{ fill: #1f2328 }} @media (prefers-color-scheme: dark) \
             {{ .back {{ fill: #0d1117 }} text {{ fill: #f0f6fc }} }}</style>\n\
             <rect class=\"back\" width=\"{whole}\" height=\"{HEIGHT}\"/>\n"
        );
        for (i, panel) in self.panels.iter().enumerate() {
            svg += &format!(
                "<g transform=\"translate({} 0)\">\n{panel}</g>\n",
                WIDTH * i as f64
            );
        }
        svg + "</svg>\n"
    }
}

/// The floor is grey; all others have different hues.
fn color(body: usize, light: f64) -> String {
    let hue = 137.5 * body as f64;
    let channel = |shift: f64| {
        let share = if body == 0 {
            0.85
        } else {
            0.62 + 0.33 * (hue + shift).to_radians().cos()
        };
        (255.0 * light * share) as u8
    };
    format!(
        "#{:02x}{:02x}{:02x}",
        channel(0.0),
        channel(120.0),
        channel(240.0)
    )
}
