// ε of moving least squares: the relief, its extrema, and two criteria for ε.
widget("moving_least_squares", living => {
  const { sites, fields, side, spacing, ratios, sweeps, extrema } = living.data;
  const ticks = Array.from({ length: side }, (_, i) => (i + 0.5) / side);
  const truth = ticks.map(y => ticks.map(x => franke(x, y)));
  const canvas = element("canvas", { width: side, height: side });
  const relief = new Panel(living,
    { x: [0, 1], y: [0, 1], width: 340, height: 340, margin: [0, 0, 0, 0],
    label: "Shaded relief of the reconstruction with its local extrema" });
  const image = svgElement("image", { width: 340, height: 340, preserveAspectRatio: "none" });
  relief.svg.prepend(image);
  const column = element("div");
  living.panels.append(column);
  const [errors, objectives] = [[5e-3, 0.3, 190], [1, 1e5, 150]].map(([least, most, height], k) =>
    new Panel(living, { x: [ratios[0], ratios.at(-1)], y: [least, most], height, log: [true, true],
      margin: [38, 8, 20, k ? 30 : 18], parent: column,
        label: k ? "Objective against ε" : "Errors against ε" }));

  living.slider("ratio", { label: "ε / h", least: -26, most: 14, at: -20, value: at => 10 ** (at / 20),
    text: x => digits(x, 3) });
  living.choice("degree", { label: "polynomials", options: [[0, "constant"], [1, "linear"]], at: 1 });
  living.choice("data", { label: "data", options: [["exact", "exact"], ["noisy", "with noise"]],
    at: "exact" });
  living.output("local extrema", n => `${n.extrema} (the field has ${extrema})`,
    n => n.extrema > extrema ? "warn" : "");
  living.output("error of the field", n => digits(n.error), "mls");
  living.output("leave-one-out error", n => digits(n.leaveOneOut));
  living.output("ψ, mean", n => digits(n.psi));

  function draw(state, values, found) {
    image.setAttribute("href", shade(values, canvas, side / 3));
    relief.draw(found.map(([i, j]) => relief.dot([ticks[j], ticks[i]], 4.5, "mark")));
    const curves = sweeps[state.degree][state.data], now = state.ratio;
    const curve = (panel, key, look) => panel.path(ratios.map((r, k) => [r, curves[key][k]]), look);
    const mark = (panel, key, look) => panel.dot([now, living.numbersNow[key]], 5, `${look} fill`);
    const x = [0.1, 1];
    errors.draw(errors.axes(x, [1e-2, 1e-1], { yText: y => power(Math.log10(y)) }),
      curve(errors, "error", "mls"), curve(errors, "leaveOneOut", "dashed"),
      mark(errors, "error", "mls"), mark(errors, "leaveOneOut", "solid"),
      errors.text([ratios[0], 0.3], "error", "mls", [6, 12]),
        errors.text([ratios[0], 0.3], "leave-one-out", "", [46, 12]));
    objectives.draw(objectives.axes(x, [1, 1e2, 1e4],
      { xLabel: "ε / h", yText: y => power(Math.log10(y)) }),
      curve(objectives, "psi", ""), mark(objectives, "psi", "solid"),
        objectives.text([ratios.at(-1), 1e5], "ψ", "it last", [-8, 14]));
  }

  return state => {
    const epsilon = state.ratio * spacing, data = fields[state.data],
      counts = new Float64Array(sites.length);
    let psi = 0, squares = 0;
    const values = ticks.map((y, i) => ticks.map((x, j) => {
      inverseSquares(sites, [x, y], epsilon, counts);
      const fit = movingFit(sites, data, counts, [x, y], state.degree);
      psi += objective(sites, data, counts, [x, y], fit);
      squares += (fit.value - truth[i][j]) ** 2;
      return fit.value;
    }));
    const left = sites.map((site, i) => data[i] -
      movingFit(sites, data, inverseSquares(sites, site, epsilon, counts), site, state.degree,
        i).value);
    const found = localExtrema(values);
    const numbers = { extrema: found.length, error: Math.sqrt(squares / side ** 2),
      leaveOneOut: rms(left), psi: psi / side ** 2 };
    living.numbersNow = numbers;
    draw(state, values, found);
    return numbers;
  };
});

function franke(x, y) {
  const u = 9 * x, v = 9 * y;
  return 0.75 * Math.exp(-((u - 2) ** 2 + (v - 2) ** 2) / 4) +
    0.75 * Math.exp(-((u + 1) ** 2) / 49 - (v + 1) / 10) +
    0.5 * Math.exp(-((u - 7) ** 2 + (v - 3) ** 2) / 4) - 0.2 * Math.exp(-((u - 4) ** 2) - (v - 7) ** 2);
}

// Inner points of the grid above, or below, all eight neighbours.
function localExtrema(values) {
  const found = [], n = values.length;
  for (let i = 1; i < n - 1; i++)
    for (let j = 1; j < n - 1; j++) {
      let above = true, below = true;
      for (let a = -1; a <= 1; a++)
        for (let b = -1; b <= 1; b++) {
          if (!a && !b) continue;
          above &&= values[i][j] > values[i + a][j + b];
          below &&= values[i][j] < values[i + a][j + b];
        }
      if (above || below) found.push([i, j]);
    }
  return found;
}
