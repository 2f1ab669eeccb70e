// One fit of moving least squares, of degree 0 or 1 in two variables, about the query (x, y).
//
// counts are the squared weights. Sums are taken about the weighted mean of the sites, so that the
// normal equations of the slope do not lose the small differences near a site.
function movingFit(sites, values, counts, [x, y], degree, without = -1) {
  const n = sites.length;
  let total = 0, mx = 0, my = 0, mf = 0;
  for (let i = 0; i < n; i++) {
    if (i === without) continue;
    total += counts[i];
    mx += counts[i] * (sites[i][0] - x);
    my += counts[i] * (sites[i][1] - y);
    mf += counts[i] * values[i];
  }
  mx /= total; my /= total; mf /= total;
  if (degree === 0) return { value: mf, slope: [0, 0], mean: [mx, my], level: mf };
  let xx = 0, xy = 0, yy = 0, xf = 0, yf = 0;
  for (let i = 0; i < n; i++) {
    if (i === without) continue;
    const u = sites[i][0] - x - mx, v = sites[i][1] - y - my, f = values[i] - mf, c = counts[i];
    xx += c * u * u; xy += c * u * v; yy += c * v * v; xf += c * u * f; yf += c * v * f;
  }
  const determinant = xx * yy - xy * xy;
  const slope = [(yy * xf - xy * yf) / determinant, (xx * yf - xy * xf) / determinant];
  return { value: mf - slope[0] * mx - slope[1] * my, slope, mean: [mx, my], level: mf };
}

// The minimized objective: half the sum of the squared weighted residuals of a fit.
function objective(sites, values, counts, [x, y], { slope, mean, level }) {
  let sum = 0;
  for (let i = 0; i < sites.length; i++) {
    const u = sites[i][0] - x - mean[0], v = sites[i][1] - y - mean[1];
    const residual = values[i] - level - slope[0] * u - slope[1] * v;
    sum += counts[i] * residual * residual;
  }
  return sum / 2;
}

// The squares of the weights 1 / (r² + ε²).
function inverseSquares(sites, [x, y], epsilon, counts) {
  for (let i = 0; i < sites.length; i++) {
    const u = sites[i][0] - x, v = sites[i][1] - y, w = 1 / (u * u + v * v + epsilon * epsilon);
    counts[i] = w * w;
  }
  return counts;
}
