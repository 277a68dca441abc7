// Of a scene, the lists of pairs that meet and of pairs of which that is not known; of a robot, the first.

// Pairs that are listed; a body that is picked has the list for itself.
const MOST_LISTED = 100;

class Pairs {
  constructor(data, chosen) {
    Object.assign(this, { data, chosen });
    this.lists = ["Meeting", "Not known"].map(name => {
      const [title, items] = [element("summary"), element("ul")];
      const list = element("details", {}, title, items);
      byId("pairs").append(list);
      list.addEventListener("toggle", () => this.fill());
      return { name, list, title, items };
    });
  }

  // Lists those of a step, only those of one body if one is picked.
  show(step, picked) {
    this.ranges = step.pairs;
    this.picked = picked;
    this.fill();
  }

  fill() {
    const { names } = this.data.view;
    this.lists.forEach(({ name, list, title, items }, i) => {
      list.hidden = !this.ranges[i];
      if (list.hidden) return;
      const all = this.pairs(i);
      title.textContent = `${name}${this.picked === undefined ? "" : `, of ${names[this.picked]}`}: ${all.length}`;
      // Long lists take time, and most are not looked at.
      if (!list.open) return;
      const line = pair => {
        const button = element("button", { textContent: pair.map(body => names[body]).join(" and ") });
        button.addEventListener("click", () => this.chosen(pair));
        return element("li", {}, button);
      };
      const rest = all.length - MOST_LISTED;
      items.replaceChildren(...all.slice(0, MOST_LISTED).map(line));
      if (rest > 0) items.append(element("li", { textContent: `and ${rest} more: click on a body to see its own` }));
    });
  }

  pairs(list) {
    const [start, count] = this.data.range(this.ranges[list]);
    const pairs = [];
    for (let i = start; i < start + count; i += 2) pairs.push([this.data.words[i], this.data.words[i + 1]]);
    return this.picked === undefined ? pairs : pairs.filter(pair => pair.includes(this.picked));
  }
}
