// The page: sliders and switches say what is shown, a painter draws it when something changed.

const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};
const byId = id => document.getElementById(id);

// Layers drawn as lines, with their widths in pixels; of the others, those that are seen through, and those that glow.
const WIDTHS = { near: 3, normal: 1.5, met: 3, box: 1 };
const LINES = ["near", "normal", "box"];
// Milliseconds for a picture, from which on it is slow.
const SLOW = 25;
const GHOSTS = ["start", "touch", "fixed"];

class Page {
  constructor(data) {
    this.data = data;
    this.canvas = document.querySelector("canvas");
    this.camera = new Camera();
    this.hidden = new Set();
    try {
      this.painter = new WebGlPainter(this.canvas, data);
    } catch (reason) {
      // A canvas that was asked for WebGL gives nothing else.
      const plain = this.canvas.cloneNode();
      this.canvas.replaceWith(plain);
      this.canvas = plain;
      this.painter = new SoftwarePainter(plain, data);
      Object.assign(byId("excuse"), { hidden: false, textContent: reason.message });
    }
    this.addSliders();
    this.addKey();
    this.addButtons();
    control(this.canvas, this.camera, () => this.changed(true));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.changed());
    new ResizeObserver(() => this.changed()).observe(this.canvas);
    this.show(data.view.start);
  }

  addSliders() {
    const { steps, start, times, slider } = this.data.view;
    this.budget = this.addSlider(slider, steps.length - 1, start, value => this.show(value));
    if (!times) return;
    this.marks = element("p", { className: "marks" });
    this.time = this.addSlider("Time", times.length - 1, 0, value => {
      this.moveTo(value / (times.length - 1), times[value]);
    });
    byId("sliders").append(this.marks);
  }

  addSlider(name, max, value, moved) {
    const input = element("input", { type: "range", min: 0, max });
    input.value = value;
    input.addEventListener("input", () => moved(Number(input.value)));
    const output = element("output");
    byId("sliders").append(element("label", {}, name, input), output);
    return { input, output };
  }

  addKey() {
    for (const [layer, text] of this.data.view.key) {
      const box = element("input", { type: "checkbox", checked: true });
      const sample = element("i", { className: LINES.includes(layer) ? "line" : "" });
      sample.style[LINES.includes(layer) ? "borderColor" : "background"] = `var(--${layer})`;
      box.addEventListener("change", () => {
        this.hidden[box.checked ? "delete" : "add"](layer);
        this.changed();
      });
      byId("key").append(element("label", {}, box, sample, text));
    }
  }

  addButtons() {
    const look = (center, radius) => {
      this.camera.lookAt(center, radius);
      this.changed();
    };
    byId("whole").addEventListener("click", () => look([0, 0, 0], 1));
    byId("found").addEventListener("click", () => look(...this.step.focus));
    this.canvas.addEventListener("keydown", ({ key }) => {
      if (key === "0") byId("whole").click();
      if (key === "f") byId("found").click();
    });
  }

  // Shows what was known after a step.
  show(number) {
    this.step = this.data.view.steps[number];
    const { name, facts, focus, marks } = this.step;
    this.budget.output.textContent = name;
    this.budget.input.setAttribute("aria-valuetext", name);
    byId("facts").replaceChildren(...facts.map(fact => element("tr", {}, ...fact.map(text => element("td", {}, text)))));
    byId("found").disabled = !focus;
    if (marks) {
      this.marks.replaceChildren(...marks.flatMap(([text, time, pose]) => {
        const button = element("button", { textContent: text });
        button.addEventListener("click", () => this.moveTo(time, pose));
        return [button, " "];
      }));
      const [, time, pose] = marks[1];
      this.moveTo(time, pose);
    }
    this.changed(true);
  }

  // Brings the body that moves to where it is at a time.
  moveTo(time, pose) {
    this.moving = pose;
    this.time.input.value = time * this.time.input.max;
    this.time.output.textContent = `${time.toFixed(4)} of the motion`;
    this.changed(true);
  }

  // Draws with the next frame of the screen, once for all that changes until then. Where that is slow, large meshes are coarse
  // while they move; at rest all is drawn in full.
  changed(moves = false) {
    this.moves = moves;
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = undefined;
      clearTimeout(this.rest);
      if (this.moves) this.rest = setTimeout(() => this.changed(), 150);
      const start = performance.now();
      this.draw();
      if (this.slow === undefined) {
        this.painter.wait();
        this.slow = performance.now() - start > SLOW;
      }
    });
  }

  draw() {
    const { canvas, camera } = this;
    const scale = window.devicePixelRatio * (this.moves ? 1 : this.painter.finer);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map(size => Math.max(1, Math.round(size * scale)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const picture = { ...this.things(), eye: camera.eye(), lens: camera.lens(width / height), scale };
    picture.moves = this.moves && this.slow;
    this.painter.draw(picture);
    this.placeLabel(product(picture.lens, picture.eye));
    canvas.dataset.drawn = performance.now();
  }

  // Surfaces and lines of the step, in the colours of the style.
  things() {
    const { stage, times } = this.data.view;
    const { surfaces, lines = [], boxes } = this.step;
    const style = getComputedStyle(document.documentElement);
    const color = layer => {
      const text = style.getPropertyValue(`--${layer}`).trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
      return [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255);
    };
    const seen = ([layer]) => !this.hidden.has(layer);
    const strokes = boxes ? [["box", boxes], ...lines] : lines;
    return {
      ground: color("ground"),
      surfaces: surfaces.filter(seen).map(([layer, mesh, pose, triangles]) => ({
        color: color(layer),
        glow: layer === "met",
        ghost: GHOSTS.includes(layer),
        vertices: stage.meshes[mesh].vertices,
        triangles,
        pose: this.data.pose(layer === "b" && times ? this.moving : pose),
      })),
      lines: strokes.filter(seen).map(([layer, range]) => ({
        color: color(layer), width: WIDTHS[layer], box: layer === "box", range,
      })),
    };
  }

  placeLabel(clip) {
    const { label } = this.step;
    const tag = byId("label");
    tag.hidden = !label;
    if (!label) return;
    const [x, y, w] = [0, 1, 3].map(i => label[0].reduce((sum, value, k) => sum + clip[4 * k + i] * value, clip[12 + i]));
    tag.hidden = w <= 0;
    tag.textContent = label[1];
    tag.style.left = `${50 + 50 * x / w}%`;
    tag.style.top = `${50 - 50 * y / w}%`;
  }
}

new Page(await unpack(byId("data").textContent));
