// Draws the same picture without WebGL: triangle by triangle, into an array of pixels with a depth each.

class SoftwarePainter {
  // Edges are smooth when nothing moves: four pixels for one.
  finer = 2;

  constructor(canvas, data) {
    Object.assign(this, { canvas, data, context: canvas.getContext("2d") });
  }

  draw(picture) {
    const { width, height } = this.canvas;
    if (this.image?.width !== width || this.image.height !== height) {
      this.image = this.context.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      this.depth = new Float32Array(width * height);
    }
    this.depth.fill(Infinity);
    this.pixels.fill(packed(picture.ground));
    for (const pass of passes(picture)) {
      this.pass = pass;
      for (const surface of pass.surfaces) this.surface(surface, picture);
      for (const line of pass.lines) this.line(line, picture);
    }
    this.context.putImageData(this.image, 0, 0);
  }

  // Nothing is left to do when a picture is drawn.
  wait() {}

  // Pixels across and down, and the depth, of points `[x, y, z]`.
  project(clip, points) {
    const { width, height } = this.canvas;
    const placed = new Float32Array(points.length);
    for (let i = 0; i < points.length; i += 3) {
      const x = points[i], y = points[i + 1], z = points[i + 2];
      const w = clip[3] * x + clip[7] * y + clip[11] * z + clip[15];
      // What is behind the eye is nowhere.
      const scale = w > 1e-5 ? 0.5 / w : NaN;
      placed[i] = (0.5 + scale * (clip[0] * x + clip[4] * y + clip[8] * z + clip[12])) * width;
      placed[i + 1] = (0.5 - scale * (clip[1] * x + clip[5] * y + clip[9] * z + clip[13])) * height;
      placed[i + 2] = scale * (clip[2] * x + clip[6] * y + clip[10] * z + clip[14]);
    }
    return placed;
  }

  plot(i, z, color) {
    const { depth, pixels, pass } = this;
    if (pass.hidden ? z <= depth[i] : z > depth[i]) return;
    if (pass.solid) depth[i] = z;
    pixels[i] = this.alpha === 1 ? color : blended(color, pixels[i], this.alpha);
  }

  surface(part, picture) {
    const { data } = this;
    const { color, glow, pose, rank, alpha } = part;
    this.alpha = alpha * this.pass.alpha;
    const [[first, length], [start, count]] = data.form(part, picture.moves);
    const eye = product(picture.eye, placement(pose));
    const points = data.floats.subarray(first, first + length);
    const placed = this.project(product(picture.lens, eye), points);
    const beyond = picture.cut === UNCUT || glow ? undefined : this.beyond(picture.cut, eye, points);
    const shades = Uint32Array.from({ length: 65 }, (_, i) => packed(color.map(value => value * (0.35 + 0.65 * i / 64))));
    for (let i = start; i < start + count; i += 3) {
      const [a, b, c] = [3 * data.words[i], 3 * data.words[i + 1], 3 * data.words[i + 2]];
      const shade = shades[glow ? 64 : Math.round(64 * facing(eye, points, a, b, c))];
      this.triangle(placed, a, b, c, shade, rank, beyond);
    }
  }

  // How far points lie beyond a plane, over their depths: so it changes evenly on the screen. In steps of three, as points.
  beyond(cut, eye, points) {
    const values = new Float32Array(points.length);
    for (let i = 0; i < points.length; i += 3) {
      const at = row => eye[row] * points[i] + eye[4 + row] * points[i + 1] + eye[8 + row] * points[i + 2] + eye[12 + row];
      const z = at(2);
      values[i] = (cut[0] * at(0) + cut[1] * at(1) + cut[2] * z + cut[3]) / -z;
    }
    return values;
  }

  triangle(p, a, b, c, shade, rank, beyond) {
    const { width, height } = this.canvas;
    const ax = p[a], ay = p[a + 1], az = p[a + 2];
    const bx = p[b] - ax, by = p[b + 1] - ay, bz = p[b + 2] - az;
    const cx = p[c] - ax, cy = p[c + 1] - ay, cz = p[c + 2] - az;
    const area = bx * cy - by * cx;
    if (!(Math.abs(area) > 1e-9)) return;
    const top = Math.max(0, Math.ceil(ay + Math.min(0, by, cy) - 0.5));
    const bottom = Math.min(height - 1, Math.floor(ay + Math.max(0, by, cy) - 0.5));
    const left = Math.max(0, Math.ceil(ax + Math.min(0, bx, cx) - 0.5));
    const right = Math.min(width - 1, Math.floor(ax + Math.max(0, bx, cx) - 0.5));
    // A point is the first corner, u times the way to the second, and v times that to the third; both change evenly in a row.
    const stepU = cy / area, stepV = -by / area, dx = left + 0.5 - ax;
    const slope = Math.abs(bz * stepU + cz * stepV) + Math.abs((cz * bx - bz * cx) / area);
    const near = az + rank * (RANK.slopes * slope + RANK.steps / 2 ** 24);
    const k = beyond ? beyond[a] : -1, kb = beyond ? beyond[b] - k : 0, kc = beyond ? beyond[c] - k : 0;
    for (let y = top; y <= bottom; y++) {
      const dy = y + 0.5 - ay;
      let u = (dx * cy - dy * cx) / area, v = (bx * dy - by * dx) / area;
      for (let i = y * width + left, end = y * width + right; i <= end; i++, u += stepU, v += stepV) {
        if (u < 0 || v < 0 || u + v > 1 || k + u * kb + v * kc > 0) continue;
        this.plot(i, near + u * bz + v * cz, shade);
      }
    }
  }

  line({ color, width, box, range, alpha }, picture) {
    const { data } = this;
    this.alpha = alpha * this.pass.alpha;
    const [start, count] = data.range(range);
    const clip = product(picture.lens, picture.eye);
    const shade = packed(color), wide = Math.round(width * picture.scale);
    for (let i = start; i < start + count; i += 6) {
      const points = box ? edges(data.floats.subarray(i, i + 6)) : data.floats.subarray(i, i + 6);
      const placed = this.project(clip, inSight(clip, points));
      for (let k = 0; k < placed.length; k += 6) this.segment(placed, k, wide, shade);
    }
  }

  // Row by row, or column by column, whichever it crosses more of: so each pixel is drawn once, also where it is seen through.
  segment(p, i, wide, shade) {
    const { width, height } = this.canvas;
    const long = Math.abs(p[i + 4] - p[i + 1]) > Math.abs(p[i + 3] - p[i]) ? 1 : 0;
    const [start, end, aside, turn] = [p[i + long], p[i + 3 + long], p[i + 1 - long], p[i + 4 - long] - p[i + 1 - long]];
    const [size, reach] = long ? [height, width] : [width, height];
    const first = Math.max(0, Math.round(Math.min(start, end) - wide / 2));
    const last = Math.min(size, Math.round(Math.max(start, end) + wide / 2));
    for (let at = first; at < last; at++) {
      const s = end === start ? 0 : Math.min(Math.max((at + 0.5 - start) / (end - start), 0), 1);
      const from = Math.round(aside + s * turn - wide / 2);
      for (let k = Math.max(0, from); k < Math.min(reach, from + wide); k++) {
        this.plot(long ? at * width + k : k * width + at, p[i + 2] + s * (p[i + 5] - p[i + 2]) - 1e-4, shade);
      }
    }
  }
}

// How much a triangle of these points faces the eye, from 0 to 1.
function facing(eye, p, a, b, c) {
  const x = p[a], y = p[a + 1], z = p[a + 2];
  const ux = p[b] - x, uy = p[b + 1] - y, uz = p[b + 2] - z;
  const vx = p[c] - x, vy = p[c + 1] - y, vz = p[c + 2] - z;
  const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  const long = Math.sqrt(nx * nx + ny * ny + nz * nz);
  return long > 0 ? Math.abs(eye[2] * nx + eye[6] * ny + eye[10] * nz) / long : 0;
}

// Segments, six numbers each, without what of them is behind the eye.
function inSight(clip, segments) {
  const near = 1e-3;
  const ahead = i => clip[3] * segments[i] + clip[7] * segments[i + 1] + clip[11] * segments[i + 2] + clip[15] - near;
  const seen = Float32Array.from(segments);
  for (let i = 0; i < segments.length; i += 6) {
    const ends = [ahead(i), ahead(i + 3)];
    if (Math.max(...ends) < 0 || Math.min(...ends) >= 0) continue;
    const [out, within] = ends[0] < 0 ? [i, i + 3] : [i + 3, i];
    const share = Math.max(...ends) / (Math.max(...ends) - Math.min(...ends));
    for (let k = 0; k < 3; k++) seen[out + k] = segments[within + k] + share * (segments[out + k] - segments[within + k]);
  }
  return seen;
}

// The twelve edges of a box, six numbers each.
function edges(box) {
  const corner = i => [box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]];
  const all = [];
  for (let i = 0; i < 8; i++) {
    for (const bit of [1, 2, 4]) if (!(i & bit)) all.push(...corner(i), ...corner(i | bit));
  }
  return all;
}

// A colour as the four bytes of a pixel.
function packed(color) {
  const [r, g, b] = color.map(value => Math.round(255 * value));
  return (255 << 24 | b << 16 | g << 8 | r) >>> 0;
}

function blended(over, under, alpha) {
  let mixed = 0xff000000;
  for (const shift of [0, 8, 16]) {
    mixed |= Math.round(alpha * (over >>> shift & 255) + (1 - alpha) * (under >>> shift & 255)) << shift;
  }
  return mixed >>> 0;
}
