// The elastic wing: equilibrium, and the iteration between flow and structure, against the pressure.
const TURNS = 40;

widget("elastic_wing", living => {
  const { pressure, span, sweeps } = living.data, names = Object.keys(sweeps).sort((a, b) => b - a);
  const wing = new Panel(living, { x: [0, 30], y: [-1, 9], width: 360, height: 300,
    margin: [34, 8, 26, 34],
    label: "Deflection of the wing along the span" });
  const chart = new Panel(living,
    { x: [0, TURNS], y: [1e-12, 1e6], log: [false, true], width: 340, height: 300,
    margin: [40, 8, 26, 34], label: "Residuals of the iteration" });
  const slider = living.slider("ratio",
    { label: "dynamic pressure / that of the flight", least: 2, most: 60, at: 20,
    value: k => k / 20, text: q => fixed(q, 2) });
  living.choice("sweep", { label: "sweep", at: names[0],
    options: names.map(s => [s, `${fixed(Number(s), 0)}°`]) });
  living.choice("relaxation", { label: "relaxation", at: 1,
    options: [[1, "none"], [0.5, "by one half"]] });
  living.player(slider, 120);
  const there = (n, text) => n.exists ? text : "none: the wing diverges";
  living.output("equilibrium, deflection of the tip", n => there(n, `${fixed(n.tip, 2)} m`), "mls");
  living.output("lift coefficient (rigid)",
    n => there(n, `${fixed(n.lift, 3)} (${fixed(n.rigidLift, 3)})`));
  living.output(["factor ", element("i", {}, "q λ"), " of a step without relaxation"],
    n => fixed(n.factor, 3));
  living.output("the iteration", n => n.observed < 1 ? `converges, factor ${fixed(n.observed, 3)}`
    : `diverges, factor ${fixed(n.observed, 3)}`, n => n.observed < 1 ? "" : "warn");

  return ({ ratio, sweep, relaxation }) => {
    const { feedback, rigid, rise, lift, eigenvalue, divergence } = sweeps[sweep], q = ratio * pressure;
    const matrix = feedback.map((row, i) => row.map((t, j) => Number(i === j) - q * t));
    const gamma = solve(matrix, rigid.map(g => [g])).flat();
    const heights = g => rise.map(row => q * dot(row, g));
    const residuals = iterated(feedback, rigid, q, relaxation);
    const exists = Number(divergence === null || q < divergence), z = heights(gamma),
      first = heights(rigid);
    const shape = values => values.map((h, k) => [span[k], Math.max(-1, Math.min(9, h))]);
    wing.draw(wing.axes([0, 10, 20, 30], [0, 2, 4, 6, 8],
      { xLabel: "span, m", yLabel: "deflection, m" }),
      wing.line([0, 0], [span.at(-1), 0], "thin dashed"), wing.path(shape(first), "thin"),
      exists ? [wing.path(shape(z), "mls"), shape(z).map(p => wing.dot(p, 2.5, "fill mls"))] : "",
      wing.text([0, 9], "loads of the rigid wing", "tick", [8, 14]),
        wing.text([0, 9], exists ? "equilibrium" : "no equilibrium", exists ? "mls" : "warn", [8, 31]));
    const clip = r => Math.max(1e-12, Math.min(1e6, r));
    chart.draw(chart.axes([0, 10, 20, 30, 40], [1e-12, 1e-6, 1, 1e6],
      { xLabel: "steps", yLabel: "residual", yText: y => y === 1 ? "1" : power(Math.log10(y)) }),
      chart.path(residuals.map((r, k) => [k, clip(r)]), "rbf"),
        residuals.map((r, k) => chart.dot([k, clip(r)], 2.2, "fill rbf")));
    return { exists, tip: z.at(-1), lift: dot(lift, gamma), rigidLift: dot(lift, rigid),
      factor: q * eigenvalue,
      residual: residuals[5], observed: observed(residuals) };
  };
});

// Norms of the steps, relative to the first, of the iteration that begins with the rigid wing.
function iterated(feedback, rigid, q, relaxation) {
  const residuals = [];
  let gamma = rigid;
  for (let k = 0; k <= TURNS; k++) {
    const step = feedback.map((row, i) => rigid[i] + q * dot(row, gamma) - gamma[i]);
    residuals.push(Math.sqrt(dot(step, step)));
    gamma = gamma.map((g, i) => g + relaxation * step[i]);
  }
  return residuals.map(r => r / residuals[0]);
}

// The factor between two steps: the last ones above rounding.
function observed(residuals) {
  const last = residuals.findLastIndex(r => r > 1e-8);
  return residuals[last] / residuals[last - 1];
}
