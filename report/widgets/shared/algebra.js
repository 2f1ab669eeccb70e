// Linear algebra of small dense matrices, as arrays of rows.

const EPS = 2 ** -52;

function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

function rms(values) { return Math.sqrt(dot(values, values) / values.length); }

// Solutions of A X = B by Gaussian elimination with partial pivoting; B has one row per equation.
function solve(a, b) {
  const n = a.length, rows = a.map((row, i) => [...row, ...b[i]]);
  for (let k = 0; k < n; k++) {
    let best = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[best][k])) best = i;
    [rows[k], rows[best]] = [rows[best], rows[k]];
    for (let i = k + 1; i < n; i++) {
      const factor = rows[i][k] / rows[k][k];
      if (factor) for (let j = k; j < rows[i].length; j++) rows[i][j] -= factor * rows[k][j];
    }
  }
  for (let k = n - 1; k >= 0; k--)
    for (let j = n; j < rows[k].length; j++) {
      for (let i = k + 1; i < n; i++) rows[k][j] -= rows[k][i] * rows[i][j];
      rows[k][j] /= rows[k][k];
    }
  return rows.map(row => row.slice(n));
}

// Eigenvalues of a symmetric matrix by Jacobi's rotations, in ascending order.
function eigenvalues(symmetric) {
  const a = symmetric.map(row => [...row]), n = a.length;
  for (let sweep = 0; sweep < 30; sweep++) {
    let off = 0, size = 0;
    for (let i = 0; i < n; i++)
      for (let j = 0; j < n; j++) (i === j) ? size += a[i][j] ** 2 : off += a[i][j] ** 2;
    if (off <= (EPS * EPS * size) / 4) break;
    for (let p = 0; p < n; p++)
      for (let q = p + 1; q < n; q++) rotate(a, p, q);
  }
  return a.map((row, i) => row[i]).sort((x, y) => x - y);
}

function rotate(a, p, q) {
  if (!a[p][q]) return;
  const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1), s = t * c;
  for (let k = 0; k < a.length; k++) {
    const x = a[k][p], y = a[k][q];
    a[k][p] = c * x - s * y;
    a[k][q] = s * x + c * y;
  }
  for (let k = 0; k < a.length; k++) {
    const x = a[p][k], y = a[q][k];
    a[p][k] = c * x - s * y;
    a[q][k] = s * x + c * y;
  }
}

// Singular values, in descending order, and right singular vectors as rows, by one-sided Jacobi.
function singular(matrix) {
  const n = matrix[0].length, columns = matrix[0].map((_, j) => matrix.map(row => row[j]));
  const vectors = columns.map((_, j) => columns.map((_, i) => Number(i === j)));
  const turn = (list, p, q, c, s) => list[p].forEach((x, k) => {
    [list[p][k], list[q][k]] = [c * x - s * list[q][k], s * x + c * list[q][k]];
  });
  const nothing = 1e-40 * columns.reduce((sum, column) => sum + dot(column, column), 0);
  for (let sweep = 0, turned = true; sweep < 40 && turned; sweep++) {
    turned = false;
    for (let p = 0; p < n; p++)
      for (let q = p + 1; q < n; q++) {
        const a = dot(columns[p], columns[p]), b = dot(columns[q], columns[q]),
          g = dot(columns[p], columns[q]);
        if (Math.abs(g) <= EPS * Math.sqrt(a * b) || Math.min(a, b) <= nothing) continue;
        turned = true;
        const zeta = (b - a) / (2 * g),
          t = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.hypot(zeta, 1));
        const c = 1 / Math.hypot(t, 1), s = t * c;
        turn(columns, p, q, c, s);
        turn(vectors, p, q, c, s);
      }
  }
  const values = columns.map(column => Math.hypot(...column));
  const ranked = values.map((_, j) => j).sort((i, j) => values[j] - values[i]);
  return { values: ranked.map(j => values[j]), vectors: ranked.map(j => vectors[j]) };
}
