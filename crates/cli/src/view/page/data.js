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
const CELLS = 40;
const MANY = 16000;

class Data {
  constructor(view, buffer) {
    this.view = view;
    this.floats = new Float32Array(buffer);
    const words = new Uint32Array(buffer);
    // Coarse forms come after all else.
    const coarse = view.stage.meshes.map(mesh => this.coarsened(words, mesh));
    this.words = new Uint32Array(words.length + coarse.reduce((sum, { length }) => sum + length, 0));
    this.words.set(words);
    this.floats = new Float32Array(this.words.buffer);
    let end = words.length;
    this.coarse = new Map();
    view.stage.meshes.forEach(({ triangles }, i) => {
      if (!coarse[i].length) return;
      this.words.set(coarse[i], end);
      this.coarse.set(triangles[0], [end, coarse[i].length]);
      end += coarse[i].length;
    });
  }

  // The triangles of a large mesh between corners that stand for all others in the same cell of a grid.
  coarsened(words, { vertices, triangles }) {
    const [start, count] = this.range(triangles);
    if (count < 3 * MANY) return [];
    const [first, length] = this.range(vertices);
    const points = this.floats.subarray(first, first + length);
    const reach = points.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
    const cell = value => Math.min(Math.floor((value / reach + 1) * CELLS / 2), CELLS - 1);
    const chosen = new Int32Array(CELLS ** 3).fill(-1);
    const stands = new Uint32Array(length / 3);
    for (let i = 0; i < length; i += 3) {
      const key = cell(points[i]) + CELLS * (cell(points[i + 1]) + CELLS * cell(points[i + 2]));
      if (chosen[key] < 0) chosen[key] = i / 3;
      stands[i / 3] = chosen[key];
    }
    const kept = [];
    for (let i = start; i < start + count; i += 3) {
      const [p, q, r] = [stands[words[i]], stands[words[i + 1]], stands[words[i + 2]]];
      if (p !== q && q !== r && r !== p) kept.push(p, q, r);
    }
    return kept;
  }

  // Where the corners of triangles begin, and how many there are: of a coarse form, if there is one, while the picture moves.
  corners(triangles, moves) {
    return moves && this.coarse.get(triangles[0]) || this.range(triangles);
  }

  // Where a range `[array, start, count]` begins, and how many words it has.
  range([array, start, count]) {
    return [this.view.stage.starts[array] + start, count];
  }

  // Twelve numbers: the rows of [R|t].
  pose(number) {
    const [start] = this.range(this.view.stage.poses);
    return this.floats.subarray(start + 12 * number, start + 12 * number + 12);
  }
}
