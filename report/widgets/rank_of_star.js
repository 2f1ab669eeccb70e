// A vertex with its triangles: the rank of B', the conic through the vertices, and the flow along it
// that no edge sees.
const VANISHES = 1e-9;   // as a fraction of the largest singular value

widget("rank_of_star", living => {
  const { stars } = living.data;
  const panel = new Panel(living, { x: [-1.3, 1.3], y: [-1.2, 1.2], width: 360, height: 332,
    label: "Triangles around a vertex, the conic through all vertices, and the flow along it" });
  panel.svg.style.maxWidth = "32rem";
  living.state.points = stars[4];
  living.choice("triangles", { label: "triangles", at: 4, options: [[4, "4"], [5, "5"], [6, "6"]] });
  for (const radio of living.controls.querySelectorAll("input"))
    radio.addEventListener("change", () => living.set({ points: stars[living.state.triangles] }));
  const moved = (k, p) => living.state.points.map((q, i) => i === k ? p : q);
  for (let k = 0; k < 6; k++)
    panel.handle("points", { index: k, label: `Vertex ${k + 1}`, radius: 7, step: 0.04,
      move: (p, old) => surrounds(moved(k, p)) ? p : old });
  const onto = living.button("Move onto the conic",
    () => { living.state.points = ontoConic(living.state.points); });
  living.shown.push(() => {
    const { points } = living.state;
    onto.disabled = living.numbers.rank < 6 || ontoConic(points) === points;
  });
  living.button("Cross", () => Object.assign(living.state, {
    triangles: 4, points: [[0.8, 0.2], [-0.25, 0.75], [-0.96, -0.24], [0.2, -0.6]] }));
  living.output("rank of B′", n => `${n.rank} of 6`);
  living.output("smallest singular value, relative",
    n => n.ratio < VANISHES ? order(n.ratio) : digits(n.ratio));
  living.output("flow along the conic through the edges, at most", n => measured(n.leak), "mls");
  living.output("vertices on a conic", n => n.rank < 6 ? "yes" : "no (dashed: nearly)");
  living.output("velocity at the vertex",
    n => n.determined ? "determined" : "not determined (red: a flow that no edge sees)", "warn whole");

  return ({ points }) => {
    const n = rankOfStar(points), unseen = n.rank < 6;
    const speed = Math.max(...points.map(p => Math.hypot(...n.flow(p))));
    const arrows = [];
    for (let x = -1.2; x <= 1.2; x += 0.2)
      for (let y = -1.1; y <= 1.1; y += 0.2) arrows.push(panel.arrow([x, y],
        n.flow([x, y]).map(u => 0.12 * u / speed), "grid"));
    panel.draw(unseen ? arrows : "",
      points.map((p, k) => panel.path([[0, 0], p, points[(k + 1) % points.length]], "thin")),
      zeroLine(panel, p => dot(n.conic, quadratics(p)), unseen ? "mls" : "mls dashed"),
      edges(points).map(([a, b]) => unseen
        ? panel.arrow(middle(a, b), n.flow(middle(a, b)).map(u => 0.3 * u / speed), "ls") : ""),
      n.determined ? "" : panel.arrow([0, 0], n.unseen.map(u => 0.5 * u), "warn"),
        panel.dot([0, 0], 4, "solid"),
      points.map((p, k) => panel.text(p, k + 1, "middle", outward(p, 18))));
    const { flow, ...numbers } = n;
    return numbers;
  };
});

function middle(a, b) { return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]; }

function edges(points) {
  return points.flatMap((p, k) => [[[0, 0], p], [p, points[(k + 1) % points.length]]]);
}

function quadratics([x, y]) { return [1, x, y, x * x, x * y, y * y]; }

// Rows (n, y1 n, y2 n) of the samples at the midpoints of the edges, in units of the farthest.
function normalMatrix(points) {
  const samples = edges(points).map(([a, b]) =>
    ({ at: middle(a, b), along: [b[0] - a[0], b[1] - a[1]] }));
  const unit = Math.max(...samples.flatMap(({ at }) => at.map(Math.abs)));
  return samples.map(({ at, along }) => {
    const size = Math.hypot(...along), normal = [along[1] / size, -along[0] / size];
    return [1, at[0] / unit, at[1] / unit].flatMap(b => normal.map(n => b * n));
  });
}

function rankOfStar(points) {
  const { values, vectors } = singular(normalMatrix(points)), ratio = values[5] / values[0];
  const rank = values.filter(s => s > VANISHES * values[0]).length;
  const conic = nearestConic(points);
  const flow = ([x, y]) => [conic[2] + conic[4] * x + 2 * conic[5] * y,
    -(conic[1] + 2 * conic[3] * x + conic[4] * y)];
  const leak = Math.max(...edges(points).map(([a, b]) => {
    const [u, v] = flow(middle(a, b)), along = [b[0] - a[0], b[1] - a[1]];
    return Math.abs(u * along[1] - v * along[0]) / Math.hypot(...along);
  }));
  const lost = vectors.slice(rank).map(v => v.slice(0, 2));
  const determined = lost.every(v => Math.hypot(...v) < 1e-7);
  const velocity = lost.length ? lost[0] : [0, 0], size = Math.hypot(...velocity) || 1;
  return { rank, ratio, determined: Number(determined), conic, flow, leak,
    unseen: velocity.map(u => u / size) };
}

// Counter-clockwise around the origin, with every triangle visibly open.
function surrounds(points) {
  return points.every(([x, y], k) => {
    const [u, v] = points[(k + 1) % points.length];
    return x * v - y * u > 0.06 && Math.hypot(x, y) > 0.2 && Math.abs(x) <= 1.2 && Math.abs(y) <= 1.1;
  });
}

// All outer vertices move to the nearest conic.
function ontoConic(points) {
  const conic = nearestConic(points), moved = points.map(p => projected(conic, p));
  return surrounds(moved) ? moved : points;
}

// The conic through the centre that minimizes the sum of squares of its values at the vertices.
function nearestConic(points) {
  const rows = points.map(p => quadratics(p).slice(1));
  while (rows.length < 5) rows.push([0, 0, 0, 0, 0]);
  return [0, ...singular(rows).vectors[4]];
}

// Newton's method along the gradient of the conic.
function projected(c, [x, y]) {
  for (let step = 0; step < 50; step++) {
    const u = c[1] + 2 * c[3] * x + c[4] * y, v = c[2] + c[4] * x + 2 * c[5] * y;
    const t = dot(c, quadratics([x, y])) / (u * u + v * v);
    x -= t * u;
    y -= t * v;
  }
  return [x, y];
}

// The zero line of a function by linear interpolation on a grid of squares.
function zeroLine(panel, f, look) {
  const n = 60, [x, y] = [panel.x, panel.y].map(([from, to]) => i => from + (to - from) * i / n);
  const values = Array.from({ length: n + 1 },
    (_, i) => Array.from({ length: n + 1 }, (_, j) => f([x(i), y(j)])));
  const cut = (i, j, k, l) => {
    const a = values[i][j], b = values[k][l];
    return a > 0 === b > 0 ? null : [x(i) + (x(k) - x(i)) * a / (a - b),
      y(j) + (y(l) - y(j)) * a / (a - b)];
  };
  let path = "";
  for (let i = 0; i < n; i++)
    for (let j = 0; j < n; j++) {
      const ends = [cut(i, j, i + 1, j), cut(i + 1, j, i + 1, j + 1), cut(i, j + 1, i + 1, j + 1),
        cut(i, j, i, j + 1)].filter(Boolean);
      for (let k = 0; k + 1 < ends.length; k += 2) path += `M${panel.at(ends[k])}L${panel.at(ends[k +
        1])}`;
    }
  return `<path class="${look}" d="${path}"/>`;
}
