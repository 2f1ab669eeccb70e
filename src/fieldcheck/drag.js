// Brings the picture of drag.py to life; DATA stands for what that wrote.
(() => {
  const mine = document.currentScript && document.currentScript.closest(".fieldcheck-drag");
  const roots = mine ? [mine] : [...document.querySelectorAll(".fieldcheck-drag")];
  const root = roots.find(r => r.querySelector("img"));
  if (!root) return;
  const d = DATA;
  const image = root.querySelector("img");
  const text = atob(image.src.split(",")[1]);
  const svg = document.importNode(
    new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
  image.replaceWith(svg);
  const part = name => svg.querySelector(`[data-part="${name}"]`);
  const set = (name, pairs) => {
    for (const key in pairs) part(name).setAttribute(key, pairs[key]);
  };
  const n = d.corners.length, [scale, u, v] = d.frame;
  const middle = [0, 1].map(k => d.corners.reduce((sum, p) => sum + p[k], 0) / n);
  svg.removeAttribute("height");
  svg.style.cssText = "width:100%;cursor:grab;touch-action:none;user-select:none";
  root.tabIndex = 0;
  root.dataset.lmSuppressShortcuts = "true";
  root.setAttribute("role", "application");
  root.setAttribute("aria-label", image.alt + ". Drag the point, or use the arrow keys.");
  set("hint", {visibility: "visible"});
  part("value").setAttribute("aria-live", "polite");

  function weights(x, y) {
    const i = (x - d.origin[0]) / d.step, j = (y - d.origin[1]) / d.step;
    const i0 = Math.floor(i), j0 = Math.floor(j), w = new Array(n).fill(0);
    let found = 0;
    for (const [a, b] of [[0, 0], [1, 0], [0, 1], [1, 1]]) {
      const row = d.table[(j0 + b) * d.across + i0 + a];
      if (!row) continue;
      const share = (a ? i - i0 : 1 - i + i0) * (b ? j - j0 : 1 - j + j0);
      found += share;
      row.forEach((count, k) => { w[k] += share * count * 1e-4; });
    }
    return w.map(weight => weight / found);
  }

  function inside(x, y) {
    const away = [x - middle[0], y - middle[1]];
    let part = 1;
    for (const [a, b, c] of d.walls) {
      const reach = 0.985 * (c - a * middle[0] - b * middle[1]);
      const height = a * away[0] + b * away[1];
      if (height > reach) part = Math.min(part, reach / height);
    }
    return [middle[0] + part * away[0], middle[1] + part * away[1]];
  }

  let at = d.at;
  function move(x, y) {
    at = inside(x, y);
    const w = weights(...at);
    const px = scale * at[0] + u, py = v - scale * at[1];
    let sum = 0, value = 0, mean = [0, 0];
    w.forEach((weight, k) => {
      const size = Math.min(1, Math.max(0, weight));
      sum += weight;
      value += weight * d.values[k];
      mean = mean.map((m, c) => m + weight * d.corners[k][c]);
      set("dot" + k, {r: 26 * Math.sqrt(size)});
      set("bar" + k, {width: 92 * size});
      set("ray" + k, {x1: px, y1: py});
      part("number" + k).textContent = weight.toFixed(3);
    });
    set("point", {cx: px, cy: py});
    set("mean", {cx: scale * mean[0] + u, cy: v - scale * mean[1]});
    part("sum").textContent = "sum of the weights " + sum.toFixed(3);
    part("value").textContent = "value at the point " + value.toFixed(3);
  }

  let held = false;
  const follow = event => {
    const box = svg.getBoundingClientRect(), pixel = svg.viewBox.baseVal.width / box.width;
    move(((event.clientX - box.left) * pixel - u) / scale,
         (v - (event.clientY - box.top) * pixel) / scale);
  };
  svg.addEventListener("pointerdown", event => {
    held = true;
    svg.setPointerCapture(event.pointerId);
    root.focus({preventScroll: true});
    follow(event);
    event.preventDefault();
  });
  svg.addEventListener("pointermove", event => { if (held) follow(event); });
  for (const end of ["pointerup", "pointercancel"])
    svg.addEventListener(end, () => { held = false; });
  root.addEventListener("keydown", event => {
    const step = (event.shiftKey ? 1 : 6) / scale;
    const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
    if (event.key === "Home") move(...d.at);
    else if (way[event.key])
      move(at[0] + step * way[event.key][0], at[1] + step * way[event.key][1]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
})();
