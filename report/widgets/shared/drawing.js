// Drawing: a panel of SVG with coordinates of its own, marks as text, and points that can be moved
// by mouse, finger or arrow keys.

const SVG = "http://www.w3.org/2000/svg";

function svgElement(tag, attributes = {}, parent = null) {
  const made = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (parent) parent.append(made);
  return made;
}

// A shift in pixels away from the origin, for a label whose baseline is below its middle.
function outward([x, y], pixels) {
  const size = Math.hypot(x, y);
  return [pixels * x / size, 5 - pixels * y / size];
}

class Panel {
  // x and y are the intervals that the panel shows; margin is [left, right, top, bottom].
  constructor(living, { x, y, label, width = 360, height = 300, margin = [8, 8, 8, 8],
    log = [false, false],
    parent = living.panels }) {
    Object.assign(this, { living, x, y, width, height, margin, log });
    this.svg = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "group",
      "aria-label": label });
    this.drawing = svgElement("g", { "aria-hidden": "true" }, this.svg);
    this.handles = svgElement("g", {}, this.svg);
    parent.append(this.svg);
  }

  static fraction(value, [from, to], log) {
    return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
  }

  px(x) {
    const [left, right] = this.margin;
    return left + Panel.fraction(x, this.x, this.log[0]) * (this.width - left - right);
  }

  py(y) {
    const [, , top, bottom] = this.margin;
    return this.height - bottom - Panel.fraction(y, this.y, this.log[1]) * (this.height - top - bottom);
  }

  at(p) { return `${this.px(p[0]).toFixed(2)},${this.py(p[1]).toFixed(2)}`; }

  draw(...marks) { this.drawing.innerHTML = marks.flat(Infinity).join(""); }

  path(points, look) { return `<polyline class="${look}" points="${points.map(p =>
    this.at(p)).join(" ")}"/>`; }

  area(points, look) { return `<polygon class="${look}" points="${points.map(p =>
    this.at(p)).join(" ")}"/>`; }

  line(a, b, look) { return this.path([a, b], look); }

  // A radius in units of the panel's x, or of pixels for a dot.
  circle(p, radius, look) {
    return this.dot(p, Math.abs(this.px(p[0] + radius) - this.px(p[0])), look);
  }

  dot(p, pixels, look) {
    const [x, y] = this.at(p).split(",");
    return `<circle class="${look}" cx="${x}" cy="${y}" r="${pixels.toFixed(2)}"/>`;
  }

  arrow(p, v, look) {
    const [x, y] = [this.px(p[0]), this.py(p[1])];
    const [u, w] = [this.px(p[0] + v[0]) - x, this.py(p[1] + v[1]) - y];
    const size = Math.hypot(u, w);
    if (size < 0.5) return this.dot(p, 2, look + " end");
    const head = Math.min(8, size) / size;
    const tip = [[-1, 0.45], [0, 0], [-1, -0.45]].map(([along, across]) =>
      [x + u + head * (along * u - across * w), y + w + head * (along * w + across * u)]);
    const pair = numbers => numbers.map(t => t.toFixed(2)).join(",");
    return `<path class="${look}" d="M${pair([x, y])}l${pair([u, w])}"/>` +
      `<polyline class="${look}" points="${tip.map(pair).join(" ")}"/>`;
  }

  text(p, words, look = "", [right, down] = [0, 0]) {
    return `<text class="${look}" x="${(this.px(p[0]) + right).toFixed(2)}" y="${(this.py(p[1]) +
      down).toFixed(2)}">${words}</text>`;
  }

  // Axes of a chart, with ticks at the given values.
  axes(xTicks, yTicks, { xLabel = "", yLabel = "", xText = number, yText = number } = {}) {
    const [left, right, top, bottom] = this.margin, [low, high] = [this.height - bottom, top];
    const marks = [`<path class="axis" d="M${left},${high}V${low}H${this.width - right}"/>`];
    for (const x of xTicks)
      marks.push(`<path class="grid" d="M${this.px(x).toFixed(2)},${low}V${high}"/>`,
        `<text class="tick middle" x="${this.px(x).toFixed(2)}" y="${low + 15}">${xText(x)}</text>`);
    for (const y of yTicks)
      marks.push(`<path class="grid" d="M${left},${this.py(y).toFixed(2)}H${this.width - right}"/>`,
        `<text class="tick last" x="${left - 6}" y="${(this.py(y) +
          4).toFixed(2)}">${yText(y)}</text>`);
    marks.push(`<text class="tick middle" x="${(left +
      this.width - right) / 2}" y="${this.height - 3}">${xLabel}</text>`,
      `<text class="tick" x="2" y="${high - 11}">${yLabel}</text>`);
    return marks;
  }

  fromEvent(event) {
    const box = this.svg.getBoundingClientRect(), [left, right, top, bottom] = this.margin;
    const x = (event.clientX - box.left) * this.width / box.width;
    const y = (event.clientY - box.top) * this.height / box.height;
    const between = ([from, to], part) => from + part * (to - from);
    return [between(this.x, (x - left) / (this.width - left - right)),
      between(this.y, (this.height - bottom - y) / (this.height - top - bottom))];
  }

  // A point at state[key], or at state[key][index]. move(p, old) returns the position it may take.
  handle(key, { label, index = null, look = "", radius = 8, move = p => p, step = 0.02,
    fine = step / 10 }) {
    const { living } = this;
    const read = () => index === null ? living.state[key] : living.state[key][index];
    const write = p => {
      const allowed = move(p, read());
      if (index === null) living.state[key] = allowed;
      else living.state[key] = living.state[key].map((q, i) => i === index ? allowed : q);
      living.changed();
    };
    const knob = svgElement("g", { class: "handle " + look, tabindex: 0, role: "button",
      "aria-roledescription": "movable point", "data-key": key, "data-index": index ?? "" },
        this.handles);
    svgElement("circle", { r: 22, class: "touch" }, knob);
    svgElement("circle", { r: radius, class: "knob" }, knob);
    const follow = event => write(this.fromEvent(event));
    knob.addEventListener("pointerdown", event => {
      knob.setPointerCapture(event.pointerId);
      knob.focus({ preventScroll: true });
      event.preventDefault();
    });
    // Otherwise a finger that moves a handle scrolls the page; `touch-action` does not apply within SVG.
    knob.addEventListener("touchstart", event => event.preventDefault(), { passive: false });
    knob.addEventListener("pointermove",
      event => { if (knob.hasPointerCapture(event.pointerId)) follow(event); });
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    knob.addEventListener("keydown", event => {
      const way = ways[event.key];
      if (!way || event.altKey || event.ctrlKey || event.metaKey) return;
      const by = event.shiftKey ? fine : step;
      write(read().map((x, k) => x + by * way[k]));
      event.preventDefault();
    });
    living.shown.push(() => {
      const p = read();
      knob.style.display = p ? "" : "none";   // a list may have become shorter
      if (!p) return;
      knob.setAttribute("transform", `translate(${this.at(p)})`);
      knob.setAttribute("aria-label",
        `${label}, x ${fixed(p[0], 2)}, y ${fixed(p[1], 2)}; arrow keys move it`);
    });
    return knob;
  }
}
