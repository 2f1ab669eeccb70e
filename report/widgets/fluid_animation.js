// The fluid animation: a new mesh in every frame, the ink that it carries, and the energy that is left.
widget("fluid_animation", living => {
  const { times, ways, energies, rims } = living.data;
  const frames = living.data.frames.map(unpacked), looks = ["rbf", "mls", "", "ls"];
  const box = new Panel(living, { x: [0, 1], y: [0, 1], width: 360, height: 360, margin: [3, 3, 3, 3],
    label: "Mesh, ink and its exact boundary" });
  const chart = new Panel(living,
    { x: [0, times.at(-1)], y: [0, 1.05], width: 340, height: 300, margin: [34, 8, 26, 32],
    label: "Kinetic energy against time" });
  const slider = living.slider("step", { label: "time", least: 0, most: times.length - 1, at: 0,
    text: k => fixed(times[k], 2) });
  living.player(slider, 350);
  living.output("area of the ink", n => `${digits(n.area)} (exactly ${digits(n.exactArea)})`);
  living.output("vertices and triangles", n => `${n.vertices}, ${n.triangles}`);
  ways.forEach((way, k) => living.output(`energy, ${way}`, n => `${fixed(100 * n.energies[k], 1)} %`,
    looks[k]));

  return ({ step }) => {
    const { points, cells, ink } = frames[step], rim = pairs(rims[step]);
    const inked = cells.map(cell => cell.reduce((sum, i) => sum + ink[i], 0) / 3);
    box.draw(cells.map((cell, c) => {
      const corners = cell.map(i => box.at(points[i])).join(" "), part = Math.round(100 * inked[c]);
      const shade = `fill:color-mix(in srgb, var(--mls) ${part}%, transparent)`;
      return `<polygon class="mesh" ${part ? `style="${shade}"` : ""} points="${corners}"/>`;
    }), box.area(rim, "ls"));
    const now = energies.map(row => row[step]);
    chart.draw(chart.axes([0, 1, 2].filter(t => t <= times.at(-1)), [0, 0.5, 1],
      { xLabel: "time", yLabel: "kinetic energy / exact", yText: y => fixed(y, 1) }),
      energies.map((row, k) => [chart.path(row.map((e, i) => [times[i], e]), looks[k]),
        chart.dot([times[step], row[step]], 4.5, `fill ${looks[k] || "solid"}`)]),
      ways.map((way, k) => chart.text([0, 0.3 - 0.075 * k], way, looks[k], [8, 0])));
    return { area: cells.reduce((sum, cell, c) => sum + areaOf(cell.map(i => points[i])) * inked[c], 0),
      exactArea: areaOf(rim), vertices: points.length, triangles: cells.length, energies: now };
  };
});

function pairs(text) {
  const all = shorts(text);
  return Array.from({ length: all.length / 2 }, (_, i) => [all[2 * i] / 65535, all[2 * i + 1] / 65535]);
}

// A cell is three bytes: the increase of its lowest number, and how far the others are above it.
function unpacked(frame) {
  const triples = bytes(frame.cells), cells = [];
  for (let k = 0, low = 0; k < triples.length; k += 3) {
    low += triples[k];
    cells.push([low, low + triples[k + 1], low + triples[k + 2]]);
  }
  return { points: pairs(frame.points), cells, ink: [...bytes(frame.ink)].map(t => t / 255) };
}

// The area of a polygon.
function areaOf(points) {
  return Math.abs(points.reduce((sum, [x, y], k) => {
    const [u, v] = points[(k + 1) % points.length];
    return sum + x * v - y * u;
  }, 0)) / 2;
}
