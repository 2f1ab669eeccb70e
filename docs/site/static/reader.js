// Helps for readers; everything is readable without them.

// Long names are broken between their words, options are not.
const BETWEEN_PARTS = /(?<=\w[_/.=(])(?=\w)/, BETWEEN_WORDS = /(?<=\w[_/.=(])(?=\w)|(?<=[a-z])(?=[A-Z][a-z])/, NOWHERE = /(?!)/;

function breaksOf(text) {
  if (text.parentElement.closest(".provenance, .data")) return NOWHERE;   // a command breaks at its spaces
  return /\w{20}/.test(text.data) ? BETWEEN_WORDS : BETWEEN_PARTS;
}

function breakBetweenWords(text) {
  const words = text.data.split(breaksOf(text));
  text.replaceWith(...words.flatMap((word, i) => {
    const parts = word.split(/((?<!\S)--?\w[\w-]*)/).map((part, k) => k % 2 ? unbroken(part) : part);
    return i ? [document.createElement("wbr"), ...parts] : parts;
  }));
}

function unbroken(text) {
  const span = document.createElement("span");
  span.className = "unbroken";
  span.textContent = text;
  return span;
}

for (const code of document.querySelectorAll(":not(pre) > code, .classifier, h1, .related-pages .title")) {
  const texts = document.createTreeWalker(code, NodeFilter.SHOW_TEXT), found = [];
  while (texts.nextNode()) found.push(texts.currentNode);
  found.forEach(breakBetweenWords);
}

// A formula that is too long is broken at its wide spaces; if that does not suffice, before its further
// relations, and then before its sums. One that still is too long is set smaller if that suffices, or
// gets the margin. Formulas, tables and drawings are marked where they can be scrolled.
const SMALLEST = 0.65;   // of the size of the text

const isOperator = (part, signs) => part?.localName === "mo" && signs.includes(part.textContent);
const isWide = part => part.localName === "mspace" && parseFloat(part.getAttribute("width")) >= 1;
const isRelation = (part, before) => isOperator(part, RELATIONS) && before.some(p => isOperator(p, RELATIONS));
const isSum = (part, before) => isOperator(part, "+−-") && before.length && before.at(-1).localName !== "mo";
const RELATIONS = "=≤≥≈";

// The parts of a line, cut before those at which it breaks, outside of parentheses; a wide space is left out.
function cut(parts, breaks) {
  const lines = [[]];
  let depth = 0;
  parts.forEach((part, k) => {
    if (!depth && breaks(part, parts.slice(0, k))) lines.push([]);
    if (breaks !== isWide || !isWide(part)) lines.at(-1).push(part);
    for (const c of part.textContent) depth += "([{".includes(c) - ")]}".includes(c);
  });
  return lines;
}

function breakFormula(formula, breaks) {
  const make = name => document.createElementNS(formula.namespaceURI, name);
  const content = formula.querySelector("semantics").firstElementChild;
  if (content.localName === "mtable") return [...content.children].forEach(row => breakRow(row, breaks));
  const lines = cut([...content.children], breaks);
  if (lines.length === 1) return;
  const table = make("mtable");
  table.setAttribute("displaystyle", "true");
  for (const line of lines) table.appendChild(make("mtr")).appendChild(make("mtd")).append(...line);
  content.replaceWith(table);
}

// The last cell of a row of aligned formulas continues in further rows.
function breakRow(row, breaks) {
  const cell = row.lastElementChild, [first, ...further] = cut([...cell.children], breaks);
  if (!further.length) return;
  cell.replaceChildren(...first);
  row.after(...further.map(line => {
    const next = row.cloneNode(true);
    for (const empty of next.children) empty.replaceChildren();
    next.lastElementChild.append(...line);
    return next;
  }));
}

const visible = formula => formula.clientWidth / formula.scrollWidth;

function fit(formula) {
  if (visible(formula) < 0.99) breakFormula(formula, isWide);
  for (const breaks of [isRelation, isSum]) if (visible(formula) <= SMALLEST) breakFormula(formula, breaks);
  const size = 0.99 * visible(formula);
  if (SMALLEST < size && size < 0.989) formula.style.fontSize = `${size}em`;
}

// What is folded or hidden has no width yet.
function whenShown(element, action) {
  if (element.clientWidth) return action(element);
  const observer = new ResizeObserver(() => {
    if (!element.clientWidth) return;
    observer.disconnect();
    action(element);
  });
  observer.observe(element);
}

for (const formula of document.querySelectorAll('.chapter math[display="block"]')) whenShown(formula, fit);
for (const formula of document.querySelectorAll('.chapter math:not([display="block"])')) {
  const room = formula.closest("p, li, dd, td, figcaption");
  const size = room && room.clientWidth / formula.getBoundingClientRect().width;
  if (size < 1) formula.style.fontSize = `${size}em`;
}

// Drawings keep a size at which their smallest letters can be read, and may be scrolled instead.
const LETTERS = 11;   // pixels

// The size of a text is that of its largest letters; its indices are smaller.
function sizeOf(text) {
  const parts = [text, ...text.querySelectorAll("tspan")];
  const written = parts.filter(part => [...part.childNodes].some(child => child.nodeType === Node.TEXT_NODE && child.data.trim()));
  return Math.max(...written.map(part => parseFloat(getComputedStyle(part).fontSize)));
}

for (const picture of document.querySelectorAll("p > svg.picture")) picture.parentElement.classList.add("drawing");
for (const picture of document.querySelectorAll(".chapter figure > svg.picture")) {
  const sizes = [...picture.querySelectorAll("text")].map(sizeOf).filter(size => size > 0);
  const least = LETTERS / Math.min(...sizes) * picture.viewBox.baseVal.width;
  const column = picture.parentElement.clientWidth * parseFloat(picture.style.width) / 100;
  if (!(column < 0.99 * least)) continue;
  const box = document.createElement("div");
  box.className = "drawing";
  picture.replaceWith(box);
  box.append(picture);
  picture.style.minWidth = `${least}px`;
}

// So do pictures of the gallery, whose letters of 10 points have 20 pixels of the file.
const SMALL = 0.75;   // of the size at which letters have ten pixels

for (const picture of document.querySelectorAll("img.sphx-glr-single-img")) {
  const box = document.createElement("div");
  box.className = "drawing";
  picture.replaceWith(box);
  box.append(picture);
  const enlarge = () => {
    const least = picture.naturalWidth / 2;
    if (box.clientWidth < SMALL * least) picture.style.cssText = `width: ${least}px; max-width: none`;
  };
  if (picture.complete) enlarge();
  else picture.addEventListener("load", enlarge);
}

// On a narrow screen a table of text has its third column below the first two. Where the fourth is long
// as well, each further column has a line of its own, which begins with its head.
for (const table of document.querySelectorAll(":is(.chapter .scroll, .table-wrapper) > table:not(.result, .names)")) {
  const rows = [...table.rows], heads = rows[0].cells;
  const longest = column => Math.max(...rows.map(row => row.cells[column]?.textContent.length || 0));
  if (heads.length > 4 || Math.max(longest(2), longest(3)) <= 25) continue;
  table.classList.add(longest(3) > 12 ? "listed" : "stacked");
  if (longest(3) > 12) rows.slice(1).forEach(row => [...row.cells].slice(1).forEach(cell => putHead(cell, heads[cell.cellIndex])));
}

function putHead(cell, head) {
  const name = document.createElement("span"), content = document.createElement("span");
  name.className = "head";
  name.append(...head.cloneNode(true).childNodes);
  content.append(...cell.childNodes);
  cell.append(name, content);
}

// On a wide screen code and tables that are too long reach into the free space on the right.
function widen(boxes) {
  const contents = document.querySelector(".toc-drawer");
  const isBeside = contents?.offsetWidth && getComputedStyle(contents).position !== "fixed";
  const end = isBeside ? contents.getBoundingClientRect().left : document.documentElement.clientWidth;
  const outer = boxes.map(box => box.closest('div[class*="highlight-"]') || box.closest(".highlight") || box);
  outer.forEach(box => box.style.removeProperty("--wide"));
  const lacks = boxes.map(box => lack(box));
  const places = outer.map(box => box.getBoundingClientRect());
  outer.forEach((box, k) => {
    const more = Math.min(lacks[k], end - MARGIN - places[k].right);
    if (more > 0) box.style.setProperty("--wide", `${places[k].width + more}px`);
  });
}

// A table that is too long has lines broken in its cells, too, and takes all the room.
const lack = box => box.scrollWidth - box.clientWidth && (box.localName === "pre" ? box.scrollWidth - box.clientWidth : Infinity);

const MARGIN = 24;   // pixels
const LONG = ":is(.chapter pre, .highlight pre, .chapter .scroll, .table-wrapper):not(:is(.statement, .admonition, .preview, td) *)";
const long = [...document.querySelectorAll(LONG)];
if (long.length) new ResizeObserver(() => widen(long)).observe(document.documentElement);

const MAY_SCROLL = '.chapter math[display="block"], .chapter .scroll, .table-wrapper, .drawing, .chapter pre, .highlight pre';
for (const box of document.querySelectorAll(MAY_SCROLL)) {
  const mark = () => {
    const wide = box.scrollWidth > box.clientWidth + 1;
    box.classList.toggle("cut", box.scrollWidth - box.scrollLeft > box.clientWidth + 1);
    if (wide && box.localName === "math") box.parentElement.classList.add("beyond");
    if (wide) box.tabIndex = 0;
  };
  box.addEventListener("scroll", mark, { passive: true });
  new ResizeObserver(mark).observe(box);
  mark();
}

// A button at each listing copies its text, without the prompts of Python.
for (const box of document.querySelectorAll("div.highlight, .chapter pre")) {
  if (box.parentElement.closest("div.highlight") || box.closest(".sphx-glr-script-out")) continue;
  const button = document.createElement("button");
  button.className = "copy";
  button.textContent = "Copy";
  button.setAttribute("aria-label", "Copy this code");
  button.addEventListener("click", async () => {
    const lines = (box.querySelector("pre") || box).innerText.replace(/\s*Copy$/, "").split("\n");
    const typed = lines.filter(line => /^(>>>|\.\.\.)( |$)/.test(line)).map(line => line.slice(4));
    await copy((typed.length ? typed : lines).join("\n"));
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
  box.classList.add("copied-from");
  box.append(button);
}

async function copy(text) {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const field = document.body.appendChild(document.createElement("textarea"));
  field.value = text;
  field.select();
  document.execCommand("copy");
  field.remove();
}

// A link to an equation, a statement, a table or a work shows it, and a link to a figure of this page.
// The page contains copies of those in other chapters.
const preview = document.body.appendChild(document.createElement("div"));
preview.className = "preview chapter";
preview.hidden = true;

const copies = document.querySelector("template.previews");

function targetOf(link) {
  const label = decodeURIComponent(link.hash.slice(1));
  if (link.getAttribute("href").startsWith("#")) return document.getElementById(label);
  return copies && copies.content.querySelector(`[data-label="${CSS.escape(label)}"]`);
}

function show(link) {
  const target = targetOf(link);
  if (!target || target.tagName === "SECTION") return;
  preview.replaceChildren(target.cloneNode(true));
  preview.querySelectorAll("[id]").forEach(part => part.removeAttribute("id"));
  preview.querySelectorAll("img").forEach(image => (image.loading = "eager"));
  preview.hidden = false;
  const place = link.getBoundingClientRect(), size = preview.getBoundingClientRect();
  const below = place.bottom + 8 + size.height < innerHeight || place.top < size.height;
  preview.style.left = `${Math.max(8, Math.min(place.left, innerWidth - size.width - 8))}px`;
  preview.style.top = `${below ? place.bottom + 8 : place.top - size.height - 8}px`;
}

for (const link of document.querySelectorAll('.chapter a[href*="#"]:not(.headerlink)')) {
  for (const event of ["mouseenter", "focus"]) link.addEventListener(event, () => show(link));
  for (const event of ["mouseleave", "blur"]) link.addEventListener(event, () => (preview.hidden = true));
}
document.addEventListener("keydown", event => event.key === "Escape" && (preview.hidden = true));
