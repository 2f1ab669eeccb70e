// The velocity of a triangle from the normal velocities of its sides, and the point of the field
// that has this velocity: the circumcentre, the symmedian point or a point of the nine-point circle.
widget("cell_velocity", living => {
  living.state.corners = living.data.corners;
  const panel = new Panel(living, { x: [-1.3, 1.3], y: [-1.2, 1.2], width: 360, height: 332,
    label: "A triangle, its circles, and the point that has the velocity of the cell" });
  panel.svg.style.maxWidth = "32rem";
  for (let k = 0; k < 3; k++)
    panel.handle("corners", { index: k, label: `Corner ${k + 1}`, step: 0.04, radius: 7,
      move: (p, old) => isFat(living.state.corners.map((q, i) => i === k ? p : q)) ? p : old });
  living.choice("motion", { label: "motion", at: "strain",
    options: [["strain", "strain"], ["rotation", "rotation"], ["expansion", "expansion"]] });
  living.slider("axis", { label: "axis of the strain", least: 0, most: 179, at: 20,
    text: x => `${x}°` });
  living.output("distance of the point from the nine-point circle", n => measured(n.offCircle));
  living.output("error of the velocity at the circumcentre", n => measured(n.errorAtCenter));
  living.output("at the centroid", n => measured(n.errorAtCentroid));
  living.output("circumradius", n => digits(n.radius));

  return ({ corners, motion, axis }) => {
    const n = cellVelocity(corners, gradientOf(motion, axis));
    const around = p => [p[0] - n.center[0], p[1] - n.center[1]];
    const field = [];
    for (let x = -1.2; x <= 1.2; x += 0.24)
      for (let y = -1.1; y <= 1.1; y += 0.22)
        field.push(panel.arrow([x, y], times(n.gradient, around([x, y])).map(u => 0.11 * u), "pale"));
    const names = { O: [n.center, [5, 15]], K: [n.symmedian, [-14, -2]], M: [n.centroid, [7, 4]],
      N: [n.nineCenter, [3, -7]] };
    panel.draw(field.join("").replaceAll("pale", "grid"),
      panel.area(corners, ""), panel.circle(n.center, n.radius, "thin dashed"),
        panel.circle(n.nineCenter, n.radius / 2, "thin"),
      motion === "strain" ? axisThrough(panel, n.place, axis) : "",
      Object.entries(names).map(([name, [p, shift]]) =>
        [panel.dot(p, 2.5, "solid"), panel.text(p, name, "it", shift)]),
      panel.arrow(n.place, n.velocity.map(u => 0.3 * u), "rbf"), panel.dot(n.place, 5.5, "fill rbf"));
    return n;
  };
});

function axisThrough(panel, p, degrees) {
  const [c, s] = [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
  return panel.line([p[0] - 0.35 * c, p[1] - 0.35 * s], [p[0] + 0.35 * c, p[1] + 0.35 * s],
    "ls dashed");
}

function gradientOf(motion, axis) {
  if (motion === "rotation") return [[0, -1], [1, 0]];
  if (motion === "expansion") return [[1, 0], [0, 1]];
  const angle = 2 * axis * Math.PI / 180;
  return [[Math.cos(angle), Math.sin(angle)], [Math.sin(angle), -Math.cos(angle)]];
}

function times(matrix, v) { return matrix.map(row => dot(row, v)); }

// Every side at least a sixth of the box, every height at least a tenth, all corners in the box.
function isFat(corners) {
  const [a, b, c] = corners;
  const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const longest = Math.max(...sides(corners).map(s => Math.hypot(...s)));
  return area > 0.25 * longest && corners.flat().every(x => Math.abs(x) <= 1.15);
}

// The side opposite to each corner, in the order of the corners round the triangle.
function sides(corners) {
  return corners.map((_, k) => [0, 1].map(i => corners[(k + 2) % 3][i] - corners[(k + 1) % 3][i]));
}

function cellVelocity(corners, gradient) {
  const edges = sides(corners), squares = edges.map(e => dot(e, e));
  const center = circumcentre(corners),
    radius = Math.hypot(corners[0][0] - center[0], corners[0][1] - center[1]);
  const normals = edges.map(([u, v], k) => [v, -u].map(x => x / Math.sqrt(squares[k])));
  const middles = corners.map((_, k) =>
    [0, 1].map(i => (corners[(k + 1) % 3][i] + corners[(k + 2) % 3][i]) / 2));
  const away = p => [p[0] - center[0], p[1] - center[1]];
  const normal = normals.map((m, k) => dot(m, times(gradient, away(middles[k]))));
  const gram = [0, 1].map(i => [0, 1].map(j => normals.reduce((s, m) => s + m[i] * m[j], 0)));
  const right = [0, 1].map(i => [normals.reduce((s, m, k) => s + m[i] * normal[k], 0)]);
  const velocity = solve(gram, right).flat();
  const place = solve(gradient, velocity.map(u => [u])).flat().map((x, i) => x + center[i]);
  const mean = weights => [0, 1].map(i =>
    dot(weights, corners.map(q => q[i])) / weights.reduce((s, w) => s + w, 0));
  const centroid = mean([1, 1, 1]), symmedian = mean(squares);
  const nineCenter = centroid.map((x, i) => (3 * x - center[i]) / 2);
  const error = p => Math.hypot(...times(gradient, away(p)).map((u, i) => u - velocity[i]));
  return { gradient, center, radius, centroid, symmedian, nineCenter, velocity, place, normal,
    offCircle: Math.abs(Math.hypot(place[0] - nineCenter[0], place[1] - nineCenter[1]) - radius / 2),
    errorAtCenter: error(center), errorAtCentroid: error(centroid) };
}

function circumcentre([a, b, c]) {
  const p = [b[0] - a[0], b[1] - a[1]], q = [c[0] - a[0], c[1] - a[1]];
  return solve([p, q], [[dot(p, p) / 2], [dot(q, q) / 2]]).map(([x], i) => x + a[i]);
}
