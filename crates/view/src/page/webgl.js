// Draws a picture with WebGL 2. All arrays are in one buffer, twice: as numbers, and as indices of corners.

const SURFACE = [`#version 300 es
uniform mat4 place, lens;
in vec3 position;
out vec3 at;
void main() {
  vec4 seen = place * vec4(position, 1);
  at = seen.xyz;
  gl_Position = lens * seen;
}`, `#version 300 es
precision highp float;
uniform vec4 color;
uniform vec4 cut;
uniform float glow;
in vec3 at;
out vec4 shade;
void main() {
  if (dot(cut.xyz, at) + cut.w > 0.0) discard;
  // Facets, lit from the eye.
  vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
  float light = mix(0.35 + 0.65 * abs(normal.z), 1.0, glow);
  shade = vec4(color.rgb * light * color.a, color.a);
}`];

// A segment becomes a strip of so many pixels; a box becomes its twelve edges, six corners each.
const LINE = [`#version 300 es
uniform mat4 clip;
uniform vec2 screen;
uniform float width;
uniform bool box;
in vec3 from, to;
vec3 corner(int i) { return mix(from, to, vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1)); }
void main() {
  vec4 p = clip * vec4(from, 1), q = clip * vec4(to, 1);
  if (box) {
    int edge = gl_VertexID / 6, axis = edge >> 2;
    int low = (edge & 1) << (axis == 0 ? 1 : 0) | (edge >> 1 & 1) << (axis == 2 ? 1 : 2);
    p = clip * vec4(corner(low), 1);
    q = clip * vec4(corner(low | 1 << axis), 1);
  }
  const float NEAR = 1e-5;
  if (p.w < NEAR) p = mix(p, q, (NEAR - p.w) / max(q.w - p.w, NEAR));
  if (q.w < NEAR) q = mix(q, p, (NEAR - q.w) / max(p.w - q.w, NEAR));
  vec2 along = (q.xy / q.w - p.xy / p.w) * screen;
  along = length(along) > 1e-3 ? normalize(along) : vec2(1, 0);
  int i = gl_VertexID % 6;
  bool far = i == 1 || i == 4 || i == 5, left = i == 2 || i == 3 || i == 5;
  gl_Position = far ? q : p;
  gl_Position.xy += ((far ? along : -along) + (left ? 1.0 : -1.0) * vec2(-along.y, along.x)) * width / screen * gl_Position.w;
  gl_Position.z -= 2e-4 * gl_Position.w;
}`, `#version 300 es
precision highp float;
uniform vec4 color;
out vec4 shade;
void main() { shade = vec4(color.rgb * color.a, color.a); }`];

class WebGlPainter {
  finer = 1;

  constructor(canvas, data) {
    const gl = canvas.getContext("webgl2");
    if (!gl) throw new Error("No WebGL 2 in this browser: edges are rough in motion.");
    if (isEmulated(gl) && location.hash !== "#webgl") {
      throw new Error("No graphics processor here: edges are rough in motion.");
    }
    Object.assign(this, { gl, canvas, data });
    this.surface = this.program(...SURFACE);
    this.line = this.program(...LINE);
    for (const target of [gl.ARRAY_BUFFER, gl.ELEMENT_ARRAY_BUFFER]) {
      gl.bindBuffer(target, gl.createBuffer());
      gl.bufferData(target, data.words, gl.STATIC_DRAW);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
  }

  program(...sources) {
    const { gl } = this;
    const program = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, sources[i]);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error("The WebGL of this browser does not take our program: drawn without it.");
    }
    const found = { program };
    for (let i = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i--;) {
      const { name } = gl.getActiveUniform(program, i);
      found[name] = gl.getUniformLocation(program, name);
    }
    for (const name of ["position", "from", "to"]) found[name] = gl.getAttribLocation(program, name);
    return found;
  }

  draw(picture) {
    const { gl, canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...picture.ground, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const pass of passes(picture)) {
      gl.depthMask(pass.solid);
      gl.depthFunc(pass.hidden ? gl.GREATER : gl.LEQUAL);
      this.surfaces(pass, picture);
      this.lines(pass, picture);
    }
  }

  // Returns when all is drawn.
  wait() {
    const { gl } = this;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  surfaces(pass, picture) {
    const { gl, data, surface } = this;
    gl.useProgram(surface.program);
    gl.uniformMatrix4fv(surface.lens, false, picture.lens);
    gl.enableVertexAttribArray(surface.position);
    gl.vertexAttribDivisor(surface.position, 0);
    for (const part of pass.surfaces) {
      const { color, glow, pose, alpha, rank } = part;
      const [[points], [start, count]] = data.form(part, picture.moves);
      gl.polygonOffset(rank * RANK.slopes, rank * RANK.steps);
      gl.uniformMatrix4fv(surface.place, false, product(picture.eye, placement(pose)));
      gl.uniform4f(surface.color, ...color, alpha * pass.alpha);
      gl.uniform4f(surface.cut, ...(glow ? UNCUT : picture.cut));
      gl.uniform1f(surface.glow, glow);
      gl.vertexAttribPointer(surface.position, 3, gl.FLOAT, false, 12, 4 * points);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * start);
    }
    gl.disableVertexAttribArray(surface.position);
  }

  lines(pass, picture) {
    const { gl, data, canvas, line } = this;
    gl.useProgram(line.program);
    gl.uniformMatrix4fv(line.clip, false, product(picture.lens, picture.eye));
    gl.uniform2f(line.screen, canvas.width, canvas.height);
    for (const { color, width, box, range, alpha } of pass.lines) {
      const [start, count] = data.range(range);
      gl.uniform4f(line.color, ...color, alpha * pass.alpha);
      gl.uniform1f(line.width, width * picture.scale);
      gl.uniform1i(line.box, box);
      [line.from, line.to].forEach((place, i) => {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribDivisor(place, 1);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, 4 * start + 12 * i);
      });
      gl.drawArraysInstanced(gl.TRIANGLES, 0, box ? 72 : 6, count / 6);
    }
    for (const place of [line.from, line.to]) gl.disableVertexAttribArray(place);
  }
}

// Where the main processor does the work of a graphics processor, the other painter is three times as fast.
function isEmulated(gl) {
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  return /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER));
}

// Surfaces that lie in the same place are drawn as if one were a little farther away, by its rank: so many times what the depth
// changes from pixel to pixel, and so many steps of a depth of 24 bits, each more than rounding moves it.
const RANK = { slopes: 0.05, steps: 4 };
// A plane (a normal and a shift, as the eye sees them) beyond which there is nothing.
const UNCUT = [0, 0, 0, -1];

// What is drawn one after the other: solid things, what is seen through, and, faintly, what lies behind.
function passes({ surfaces, lines }) {
  const [solid, ghosts] = [true, false].map(solid => surfaces.filter(({ alpha }) => (alpha === 1) === solid));
  const [boxes, others] = [true, false].map(box => lines.filter(line => line.box === box));
  return [
    { surfaces: solid, lines: others, alpha: 1, solid: true },
    { surfaces: ghosts, lines: [], alpha: 1 },
    { surfaces: [], lines: boxes, alpha: 0.7 },
    { surfaces: solid.filter(surface => surface.glow), lines: others.filter(line => line.shines), alpha: 0.35, hidden: true },
    { surfaces: [], lines: boxes, alpha: 0.12, hidden: true },
  ];
}
