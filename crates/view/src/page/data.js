// What the page shows: a JSON text and the arrays that it names, packed together by `punctual`.

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const view = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return new Data(view, buffer.slice(4 + length));
}

// Cells across a mesh, and triangles from which on it has a coarse form.
const CELLS = 36;
const MANY = 16000;

class Data {
  constructor(view, buffer) {
    this.view = view;
    this.floats = new Float32Array(buffer);
    this.words = new Uint32Array(buffer);
    const packed = this.words;
    const forms = view.stage.meshes.map(mesh => this.coarsened(mesh));
    // They come after all else.
    this.coarse = new Map();
    let end = packed.length;
    this.words = new Uint32Array(forms.reduce((sum, { points, corners }) => sum + points.length + corners.length, end));
    this.floats = new Float32Array(this.words.buffer);
    this.words.set(packed);
    view.stage.meshes.forEach(({ triangles }, i) => {
      const { points, corners } = forms[i];
      if (!corners.length) return;
      this.floats.set(points, end);
      this.words.set(corners, end + points.length);
      this.coarse.set(triangles[0], [[end, points.length], [end + points.length, corners.length]]);
      end += points.length + corners.length;
    });
  }

  // A large mesh between points that stand for all others in the same cell of a grid.
  coarsened({ vertices, triangles }) {
    const { words, floats } = this;
    const [start, count] = this.range(triangles);
    const [points, corners] = [[], []];
    if (count < 3 * MANY) return { points, corners };
    const [first, length] = this.range(vertices);
    const reach = floats.subarray(first, first + length).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    const cell = value => Math.min(Math.floor((value / reach + 1) * CELLS / 2), CELLS - 1);
    const chosen = new Int32Array(CELLS ** 3).fill(-1);
    const stands = new Uint32Array(length / 3);
    for (let i = 0; i < length; i += 3) {
      const point = floats.subarray(first + i, first + i + 3);
      const key = cell(point[0]) + CELLS * (cell(point[1]) + CELLS * cell(point[2]));
      if (chosen[key] < 0) chosen[key] = points.push(...point) / 3 - 1;
      stands[i / 3] = chosen[key];
    }
    for (let i = start; i < start + count; i += 3) {
      const [p, q, r] = [stands[words[i]], stands[words[i + 1]], stands[words[i + 2]]];
      if (p !== q && q !== r && r !== p) corners.push(p, q, r);
    }
    return { points, corners };
  }

  // Where the points and the corners of a surface begin, and how many numbers they are: of a coarse form, if there is one,
  // while the picture moves.
  form({ vertices, triangles }, moves) {
    return moves && this.coarse.get(triangles[0]) || [this.range(vertices), this.range(triangles)];
  }

  // Where a range `[array, start, count]` begins, and how many words it has.
  range([array, start, count]) {
    return [this.view.stage.starts[array] + start, count];
  }

  // Twelve numbers, the rows of [R|t]: by their number, or themselves.
  pose(number) {
    if (typeof number !== "number") return number;
    const [start] = this.range(this.view.stage.poses);
    return this.floats.subarray(start + 12 * number, start + 12 * number + 12);
  }

  // The middle of a surface that is a whole mesh, and how far it reaches from there.
  ball([, mesh, pose]) {
    const [start, count] = this.range(this.view.stage.meshes[mesh].vertices);
    let reach = 0;
    for (let i = start; i < start + count; i += 3) reach = Math.max(reach, Math.hypot(...this.floats.subarray(i, i + 3)));
    return [[3, 7, 11].map(i => this.pose(pose)[i]), reach];
  }
}
