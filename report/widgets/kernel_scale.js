// A kernel and its scale: the error falls as the system comes close to singular.
const KERNELS = {
  gaussian: { text: "Gaussian", order: 0, value: (r, c) => Math.exp(-((r / c) ** 2)) },
  multiquadric: { text: "multiquadric", order: 1, value: (r, c) => -Math.hypot(1, r / c) },
  matern: { text: "Matérn 5/2", order: 0,
    value: (r, c) => (1 + r / c + (r / c) ** 2 / 3) * Math.exp(-r / c) },
  wendland: { text: "Wendland C²", order: 0,
    value: (r, c) => Math.max(0, 1 - r / c) ** 4 * (4 * r / c + 1) },
  cubic: { text: "r³ (no scale)", order: 2, value: r => r ** 3 },
};
const CERTAIN = 1e13;   // a larger condition number is rounding, and so are the coefficients

widget("kernel_scale", living => {
  const { sites, queries, scales, curves } = living.data;
  const x = Array.from({ length: queries }, (_, i) => i / (queries - 1)), values = sites.map(sampled);
  const plot = new Panel(living, { x: [0, 1], y: [-1.6, 2.4], width: 360, height: 300,
    margin: [30, 8, 8, 22],
    label: "The function, its samples, the interpolant and one basis function" });
  const column = element("div");
  living.panels.append(column);
  const [errors, conditions] = [[3e-4, 3, 160], [1, 1e18, 150]].map(([least, most, height], k) =>
    new Panel(living, { x: [scales[0], scales.at(-1)], y: [least, most], height, log: [true, true],
      margin: [38, 8, k ? 32 : 26, 20], parent: column,
        label: k ? "Condition number against the scale" : "Error against the scale" }));
  living.choice("kernel", { label: "kernel", at: "gaussian",
    options: Object.entries(KERNELS).map(([key, k]) => [key, k.text]) });
  living.slider("scale", { label: "scale", least: -40, most: 20, at: -24, value: k => 10 ** (k / 20),
    text: s => digits(s, 3) });
  const certain = n => n.condition < CERTAIN;
  living.output("error", n => certain(n) ? digits(n.error) : order(n.error), "rbf");
  living.output("condition number",
    n => n.condition < 1e6 ? digits(n.condition) : n.condition < 1e16 ? order(n.condition)
    : "over 10¹⁶", n => certain(n) ? "" : "warn");
  living.output("correct digits of the coefficients, about",
    n => String(Math.max(0, Math.floor(16 - Math.log10(n.condition)))));
  living.output("system", n => certain(n) ? "solved" : "too ill-conditioned: all digits are rounding");

  return ({ kernel, scale }) => {
    const { order: m, value } = KERNELS[kernel];
    const matrix = interpolationMatrix(sites, r => value(r, scale), m);
    const sizes = eigenvalues(matrix).map(Math.abs),
      condition = Math.max(...sizes) / Math.min(...sizes);
    const right = [...values, ...Array(m).fill(0)].map(f => [f]), c = solve(matrix, right).flat();
    const row = t => [...sites.map(p => value(Math.abs(t - p), scale)),
      ...Array.from({ length: m }, (_, k) => t ** k)];
    const found = x.map(t => dot(c, row(t))), error = rms(found.map((s, i) => s - sampled(x[i])));
    const middle = sites[Math.floor(sites.length / 2)], basis = value(0, scale) || 1;
    const clip = y => Math.max(-1.7, Math.min(2.5, y));
    plot.draw(plot.axes([0, 0.5, 1], [-1, 0, 1, 2]),
      plot.path(x.map(t => [t, clip(kernel === "cubic" ? value(Math.abs(t - middle))
        : value(Math.abs(t - middle), scale) / basis)]), "thin dashed"),
      plot.path(x.map(t => [t, sampled(t)]), "pale"),
        plot.path(x.map((t, i) => [t, clip(found[i])]), "rbf"),
      sites.map((p, i) => plot.dot([p, values[i]], 3.5, "solid")),
      plot.text([0, 2.4], "interpolant", "rbf", [8, 10]),
        plot.text([0, 2.4], "one basis function, dashed", "tick", [84, 10]));
    const ticks = [0.01, 0.1, 1, 10], at = kernel === "cubic" ? 1 : scale;
    const inside = (panel, y) => Math.max(panel.y[0], Math.min(panel.y[1], y || panel.y[0]));
    errors.draw(errors.axes(ticks, [1e-3, 1e-2, 1e-1, 1],
      { yText: y => power(Math.log10(y)), yLabel: "error" }),
      pieces(errors, curves[kernel].error, "rbf"),
      Number.isFinite(error) ? errors.dot([at, inside(errors, error)], 5,
        certain({ condition }) ? "rbf fill" : "rbf") : "");
    conditions.draw(conditions.axes(ticks, [1, 1e6, 1e12, 1e18],
      { xLabel: "scale", yText: y => y === 1 ? "1" : power(Math.log10(y)),
      yLabel: "condition number" }),
      conditions.line([scales[0], CERTAIN], [scales.at(-1), CERTAIN], "thin dashed"),
      pieces(conditions, curves[kernel].condition, ""),
        conditions.dot([at, inside(conditions, condition)], 5,
          certain({ condition }) ? "solid" : "warn fill"));
    return { error, condition };
  };

  // Where the library refuses the system, the curve has a gap.
  function pieces(panel, ys, look) {
    const runs = [[]];
    ys.forEach((y, k) => y === null ? runs.push([])
      : runs.at(-1).push([scales[k], Math.max(panel.y[0], y)]));
    return runs.filter(run => run.length > 1).map(run => panel.path(run, look));
  }
});

function sampled(x) { return Math.sin(5 * x) + Math.exp(-(((x - 0.6) / 0.12) ** 2)); }

function interpolationMatrix(sites, phi, order) {
  const powers = Array.from({ length: order }, (_, k) => k);
  return [...sites.map(p => [...sites.map(q => phi(Math.abs(p - q))), ...powers.map(k => p ** k)]),
    ...powers.map(k => [...sites.map(p => p ** k), ...powers.map(() => 0)])];
}
