// A robot: a slider for each joint, and where its links are for the values of the sliders.

// The product of two poses, twelve numbers each: the rows of [R|t].
function within(outer, inner) {
  return Float64Array.from({ length: 12 }, (_, i) => {
    const [row, column] = [4 * Math.floor(i / 4), i % 4];
    const turned = outer[row] * inner[column] + outer[row + 1] * inner[4 + column] + outer[row + 2] * inner[8 + column];
    return column === 3 ? turned + outer[row + 3] : turned;
  });
}

// What a joint does with its value, along or about its axis.
function motion(kind, [x, y, z], value) {
  const [c, s] = kind === "turn" ? [Math.cos(value), Math.sin(value)] : [1, 0];
  const d = 1 - c;
  const along = kind === "slide" ? value : 0;
  return [
    c + d * x * x, d * x * y - s * z, d * x * z + s * y, along * x,
    d * y * x + s * z, c + d * y * y, d * y * z - s * x, along * y,
    d * z * x - s * y, d * z * y + s * x, c + d * z * z, along * z,
  ];
}

class Robot {
  // `moved` is called when a slider was.
  constructor(data, moved) {
    Object.assign(this, data.view.robot);
    this.named = new Map(this.joints.map(joint => [joint.name, joint]));
    this.holders = new Map(this.joints.map(joint => [joint.child, joint]));
    this.values = new Map();
    const list = element("details", { id: "joints", open: true }, element("summary", { textContent: "Joints" }));
    byId("sliders").append(list);
    this.sliders = this.ranges.map(([name, min, max]) => {
      const input = element("input", { type: "range", min, max, step: "any", ariaLabel: name });
      const output = element("output");
      input.addEventListener("input", () => {
        this.set(name, Number(input.value));
        moved();
      });
      list.append(element("label", {}, element("span", { textContent: name }), output), input);
      return [name, input, output];
    });
  }

  // Brings the sliders to a configuration.
  show(configuration) {
    this.sliders.forEach(([name, input], i) => {
      input.value = configuration[i];
      this.set(name, configuration[i]);
    });
  }

  set(name, value) {
    this.values.set(name, value);
    const output = this.sliders.find(([other]) => other === name)[2];
    const turns = this.named.get(name).kind === "turn";
    output.textContent = turns ? `${(value * 180 / Math.PI).toFixed(1)}°` : `${value.toFixed(3)} m`;
  }

  // The value of a joint, or of the one that it follows.
  value({ name, kind, mimic }) {
    if (kind === "fixed") return 0;
    if (!mimic) return this.values.get(name);
    const [other, multiplier, offset] = mimic;
    return multiplier * this.value(this.named.get(other)) + offset;
  }

  // The poses of all shapes of links, in their order.
  poses() {
    const places = new Map();
    const place = link => {
      if (!places.has(link)) {
        const joint = this.holders.get(link);
        const [x, y, z] = this.origin;
        places.set(link, !joint ? [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z]
          : within(within(place(joint.parent), joint.origin), motion(joint.kind, joint.axis, this.value(joint))));
      }
      return places.get(link);
    };
    return this.shapes.map(([link, pose]) => within(place(link), pose));
  }
}
