// A relief lit from the upper left, as grey levels; rows run upward. A step of one from cell to
// cell is a slope of `steepness`.
function shade(values, canvas, steepness) {
  const rows = values.length, columns = values[0].length, context = canvas.getContext("2d");
  const pixels = context.createImageData(columns, rows);
  const at = (i, j) => values[Math.min(rows - 1, Math.max(0, i))][Math.min(columns - 1,
    Math.max(0, j))];
  for (let i = 0; i < rows; i++)
    for (let j = 0; j < columns; j++) {
      const u = (at(i, j + 1) - at(i, j - 1)) / 2 * steepness,
        v = (at(i + 1, j) - at(i - 1, j)) / 2 * steepness;
      const grey = 255 * Math.max(0, (Math.SQRT1_2 + (u - v) / 2) / Math.hypot(u, v, 1));
      pixels.data.set([grey, grey, grey, 255], 4 * ((rows - 1 - i) * columns + j));
    }
  context.putImageData(pixels, 0, 0);
  return canvas.toDataURL();
}
