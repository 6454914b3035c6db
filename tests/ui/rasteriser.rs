//! Draws what egui tessellates into an image on the processor: no display, no graphics card, the same bytes each time.

use std::collections::HashMap;

use egui::epaint::{Primitive, Vertex};
use egui::{Context, FullOutput, ImageData, Rect, TextureId, TexturesDelta};
use egui_kittest::TestRenderer;
use image::{Rgba, RgbaImage};

/// A texture, premultiplied.
struct Texture {
    size: [usize; 2],
    pixels: Vec<[f32; 4]>,
}

impl Texture {
    /// Colour at texture coordinates within 0 and 1, bilinear, clamped at the edges.
    fn sample(&self, u: f32, v: f32) -> [f32; 4] {
        let place = |at: f32, size: usize| {
            let at = (at * size as f32 - 0.5).clamp(0.0, (size - 1) as f32);
            (at as usize, (at as usize + 1).min(size - 1), at.fract())
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (place(u, self.size[0]), place(v, self.size[1]));
        let pixel = |x: usize, y: usize| self.pixels[y * self.size[0] + x];
        let corners = [pixel(x0, y0), pixel(x1, y0), pixel(x0, y1), pixel(x1, y1)];
        std::array::from_fn(|c| {
            let top = corners[0][c] + (corners[1][c] - corners[0][c]) * fx;
            let bottom = corners[2][c] + (corners[3][c] - corners[2][c]) * fx;
            top + (bottom - top) * fy
        })
    }
}

/// The renderer.
#[derive(Default)]
pub struct Rasteriser {
    textures: HashMap<TextureId, Texture>,
}

impl TestRenderer for Rasteriser {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let delta = std::mem::take(delta);
        for (id, changes) in &delta.set {
            for change in changes {
                let ImageData::Color(image) = &change.image;
                let pixels = image.pixels.iter().map(|pixel| pixel.to_array().map(f32::from));
                let Some([left, top]) = change.pos else {
                    self.textures.insert(*id, Texture { size: image.size, pixels: pixels.collect() });
                    continue;
                };
                let texture = self.textures.get_mut(id).expect("a patch follows its texture");
                for (at, pixel) in pixels.enumerate() {
                    let (x, y) = (left + at % image.size[0], top + at / image.size[0]);
                    texture.pixels[y * texture.size[0] + x] = pixel;
                }
            }
        }
        for id in &delta.free {
            self.textures.remove(id);
        }
        let mut done = delta;
        done.clear();
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let points_to_pixels = output.pixels_per_point;
        let size = ctx.content_rect().size() * points_to_pixels;
        let mut canvas = Canvas { width: size.x.round() as usize, height: size.y.round() as usize, pixels: Vec::new() };
        canvas.pixels = vec![[0.0, 0.0, 0.0, 255.0]; canvas.width * canvas.height];
        for piece in ctx.tessellate(output.shapes.clone(), points_to_pixels) {
            let Primitive::Mesh(mesh) = &piece.primitive else { continue };
            let texture = self.textures.get(&mesh.texture_id).ok_or("a mesh without its texture")?;
            let clip = piece.clip_rect * points_to_pixels;
            for corners in mesh.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|at| mesh.vertices[corners[at] as usize]);
                canvas.triangle(corners, texture, clip, points_to_pixels);
            }
        }
        let bytes = canvas.pixels.iter().flat_map(|pixel| pixel.map(|c| c.round().clamp(0.0, 255.0) as u8)).collect();
        RgbaImage::from_raw(canvas.width as u32, canvas.height as u32, bytes).ok_or_else(|| "empty image".to_owned())
    }
}

/// The image being drawn, premultiplied, opaque.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 4]>,
}

impl Canvas {
    /// Blends one triangle over what is there.
    fn triangle(&mut self, corners: [Vertex; 3], texture: &Texture, clip: Rect, scale: f32) {
        let [a, b, c] = corners.map(|corner| corner.pos.to_vec2() * scale);
        let area = (b - a).x * (c - a).y - (b - a).y * (c - a).x;
        if area == 0.0 {
            return;
        }
        let bound = |low: f32, high: f32, size: usize| {
            ((low - 0.5).ceil().max(0.0) as usize, ((high - 0.5).ceil().max(0.0) as usize).min(size))
        };
        let (left, right) =
            bound(a.x.min(b.x).min(c.x).max(clip.left()), a.x.max(b.x).max(c.x).min(clip.right()), self.width);
        let (top, bottom) =
            bound(a.y.min(b.y).min(c.y).max(clip.top()), a.y.max(b.y).max(c.y).min(clip.bottom()), self.height);
        for y in top..bottom {
            for x in left..right {
                let at = egui::vec2(x as f32 + 0.5, y as f32 + 0.5);
                let edge = |p: egui::Vec2, q: egui::Vec2| ((q - p).x * (at - p).y - (q - p).y * (at - p).x) / area;
                let weights = [edge(b, c), edge(c, a), edge(a, b)];
                // A pixel on an edge shared by two triangles belongs to the one the edge is the top or left side of.
                let owned = |weight: f32, p: egui::Vec2, q: egui::Vec2| {
                    let way = (q - p) * area.signum();
                    weight > 0.0 || (weight == 0.0 && (way.y < 0.0 || (way.y == 0.0 && way.x > 0.0)))
                };
                if !(owned(weights[0], b, c) && owned(weights[1], c, a) && owned(weights[2], a, b)) {
                    continue;
                }
                let mix = |of: &dyn Fn(&Vertex) -> f32| -> f32 { (0..3).map(|k| weights[k] * of(&corners[k])).sum() };
                let texel = texture.sample(mix(&|corner| corner.uv.x), mix(&|corner| corner.uv.y));
                let source: [f32; 4] =
                    std::array::from_fn(|k| mix(&|corner| f32::from(corner.color.to_array()[k])) * texel[k] / 255.0);
                let pixel = &mut self.pixels[y * self.width + x];
                *pixel = std::array::from_fn(|k| source[k] + pixel[k] * (1.0 - source[3] / 255.0));
            }
        }
    }
}

/// Whether `image` holds a pixel of about this colour.
pub fn holds_color(image: &RgbaImage, color: egui::Color32, tolerance: u8) -> bool {
    let Rgba([red, green, blue, _]) = Rgba(color.to_array());
    let near = |a: u8, b: u8| a.abs_diff(b) <= tolerance;
    image.pixels().any(|pixel| near(pixel[0], red) && near(pixel[1], green) && near(pixel[2], blue))
}
