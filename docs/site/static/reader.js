// Helps for readers; everything is readable without them.

// Long names are broken between their words.
for (const code of document.querySelectorAll(":not(pre) > code")) {
  const texts = document.createTreeWalker(code, NodeFilter.SHOW_TEXT), found = [];
  while (texts.nextNode()) found.push(texts.currentNode);
  for (const text of found) {
    const words = text.data.split(/(?<=[_/.=(])(?=\w)/);
    text.replaceWith(...words.flatMap((word, i) => i ? [document.createElement("wbr"), word] : [word]));
  }
}

// A formula that is too long is set smaller if that suffices, or gets the margin. Formulas and tables are
// marked where they can be scrolled.
for (const formula of document.querySelectorAll('.chapter math[display="block"]')) {
  const size = 0.99 * formula.clientWidth / formula.scrollWidth;
  if (0.7 < size && size < 0.99) formula.style.fontSize = `${size}em`;
}
for (const box of document.querySelectorAll('.chapter math[display="block"], .chapter .scroll, .table-wrapper')) {
  if (box.scrollWidth <= box.clientWidth + 1) continue;
  if (box.localName === "math") box.parentElement.classList.add("beyond");
  const mark = () => box.classList.toggle("cut", box.scrollWidth - box.scrollLeft > box.clientWidth + 1);
  box.addEventListener("scroll", mark, { passive: true });
  box.tabIndex = 0;
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
