// The page: sliders and switches say what is shown, a painter draws it when something changed.

const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};
const byId = id => document.getElementById(id);

// Layers drawn as lines, with their widths in pixels; of the others, those that are seen through.
const WIDTHS = { near: 3, normal: 1.5, met: 3, box: 1, open: 1.5, grid: 1 };
const LINES = ["near", "normal", "box", "open", "grid"];
const GHOSTS = { start: 0.3, touch: 0.3, fixed: 0.3 };
const GRID = 0.5;
// Most difference of poses, at which a body that is seen through would only be a stain on the one that moves.
const SAME = 0.02;
const AXES = ["x", "y", "z"];
// Layers of two bodies, and the least distance from which one of them is looked at.
const BODIES = ["a", "b"];
const TINY = 1e-3;
// Milliseconds for a picture, from which on it is slow.
const SLOW = 25;
// Milliseconds for a step that is played, and for all of few steps.
const PLAY = { step: 50, all: 5000 };

class Page {
  constructor(data) {
    this.data = data;
    this.canvas = document.querySelector("canvas");
    this.camera = new Camera(data.view.stage.bounds, data.view.up[0]);
    this.hidden = new Set();
    this.picked = [];
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
    this.addUp();
    this.addButtons();
    if (data.view.robot) this.robot = new Robot(data, () => this.pose());
    if (data.view.names) this.pairs = new Pairs(data, pair => this.lookAtPair(pair));
    control(this.canvas, this.camera, () => this.changed(true), (x, y) => this.pickAt(x, y));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.changed());
    new ResizeObserver(() => this.changed()).observe(this.canvas);
    this.show(data.view.start);
  }

  addSliders() {
    const { steps, start, times, slider } = this.data.view;
    this.budget = this.addSlider(slider, steps.length - 1, start, value => this.show(value));
    this.played = this.budget;
    if (!times) return;
    this.marks = element("p", { className: "marks" });
    this.time = this.addSlider("Time", times.length - 1, 0, value => {
      this.moveTo(value / (times.length - 1), times[value]);
    });
    this.played = this.time;
    byId("sliders").append(this.marks);
  }

  addSlider(name, max, value, moved) {
    const input = element("input", { type: "range", min: 0, max });
    input.value = value;
    const output = element("output");
    const button = element("button", { className: "play", disabled: max === 0 });
    const slider = { name, input, output, button, moved };
    this.stop(slider);
    input.addEventListener("input", () => {
      this.stop(slider);
      moved(Number(input.value));
    });
    button.addEventListener("click", () => this.play(slider));
    byId("sliders").append(element("label", {}, name, input), element("div", { className: "row" }, button, output));
    return slider;
  }

  // Goes through the steps of a slider to its end, or stops if it does so.
  play(slider) {
    if (slider.playing) return this.stop(slider);
    const { input, button, moved } = slider;
    const last = Number(input.max);
    const pace = Math.max(PLAY.step, PLAY.all / last);
    const first = Number(input.value) < last ? Number(input.value) : 0;
    const begin = performance.now();
    Object.assign(button, { textContent: "Stop", ariaLabel: `Stop: ${slider.name}` });
    const next = now => {
      const step = Math.min(first + Math.max(0, Math.floor((now - begin) / pace)), last);
      if (step !== Number(input.value)) {
        input.value = step;
        moved(step);
      }
      if (step === last) this.stop(slider);
      else slider.playing = requestAnimationFrame(next);
    };
    slider.playing = requestAnimationFrame(next);
  }

  stop(slider) {
    cancelAnimationFrame(slider.playing);
    slider.playing = undefined;
    Object.assign(slider.button, { textContent: "Play", ariaLabel: `Play: ${slider.name}` });
  }

  addKey() {
    this.grid = element("span");
    for (const [layer, text] of [...this.data.view.key, ["grid", this.grid]]) {
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

  addUp() {
    const [axis, why] = this.data.view.up;
    const buttons = [...byId("up").querySelectorAll("button")];
    this.stand = up => {
      this.camera.stand(up);
      this.grid.textContent = `ground, squares of ${this.data.view.stage.grids[up][0]}`;
      byId("up").querySelector("small").textContent = up === axis ? why : "";
      buttons.forEach((button, i) => button.ariaPressed = i === up);
      this.changed();
    };
    buttons.forEach((button, up) => button.addEventListener("click", () => this.stand(up)));
    this.stand(axis);
  }

  addButtons() {
    byId("whole").addEventListener("click", () => {
      this.camera.showWhole();
      this.changed();
    });
    byId("found").addEventListener("click", () => {
      this.camera.lookAt(...(this.step.focus ?? this.step.open));
      this.changed();
    });
    const { key, names } = this.data.view;
    for (const [layer, text] of key.filter(([layer]) => !names && BODIES.includes(layer))) {
      const button = Object.assign(byId(layer), { hidden: false, ariaLabel: text });
      button.addEventListener("click", () => this.lookAtBody(layer));
    }
    for (const id of ["opacity", "side", "cut"]) byId(id).addEventListener("input", () => this.changed(true));
    document.addEventListener("keydown", event => {
      const { key, target } = event;
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const up = AXES.indexOf(key);
      if (key === "0") byId("whole").click();
      else if (key === "f") byId("found").click();
      else if (BODIES.includes(key)) byId(key).click();
      else if (key === "Escape") this.pick([]);
      // A list of choices takes letters for itself, and what can be pressed takes the space.
      else if (up >= 0 && !target.matches?.("select")) this.stand(up);
      else if (key === " " && !target.matches?.("button, summary, select, [type=checkbox]")) this.played.button.click();
      else return;
      event.preventDefault();
    });
  }

  // Shows what was known after a step.
  show(number) {
    const step = this.data.view.steps[number];
    this.robot?.show(step.values);
    this.tell(step);
  }

  // Shows a robot where its joints were moved by hand. Nothing is known there.
  pose() {
    const poses = this.robot.poses();
    const surfaces = this.step.surfaces.map(([, mesh, pose, triangles], i) =>
      i < poses.length ? ["unasked", mesh, poses[i], triangles] : ["fixed", mesh, pose, triangles]);
    const facts = [["Clearance", "not asked"], ["Pairs that meet", "not asked"]];
    this.tell({ name: "moved by hand", facts, surfaces });
  }

  tell(step) {
    this.step = step;
    const { name, facts, remarks, focus, open, marks } = step;
    this.budget.output.textContent = name;
    this.budget.input.setAttribute("aria-valuetext", name);
    const told = new Map(remarks);
    byId("facts").replaceChildren(...facts.map(([name, value]) => {
      const remark = told.has(name) ? [" ", element("small", { textContent: told.get(name) })] : [];
      return element("tr", {}, element("td", {}, name), element("td", {}, value, ...remark));
    }));
    Object.assign(byId("found"), { disabled: !(focus ?? open), textContent: open ? "What is open" : "What was found" });
    if (marks) {
      this.marks.replaceChildren(...marks.flatMap(([text, time, pose]) => {
        const button = element("button", { textContent: text });
        button.addEventListener("click", () => this.moveTo(time, pose));
        return [button, " "];
      }));
      const [, time, pose] = marks[1];
      this.moveTo(time, pose);
    }
    // Bodies of a scene stay what they are.
    this.pick(this.data.view.names ? this.picked : []);
    this.changed(true);
  }

  // Brings the body that moves to where it is at a time.
  moveTo(time, pose) {
    this.moving = pose;
    this.time.input.value = time * this.time.input.max;
    this.time.output.textContent = `${time.toFixed(4)} of the motion`;
    this.changed(true);
  }

  // Names what is seen at a place of the window.
  pickAt(x, y) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const sight = this.camera.sight(2 * (x - left) / width - 1, 1 - 2 * (y - top) / height, width / height);
    const [normal, end] = this.plane();
    const bodies = this.things().surfaces.filter(surface => !surface.glow);
    const found = pick(this.data, bodies, ...sight, point => dot(normal, point) <= end);
    this.pick(found ? [{ body: found.surface.body, at: found.at, triangle: found.triangle }] : []);
  }

  pick(picked) {
    this.picked = picked;
    byId("pairs").hidden = !this.step.pairs;
    if (this.step.pairs) this.pairs.show(this.step, picked.length === 1 ? picked[0].body : undefined);
    this.changed();
  }

  // Brings one of two bodies into sight, however small it is.
  lookAtBody(body) {
    const [layer, mesh, pose] = this.step.surfaces.find(([layer]) => layer === body);
    const moves = layer === "b" && this.data.view.times;
    this.camera.lookAt(...this.data.ball([layer, mesh, moves ? this.moving : pose]), TINY);
    this.changed();
  }

  // Brings two bodies into sight.
  lookAtPair(pair) {
    this.picked = pair.map(body => ({ body, at: [0, 0, 0] }));
    const balls = pair.map(body => this.data.ball(this.step.surfaces[body]));
    const apart = Math.hypot(...minus(balls[0][0], balls[1][0]));
    this.camera.lookAt(balls[0][0].map((value, i) => 0.5 * (value + balls[1][0][i])), 0.5 * apart + Math.max(balls[0][1], balls[1][1]));
    this.changed();
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
    const aspect = width / height;
    camera.fit(aspect);
    const picture = { ...this.things(), eye: camera.eye(), lens: camera.lens(aspect), scale, cut: this.cut() };
    picture.moves = this.moves && this.slow;
    this.painter.draw(picture);
    this.placeLabels(product(picture.lens, picture.eye));
    this.drawAxes();
    canvas.dataset.drawn = performance.now();
  }

  // A plane beyond which bodies are cut away: its normal, towards the eye, and how far it lies along that.
  plane() {
    const { camera } = this;
    const share = byId("cut").value / 100;
    if (share === 0) return [[0, 0, 0], 1];
    const towards = camera.axes[2];
    const axis = byId("side").value;
    const normal = axis === "" ? towards : [0, 1, 2].map(i => i === Number(axis) ? Math.sign(towards[i]) || 1 : 0);
    const reach = corners(camera.bounds).map(corner => dot(normal, corner));
    const [least, most] = [Math.min(...reach), Math.max(...reach)];
    return [normal, most - share * (most - least)];
  }

  // The same as the eye sees it.
  cut() {
    const [normal, end] = this.plane();
    if (normal.every(value => value === 0)) return UNCUT;
    const { axes, target, distance } = this.camera;
    const seen = axes.map(axis => dot(axis, normal));
    return [...seen, dot(normal, target) + seen[2] * distance - end];
  }

  // Surfaces and lines of the step, in the colours of the style.
  things() {
    const { stage, times, names } = this.data.view;
    const { surfaces, lines = [], boxes } = this.step;
    const style = getComputedStyle(document.documentElement);
    const color = layer => {
      const text = style.getPropertyValue(`--${layer}`).trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
      return [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255);
    };
    const seen = ([layer]) => !this.hidden.has(layer);
    const strokes = [["grid", stage.grids[this.camera.up][1]], ...(boxes ? [["box", boxes]] : []), ...lines];
    const opacity = byId("opacity").value / 100;
    const chosen = names ? this.picked.map(({ body }) => body) : [];
    const surface = ([layer, mesh, pose, triangles], body) => {
      const glow = layer === "met" || layer === "sunk";
      const alpha = glow ? 1 : opacity * (GHOSTS[layer] ?? 1);
      return {
        body,
        layer,
        glow,
        alpha,
        color: color(chosen.includes(body) ? "picked" : layer),
        // What was found is nearer than what it lies in, and what is seen through is farther.
        rank: glow ? -4 : body % 64 + (GHOSTS[layer] ? 64 : 0),
        vertices: stage.meshes[mesh].vertices,
        triangles,
        pose: this.data.pose(layer === "b" && times ? this.moving : pose),
      };
    };
    const shown = surfaces.map(surface).filter(({ layer }) => seen([layer]));
    const moving = times && shown.find(({ layer }) => layer === "b");
    const isStain = ({ layer, pose }) => moving && layer in GHOSTS && pose.every((value, i) => Math.abs(value - moving.pose[i]) < SAME);
    return {
      ground: color("ground"),
      surfaces: shown.filter(surface => !isStain(surface)),
      lines: strokes.filter(seen).map(([layer, range]) => ({
        color: color(layer), width: WIDTHS[layer], box: layer === "box", range,
        alpha: layer === "grid" ? GRID : 1, shines: layer !== "grid",
      })),
    };
  }

  // Texts in the picture: that of the step, and the names of bodies that are picked.
  placeLabels(clip) {
    const { names, key } = this.data.view;
    const { label, surfaces } = this.step;
    const things = this.picked.length ? this.things().surfaces : [];
    const name = ({ body, triangle }) => {
      const text = names ? names[body] : new Map(key).get(surfaces[body][0]);
      if (triangle === undefined) return text;
      const { each, what } = this.data.view.stage.meshes[surfaces[body][1]];
      return `${text}, ${what} ${Math.floor(triangle / each)}`;
    };
    const picked = this.picked.flatMap(picked => {
      const surface = things.find(surface => surface.body === picked.body);
      return surface ? [[placed(surface.pose, picked.at), name(picked)]] : [];
    });
    const texts = [...(label ? [label] : []), ...picked].map(([point, text]) => {
      const [x, y, w] = [0, 1, 3].map(i => point.reduce((sum, value, k) => sum + clip[4 * k + i] * value, clip[12 + i]));
      return { text, ahead: w > 0, left: `${50 + 50 * x / w}%`, top: `max(2.4rem, ${50 - 50 * y / w}%)` };
    }).filter(({ ahead }) => ahead);
    const tags = byId("labels");
    while (tags.children.length > texts.length) tags.lastChild.remove();
    while (tags.children.length < texts.length) tags.append(element("output"));
    texts.forEach(({ text, left, top }, i) => {
      const tag = tags.children[i];
      // A text that is set is read aloud, also where it stays the same.
      if (tag.textContent !== text) tag.textContent = text;
      Object.assign(tag.style, { left, top });
    });
  }

  // The directions of the axes, in the corner; those away from the eye first.
  drawAxes() {
    const { axes } = this.camera;
    const ends = AXES.map((name, i) => ({ name, at: axes.map(axis => axis[i]) })).sort((p, q) => p.at[2] - q.at[2]);
    byId("axes").innerHTML = ends.map(({ name, at: [x, y] }) => `<g class="${name}"><line x2="${24 * x}" y2="${-24 * y}"/>`
      + `<text x="${33 * x}" y="${-33 * y}">${name}</text></g>`).join("");
  }
}

new Page(await unpack(byId("data").textContent));
