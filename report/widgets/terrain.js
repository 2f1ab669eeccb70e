// Terrain from isolines: swipe between the land and a reconstruction, and ask for the neighbours,
// weights and error at a point.
widget("terrain", living => {
  const { steps, columns, points, values, neighbors, thinPlate } = living.data;
  const truth = decoded(living.data.heights, columns), rows = truth.length;
  const place = (i, j) => [j * steps[0], i * steps[1]];
  const width = columns * steps[0], height = rows * steps[1], size = 420;
  const map = new Panel(living, { x: [-steps[0] / 2, width - steps[0] / 2],
    y: [-steps[1] / 2, height - steps[1] / 2],
    width: size, height: size * height / width, margin: [0, 0, 0, 0],
      label: "Shaded relief of the land and of a reconstruction" });
  map.svg.style.maxWidth = "34rem";
  const [land, model] = [0, 1].map(() =>
    svgElement("image", { width: size, height: map.height, preserveAspectRatio: "none" }));
  map.svg.prepend(land, model);
  const clip = svgElement("rect", { y: 0, height: map.height },
    svgElement("clipPath", { id: "terrain-swipe" }, map.svg));
  model.setAttribute("clip-path", "url(#terrain-swipe)");
  const canvas = element("canvas", { width: columns, height: rows });
  const lit = heights => shade(heights, canvas, 1.6 / (1000 * steps[0]));

  living.state.cell = place(Math.round(0.42 * rows), Math.round(0.3 * columns));
  map.handle("cell", { label: "Point", radius: 6, step: 3 * steps[0], fine: steps[0],
    move: p => nearestCell(p) });
  map.svg.style.cursor = "crosshair";
  map.svg.addEventListener("pointerdown", event => {
    if (!event.target.closest(".handle")) living.set({ cell: nearestCell(map.fromEvent(event)) });
  });
  living.slider("swipe", { label: "reconstruction | land", least: 0, most: 100, at: 50,
    text: x => `${x} %` });
  living.choice("method", { label: "method", at: "moving1",
    options: [["moving1", "MLS, degree 1"], ["moving2", "MLS, degree 2"],
      ["thinPlate", "thin plate"]] });
  living.output("height, reconstructed", n => `${fixed(n.value, 1)} m`, "mls");
  living.output("height of the land", n => `${fixed(n.truth, 0)} m`);
  living.output("error", n => `${fixed(n.value - n.truth, 1)} m`);
  living.output("points that count",
    n => n.weights.length ? String(n.weights.length) : `all ${points.length}`);
  living.output("sum of |weights|", n => n.weights.length ? digits(n.amplification) : "–");
  living.output("root mean square error of the map", n => `${fixed(n.rms, 1)} m`);

  function nearestCell(p) {
    const inside = (t, count) => Math.max(0, Math.min(count - 1, Math.round(t)));
    return place(inside(p[1] / steps[1], rows), inside(p[0] / steps[0], columns));
  }

  const byPlane = ([x, y]) => {
    let sum = dot(thinPlate.affine, [1, x, y]);
    for (let k = 0; k < points.length; k++) {
      const r = (x - points[k][0]) ** 2 + (y - points[k][1]) ** 2;
      if (r) sum += thinPlate.lambda[k] * r * Math.log(r);
    }
    return sum;
  };
  const weightsAt = (p, method) =>
    nearestWeights(points, p, neighbors[method.at(-1)], Number(method.at(-1)));
  const value = (p, method) => {
    if (method === "thinPlate") return byPlane(p);
    return weightsAt(p, method).reduce((sum, [k, w]) => sum + w * values[k], 0);
  };

  const maps = {};   // the map of each method is computed once
  function mapOf(method) {
    if (maps[method]) return maps[method];
    const heights = truth.map((row, i) => row.map((_, j) => value(place(i, j), method)));
    const wrong = heights.flatMap((row, i) => row.map((h, j) => h - truth[i][j]));
    return maps[method] = { href: lit(heights), rms: rms(wrong) };
  }

  return ({ cell, swipe, method }) => {
    if (!land.hasAttribute("href")) land.setAttribute("href", lit(truth));
    const { href, rms: error } = mapOf(method);
    if (model.getAttribute("href") !== href) model.setAttribute("href", href);
    clip.setAttribute("width", size * swipe / 100);
    const near = method === "thinPlate" ? [] : weightsAt(cell, method);
    const border = map.x[0] + (map.x[1] - map.x[0]) * swipe / 100;
    map.draw(points.map(p => map.dot(p, 1.3, "fill ls")),
      map.line([border, map.y[0]], [border, map.y[1]], "accent"),
      near.map(([k, w]) => [map.line(cell, points[k], "ls"),
        map.dot(points[k], 2 + 14 * Math.sqrt(Math.abs(w)), w < 0 ? "warn fill" : "mls fill")]));
    return { value: value(cell, method),
      truth: truth[Math.round(cell[1] / steps[1])][Math.round(cell[0] / steps[0])],
      rms: error, neighbors: near.map(([k]) => k), weights: near.map(([, w]) => w),
      amplification: near.reduce((sum, [, w]) => sum + Math.abs(w), 0) };
  };
});

// Rows of heights from 16-bit integers.
function decoded(text, columns) {
  const all = shorts(text);
  return Array.from({ length: all.length / columns },
    (_, i) => all.slice(i * columns, (i + 1) * columns));
}

// Pairs of a point and its weight: moving least squares on the k nearest points, with a weight that
// vanishes at the next one.
function nearestWeights(points, [x, y], k, degree) {
  const near = [];   // pairs of a squared distance and a point, in ascending order
  for (let i = 0; i < points.length; i++) {
    const r = (points[i][0] - x) ** 2 + (points[i][1] - y) ** 2;
    if (near.length > k && r >= near[k][0]) continue;
    let at = near.length;
    while (at && near[at - 1][0] > r) at--;
    near.splice(at, 0, [r, i]);
    near.length = Math.min(near.length, k + 1);
  }
  const reach = Math.sqrt(near.pop()[0]);
  const w = near.map(([r]) => { const t = Math.sqrt(r) / reach; return (1 - t) ** 4 * (4 * t + 1); });
  const columns = monomials(near.map(([, i]) =>
    [(points[i][0] - x) / reach, (points[i][1] - y) / reach]), degree)
    .map(column => column.map((b, i) => b * w[i]));
  return valueWeights(columns).map((a, i) => [near[i][1], a * w[i]]);
}

// Columns of the basis 1, x, y, x², xy, y² at points.
function monomials(offsets, degree) {
  const basis = [() => 1, p => p[0], p => p[1], p => p[0] ** 2, p => p[0] * p[1], p => p[1] ** 2];
  return basis.slice(0, degree === 1 ? 3 : 6).map(b => offsets.map(b));
}

// The first row of the pseudoinverse of a matrix with these columns, by Gram and Schmidt, twice.
function valueWeights(columns) {
  const ordered = [...columns.slice(1), columns[0]], q = [];
  for (const column of ordered) {
    const v = [...column];
    for (let pass = 0; pass < 2; pass++)
      for (const u of q) {
        const part = dot(u, v);
        for (let i = 0; i < v.length; i++) v[i] -= part * u[i];
      }
    const size = Math.sqrt(dot(v, v));
    if (q.length === columns.length - 1) return v.map(t => t / (size * size));
    q.push(v.map(t => t / size));
  }
}
