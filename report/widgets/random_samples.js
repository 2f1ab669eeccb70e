// Random samples of (x1 + x2)^n: errors of least squares, moving least squares and thin plates, for
// one draw after the other.
widget("random_samples", living => {
  const { powers, best, epsilon, queries } = living.data;
  const methods = [["leastSquares", "least squares", "ls"], ["moving", "moving LS", "mls"],
    ["thinPlate", "thin plate", "rbf"]];
  const square = new Panel(living,
    { x: [0, 1], y: [0, 1], width: 330, height: 330, margin: [6, 6, 6, 6],
    label: "Random samples and query points in the unit square" });
  const chart = new Panel(living,
    { x: [0, 3], y: [1e-5, 1e2], log: [false, true], width: 360, height: 330,
    margin: [40, 8, 26, 24], label: "Errors of the draws so far" });
  living.slider("power", { label: "power n", least: 1, most: powers, at: 3 });
  living.slider("count", { label: "samples", least: 10, most: 200, step: 5, at: 100 });
  living.state.seed = 1;
  living.button("Draw again", () => { living.state.seed += 1; });
  living.button("20 draws", () => { living.state.seed += 20; });
  for (const [key, name, look] of methods) living.output(`error of ${name}`, n => measured(n[key]),
    look);
  living.output("least squares / moving LS, mean of the draws",
    n => n.ratio ? `${digits(n.ratio)} (${n.draws})` : "both exact");

  function draw(n, count, seed) {
    const random = generator(seed), pair = () => [random(), random()];
    const sites = Array.from({ length: count }, pair), places = Array.from({ length: queries }, pair);
    const field = ([x, y]) => (x + y) ** n, values = sites.map(field), truth = places.map(field);
    const error = s => rms(places.map((p, i) => s(p) - truth[i]));
    const moving = p => movingFit(sites, values, inverseSquares(sites, p, epsilon, []), p, 1).value;
    return { sites, places, leastSquares: error(fitOnce(sites, values)), moving: error(moving),
      thinPlate: error(thinPlate(sites, values)) };
  }

  let all = [], setting = "";
  return ({ power: n, count, seed }) => {
    if (setting !== `${n} ${count}`) all = [];
    setting = `${n} ${count}`;
    all.length = Math.min(all.length, seed);
    while (all.length < seed) all.push(draw(n, count, all.length + 1));
    const found = all.at(-1), { sites, places } = found;
    const ratio = n > 1 ? Math.exp(all.reduce((s, e) => s + Math.log(e.leastSquares / e.moving),
      0) / all.length) : 0;
    square.draw(square.area([[0, 0], [1, 0], [1, 1], [0, 1]], "box"),
      sites.map(p => square.dot(p, 2.2, "solid")),
      places.map(p => square.dot(p, 5, "accent")));
    const floor = e => Math.max(1.4e-5, e);
    chart.draw(chart.axes([], [1e-4, 1e-2, 1, 100],
      { yText: y => power(Math.log10(y)), yLabel: "error" }),
      n > 1 ? [chart.line([0, best[n - 1]], [1, best[n - 1]], "ls dashed"),
        chart.text([1, best[n - 1]], "best linear fit, exact", "tick", [4, -5])] : "",
      methods.map(([key, name, look], k) => [all.map((e, i) =>
        chart.dot([k + 0.3 + 0.4 * fraction(i), floor(e[key])], 2.5, look)),
        chart.dot([k + 0.5, floor(found[key])], 5.5, `fill ${look}`),
          chart.text([k + 0.5, 1e-5], name, `tick middle`, [0, 14])]));
    return { ...found, ratio, draws: all.length };
  };
});

// Places of the dots of the draws in their column.
function fraction(i) { return (i * 0.6180339887) % 1; }

// Uniform numbers in [0, 1) from a seed (Marsaglia's xorshift), the same in every browser.
function generator(seed) {
  let state = Math.imul(seed, 2654435761) >>> 0 || 1;
  const step = () => {
    state ^= state << 13; state >>>= 0;
    state ^= state >>> 17;
    state ^= state << 5; state >>>= 0;
    return state / 2 ** 32;
  };
  for (let i = 0; i < 20; i++) step();
  return step;
}

// Least squares of degree one is the moving fit with equal weights, about the first query.
function fitOnce(sites, values) {
  const about = [0.5, 0.5], fit = movingFit(sites, values, sites.map(() => 1), about, 1);
  return p => fit.value + fit.slope[0] * (p[0] - about[0]) + fit.slope[1] * (p[1] - about[1]);
}

// The interpolant with r² log r² and an affine function.
function thinPlate(sites, values) {
  const phi = (p, q) => {
    const r = (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2;
    return r ? r * Math.log(r) : 0;
  };
  const affine = p => [1, p[0] - 0.5, p[1] - 0.5];
  const upper = sites.map(p => [...sites.map(q => phi(p, q)), ...affine(p)]);
  const lower = [0, 1, 2].map(k => [...sites.map(p => affine(p)[k]), 0, 0, 0]);
  const c = solve([...upper, ...lower], [...values, 0, 0, 0].map(f => [f])).flat();
  return p => dot(c, [...sites.map(q => phi(p, q)), ...affine(p)]);
}
