// From where the picture is seen. All that is shown lies in the unit ball; matrices are column by column, as WebGL has them.

const FIELD_OF_VIEW = 0.6;

class Camera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance = 1 / Math.sin(FIELD_OF_VIEW / 2);
    // The rows are the directions to the right, up and towards the eye.
    this.axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    this.turn(0.6, 0.45);
  }

  // Turns what is seen, by angles to the right and down.
  turn(right, down) {
    const [c, s, d, e] = [Math.cos(right), Math.sin(right), Math.cos(down), Math.sin(down)];
    const [x, y, z] = this.axes;
    const mix = (p, u, q, v) => p.map((value, i) => u * value + v * q[i]);
    const [side, front] = [mix(x, c, z, s), mix(z, c, x, -s)];
    this.axes = orthonormal([side, mix(y, d, front, -e), mix(front, d, y, e)]);
  }

  // Moves what is seen along the screen; 1 is the height of the picture.
  move(right, up) {
    const scale = 2 * Math.tan(FIELD_OF_VIEW / 2) * this.distance;
    const [x, y] = this.axes;
    this.target = this.target.map((value, i) => value - scale * (right * x[i] + up * y[i]));
  }

  approach(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 1e-4), 50);
  }

  // Brings a ball into sight.
  lookAt(center, radius) {
    this.target = [...center];
    this.distance = Math.max(2.5 * radius, 0.08) / Math.sin(FIELD_OF_VIEW / 2);
  }

  // From the page's coordinates to those of the eye, which looks along -z.
  eye() {
    const [x, y, z] = this.axes;
    const shift = axis => -axis.reduce((sum, value, i) => sum + value * this.target[i], 0);
    return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, shift(x), shift(y), shift(z) - this.distance, 1];
  }

  // From those of the eye to clip space. On a tall picture the field of view is that of its width.
  lens(aspect) {
    const f = Math.min(1, aspect) / Math.tan(FIELD_OF_VIEW / 2);
    const offset = Math.hypot(...this.target);
    const far = this.distance + offset + 2;
    const near = Math.max(this.distance - offset - 2, 0.02 * this.distance);
    const depth = 1 / (near - far);
    return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * depth, -1, 0, 0, 2 * near * far * depth, 0];
  }
}

function orthonormal([x, y]) {
  const scaled = v => v.map(value => value / Math.hypot(...v));
  const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const right = scaled(x);
  const toward = scaled(cross(right, y));
  return [right, cross(toward, right), toward];
}

function product(m, n) {
  const entry = i => [0, 1, 2, 3].reduce((sum, k) => sum + m[4 * k + i % 4] * n[4 * (i >> 2) + k], 0);
  return Array.from({ length: 16 }, (_, i) => entry(i));
}

// A pose of twelve numbers as a matrix.
function placement(p) {
  return [p[0], p[4], p[8], 0, p[1], p[5], p[9], 0, p[2], p[6], p[10], 0, p[3], p[7], p[11], 1];
}
