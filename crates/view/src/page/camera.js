// From where the picture is seen. All that is shown lies in the unit ball; matrices are column by column, as WebGL has them.

const FIELD_OF_VIEW = 0.6;

class Camera {
  // `bounds` are two corners of all that is shown.
  constructor(bounds, up) {
    this.bounds = bounds;
    this.stand(up);
  }

  // Brings an axis, 0 to 2, upright; all is in sight, from the front, the left and above.
  stand(up) {
    this.up = up;
    this.around = up === 1 ? -0.6 : -0.6 - Math.PI / 2;
    this.above = 0.45;
    this.turn(0, 0);
    this.showWhole();
  }

  // Brings all into sight with the next picture, and again when its sides change, until something else is looked at.
  showWhole() {
    this.fits = true;
    this.fitted = undefined;
  }

  // Turns what is seen, by angles to the right and down; up stays up.
  turn(right, down) {
    this.around -= right;
    this.above = Math.min(Math.max(this.above + down, -Math.PI / 2), Math.PI / 2);
    const [c, s, d, e] = [Math.cos(this.around), Math.sin(this.around), Math.cos(this.above), Math.sin(this.above)];
    const inOrder = (x, y, z) => {
      const axis = [];
      [x, y, z].forEach((value, i) => axis[(this.up + 1 + i) % 3] = value);
      return axis;
    };
    // The rows are the directions to the right, up and towards the eye.
    this.axes = [inOrder(-s, c, 0), inOrder(-c * e, -s * e, d), inOrder(c * d, s * d, e)];
  }

  // Moves what is seen along the screen; 1 is the height of the picture.
  move(right, up) {
    const scale = 2 * Math.tan(FIELD_OF_VIEW / 2) * this.distance;
    const [x, y] = this.axes;
    this.target = this.target.map((value, i) => value - scale * (right * x[i] + up * y[i]));
    this.fits = false;
  }

  approach(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 1e-4), 50);
    this.fits = false;
  }

  // Brings a ball into sight; a smaller one than `least` allows remains small.
  lookAt(center, radius, least = 0.08) {
    this.target = [...center];
    this.distance = Math.max(2.5 * radius, least) / Math.sin(FIELD_OF_VIEW / 2);
    this.fits = false;
  }

  // Prepares for a picture with this ratio of its sides; around all there is a little room.
  fit(aspect) {
    if (!this.fits || aspect === this.fitted) return;
    this.fitted = aspect;
    const [wide, high] = [Math.max(1, aspect), Math.max(1, 1 / aspect)].map(size => size * Math.tan(FIELD_OF_VIEW / 2));
    this.target = [0, 0, 0];
    this.distance = 1.06 * Math.max(...corners(this.bounds).map(corner => {
      const [x, y, z] = this.axes.map(axis => dot(axis, corner));
      return z + Math.max(Math.abs(x) / wide, Math.abs(y) / high);
    }), 1e-3);
  }

  // From the page's coordinates to those of the eye, which looks along -z.
  eye() {
    const [x, y, z] = this.axes;
    const shift = axis => -dot(axis, this.target);
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

  // Where a line of sight begins and whither it goes, through a place on the picture: from -1 to 1, to the right and up.
  sight(right, up, aspect) {
    const f = Math.min(1, aspect) / Math.tan(FIELD_OF_VIEW / 2);
    const mix = (x, y, z) => [0, 1, 2].map(i => x * this.axes[0][i] + y * this.axes[1][i] + z * this.axes[2][i]);
    const from = mix(0, 0, this.distance).map((value, i) => value + this.target[i]);
    return [from, mix(right * aspect / f, up / f, -1)];
  }
}

const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
const minus = (p, q) => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];

// The eight corners of a box.
function corners([low, high]) {
  return Array.from({ length: 8 }, (_, i) => [0, 1, 2].map(axis => (i >> axis & 1 ? high : low)[axis]));
}

function product(m, n) {
  const entry = i => [0, 1, 2, 3].reduce((sum, k) => sum + m[4 * k + i % 4] * n[4 * (i >> 2) + k], 0);
  return Array.from({ length: 16 }, (_, i) => entry(i));
}

// A pose of twelve numbers as a matrix.
function placement(p) {
  return [p[0], p[4], p[8], 0, p[1], p[5], p[9], 0, p[2], p[6], p[10], 0, p[3], p[7], p[11], 1];
}

// A point of a mesh, placed by a pose of twelve numbers.
function placed(p, point) {
  return [0, 4, 8].map(row => dot(p.subarray(row, row + 3), point) + p[row + 3]);
}
