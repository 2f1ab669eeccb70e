// The frame of a living figure: it takes the place of the picture of its figure, and owns the
// state (what the reader sets), the numbers (what the page computes), controls and outputs.

const builders = {};

// build(living) adds panels, controls and outputs, and returns the function that computes the
// numbers from the state and draws them.
function widget(name, build) { builders[name] = build; }

function begin() {
  for (const root of document.querySelectorAll("[data-widget]")) {
    const name = root.dataset.widget;
    const living = new Living(root, JSON.parse(document.getElementById("widget-" + name).textContent));
    living.start(builders[name](living));
  }
}

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

class Living {
  constructor(root, data) {
    this.root = root;
    this.data = data;
    this.state = {};
    this.numbers = {};
    this.outputs = [];
    this.shown = [];   // functions that bring a control up to the state
    this.panels = element("div", { class: "panels" });
    this.controls = element("div", { class: "controls" });
    this.results = element("dl", { class: "results" });
    this.bar = element("div", { class: "bar" });
    this.box = element("div", { class: "living" }, this.panels, this.controls, this.results, this.bar);
  }

  start(update) {
    this.update = update;
    this.initial = structuredClone(this.state);
    this.button("Reset", () => { Object.assign(this.state, structuredClone(this.initial)); });
    this.bar.append(this.printedFigure());
    const picture = this.root.querySelector(".picture");
    picture.closest("figure").prepend(this.box);
    const lead = this.root.querySelector(".lead");
    lead.hidden = false;
    this.box.prepend(lead);
    this.root.classList.add("is-living");
    this.root.widget = this;
    // Computed when the reader comes near, so that the page opens at once.
    const observer = new IntersectionObserver(entries => {
      if (!entries.some(entry => entry.isIntersecting)) return;
      observer.disconnect();
      this.changed();
    }, { rootMargin: "600px" });
    observer.observe(this.box);
  }

  printedFigure() {
    const button = element("button", { type: "button", "aria-pressed": "false" }, "Printed figure");
    button.addEventListener("click", () => {
      const printed = this.root.classList.toggle("is-printed");
      button.setAttribute("aria-pressed", printed);
    });
    return button;
  }

  // Several changes before the next frame are computed once.
  changed() {
    if (this.frame) return;
    this.frame = requestAnimationFrame(() => this.refresh());
  }

  refresh() {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.numbers = this.update(this.state, this.data);
    for (const show of this.shown) show();
    for (const [output, text, kind] of this.outputs) {
      const now = text(this.numbers, this.state);
      if (output.textContent !== now) output.textContent = now;
      if (typeof kind === "function") output.parentElement.className = kind(this.numbers);
    }
  }

  set(changes) {
    Object.assign(this.state, changes);
    this.changed();
  }

  // text(value) is shown beside the label; value(position) makes the value of a slider.
  slider(key, { label, least, most, step = 1, at, value = x => x, text = String }) {
    const position = key + "At";
    this.state[position] = at;
    this.state[key] = value(at);
    const input = element("input", { type: "range", min: least, max: most, step, "data-key": key });
    const shown = element("output");
    this.controls.append(element("label", {}, element("span", {}, label + " ", shown), input));
    input.addEventListener("input", () =>
      this.set({ [position]: Number(input.value), [key]: value(Number(input.value)) }));
    this.shown.push(() => {
      input.value = this.state[position];
      shown.textContent = text(this.state[key]);
      input.setAttribute("aria-valuetext", text(this.state[key]));
    });
    return input;
  }

  choice(key, { label, options, at }) {
    this.state[key] = at;
    const name = `${this.root.dataset.widget}-${key}`;
    const group = element("fieldset", {}, element("legend", {}, label));
    for (const [value, text] of options) {
      const input = element("input", { type: "radio", name, "data-key": key, "data-value": value });
      input.addEventListener("change", () => this.set({ [key]: value }));
      this.shown.push(() => { input.checked = this.state[key] === value; });
      group.append(element("label", {}, input, element("span", {}, text)));
    }
    this.controls.append(group);
  }

  button(label, action) {
    const made = element("button", { type: "button", class: label === "Reset" ? "" : "own" }, label);
    made.addEventListener("click", () => { action(); this.changed(); });
    this.bar.append(made);
    return made;
  }

  // A button that moves a slider through its positions, once per period in milliseconds.
  player(slider, period) {
    const button = element("button", { type: "button", class: "play" }, "Play");
    let timer = 0;
    const stop = () => { clearInterval(timer); timer = 0; button.textContent = "Play"; };
    const step = () => {
      if (Number(slider.value) >= Number(slider.max)) return stop();
      slider.stepUp();
      slider.dispatchEvent(new Event("input"));
    };
    button.addEventListener("click", () => {
      if (timer) return stop();
      if (Number(slider.value) >= Number(slider.max)) slider.value = slider.min;
      timer = setInterval(step, period);
      button.textContent = "Pause";
    });
    this.bar.append(button);
  }

  // `label` is a text, or a list of texts and elements; `kind` a class, or a function of the numbers
  // that returns one, so that only a bad number has the colour of a warning.
  output(label, text, kind = "") {
    const output = element("dd", { "aria-live": "polite" });
    this.outputs.push([output, text, kind]);
    this.results.append(element("div", { class: typeof kind === "function" ? "" : kind },
      element("dt", {}, ...[label].flat()), output));
  }
}

// Numbers as the report prints them.
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function power(exponent) {
  return "10" + [...String(exponent)].map(c => c === "-" ? "⁻" : RAISED[c]).join("");
}

function digits(x, count = 3) {
  if (!Number.isFinite(x)) return "undefined";
  const [mantissa, exponent] = x.toExponential(count - 1).split("e");
  const plain = Math.abs(exponent) < 4 || x === 0;
  const text = plain ? x.toPrecision(count) : `${mantissa} × ${power(Number(exponent))}`;
  return text.replace("-", "−");
}

function number(x) { return String(x).replace("-", "−"); }

function fixed(x, decimals = 3) { return x.toFixed(decimals).replace(/^-(?=0\.?0*$)/, "").replace("-",
  "−"); }

// An error that rounding decides has no digits, only a size.
function order(x) { return x === 0 ? "0" : Number.isFinite(x)
  ? power(Math.round(Math.log10(Math.abs(x)))) : "undefined"; }

function measured(x) { return Math.abs(x) < 1e-12 ? order(x) : digits(x); }

// Integers of 8 and of 16 bits from base64.
function bytes(text) { return Uint8Array.from(atob(text), c => c.charCodeAt(0)); }

function shorts(text) {
  const b = bytes(text);
  return Array.from({ length: b.length / 2 }, (_, i) => b[2 * i] + 256 * b[2 * i + 1]);
}
