// Voronoi coordinates of a query in a star of six triangles, as a product and as a quotient.
widget("voronoi_coordinates", living => {
  const n = 6, next = a => (a + 1) % n;
  living.state.corners = living.data.corners;
  living.state.query = [0, 0];
  const star = new Panel(living, { x: [-1.5, 1.5], y: [-1.4, 1.4], width: 360, height: 336,
    label: "A vertex with six triangles, its Voronoi cell, and a query" });
  const bars = new Panel(living, { x: [-0.1, 1], y: [6.2, -0.6], width: 340, height: 316,
    margin: [46, 46, 22, 22],
    label: "Weights of the six circumcentres" });
  for (let k = 0; k < n; k++)
    star.handle("corners", { index: k, label: `Vertex ${k + 1}`, radius: 6, step: 0.05,
      move: (p, old) => allowed(living.state.corners.map((q, i) => i === k ? p : q)) ? settle(k, p)
        : old });
  star.handle("query", { label: "Query", look: "query", step: 0.02,
    move: p => inside(living.state.corners, p) });
  living.slider("distance", { label: "move the query to edge 6–1, to the distance", least: 1, most: 17,
    at: 1,
    value: k => 10 ** -k, text: order });
  living.controls.querySelector("input").addEventListener("input",
    () => living.set({ query: besideEdge() }));
  living.state.query = besideEdge();
  living.output("error of Σ w p, product", m => order(m.productError), "mls");
  living.output("error of Σ w p, quotient", m => order(m.quotientError), "ls");
  living.output("smallest weight", m => measured(m.smallest));
  living.output("distance from the nearest edge", m => measured(m.nearest));

  // A point at this distance from the first edge of the cell, at a third of its length.
  function besideEdge() {
    const { corners, distance } = living.state, spoke = corners[0], size = Math.hypot(...spoke);
    const [p, q] = [center(corners, n - 1), center(corners, 0)];
    return p.map((x, k) => x + 0.35 * (q[k] - x) - distance * spoke[k] / size);
  }

  function settle(k, p) {
    const corners = living.state.corners.map((q, i) => i === k ? p : q);
    living.state.query = inside(corners, living.state.query);
    return p;
  }

  return ({ corners, query }) => {
    const found = voronoiWeights(corners, query);
    const sizes = w => Math.sqrt(Math.max(0, Math.min(1, w)));
    star.draw(
      corners.map((b, a) => [star.path([[0, 0], b, corners[next(a)]], "thin")]),
      star.area(found.centers, "box"), star.dot([0, 0], 3, "solid"),
        star.text([0, 0], "x<tspan dy='3' font-size='9'>i</tspan>", "it", [6, -5]),
      found.centers.map((p, a) => [star.line(query, p, "thin dashed"),
        star.dot(p, 3 + 22 * sizes(found.product[a]), "fill mls"),
        star.text(p, a + 1, "middle", outward(p, 12 + 22 * sizes(found.product[a])))]));
    bars.draw(bars.axes([0, 0.5, 1], [], { xText: x => fixed(x, 1) }), found.product.map((w, a) => [
      bars.text([-0.1, a], `w<tspan dy='3' font-size='9'>${a + 1}</tspan>`, "it last", [-20, 8]),
      bar(bars, w, a - 0.2, "mls"), bar(bars, found.quotient[a], a + 0.2, "ls"),
      bars.text([1, a], fixed(w, 3), "mls", [4, 2]),
      bars.text([1, a], Number.isFinite(found.quotient[a]) ? fixed(found.quotient[a], 3) : "none", "ls",
        [4, 16])]),
      bars.text([0, -0.6], "product", "mls", [0, -6]),
        bars.text([0, -0.6], "quotient", "ls", [60, -6]));
    return found;
  };

  function bar(panel, w, y, look) {
    if (!Number.isFinite(w)) return "";
    const end = Math.max(-0.1, Math.min(1, w));
    return panel.area([[0, y - 0.16], [end, y - 0.16], [end, y + 0.16], [0, y + 0.16]], `fill ${look}`);
  }
});

function cross(a, b) { return a[0] * b[1] - a[1] * b[0]; }

// The circumcentre of the triangle of the vertex at the origin and the outer vertices a and a + 1.
function center(corners, a) {
  const b = corners[a], c = corners[(a + 1) % corners.length], bb = dot(b, b) / 2, cc = dot(c, c) / 2;
  const d = cross(b, c);
  return [(bb * c[1] - cc * b[1]) / d, (cc * b[0] - bb * c[0]) / d];
}

// Half the squared length of a spoke times the relative height of the query above its bisector.
function height(b, x) { return dot(b, b) / 2 - dot(b, x); }

function voronoiWeights(corners, query) {
  const n = corners.length, centers = corners.map((_, a) => center(corners, a));
  const heights = corners.map(b => height(b, query));
  const volume = corners.map((b, a) => cross(b, corners[(a + 1) % n]) / 2);
  const product = volume.map((v, a) =>
    heights.reduce((c, h, b) => b === a || b === (a + 1) % n ? c : c * h, v));
  const quotient = volume.map((v, a) => [a, (a + 1) % n].reduce((c, b) =>
    c / dot(corners[b], [centers[a][0] - query[0], centers[a][1] - query[1]]), v));
  const share = w => { const sum = w.reduce((s, x) => s + x, 0); return w.map(x => x / sum); };
  const found = { centers, product: share(product), quotient: share(quotient) };
  const wrong = w => Math.hypot(...[0,
    1].map(k => w.reduce((s, x, a) => s + x * centers[a][k], 0) - query[k]));
  return { ...found, productError: wrong(found.product), quotientError: wrong(found.quotient),
    smallest: Math.min(...found.product),
      nearest: Math.min(...corners.map((b, a) => heights[a] / Math.hypot(...b))) };
}

// The triangles keep their orientation, and the circumcentres their order round the vertex.
function allowed(corners) {
  const n = corners.length, centers = corners.map((_, a) => center(corners, a));
  return corners.every((b, a) => {
    const before = centers[(a + n - 1) % n], size = Math.hypot(...b);
    const along = cross(b, [centers[a][0] - before[0], centers[a][1] - before[1]]) / size;
    return cross(b, corners[(a + 1) % n]) > 0.05 && along > 0.04 && size < 1.6 &&
      Math.abs(b[0]) < 1.5 && Math.abs(b[1]) < 1.4;
  });
}

// The point, or the last point of the way to it from the vertex that is inside the cell.
function inside(corners, p) {
  const reach = Math.max(...corners.map(b => dot(b, p) / (0.98 * dot(b, b) / 2)));
  return reach > 1 ? p.map(x => x / reach) : p;
}
