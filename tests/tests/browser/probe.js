// Measures the page that it stands in, as it is laid out, and tells the page around it:
//   problems  [{rule, what}]  what is wrong, by the rule it breaks
//   the rest  what a reader sees, for the test to compare
"use strict";

const SLACK = 0.6; // px: rounding of layout
const problems = [];
const report = (rule, what) => problems.push({ rule, what });

const short = (text) => text.trim().replace(/\s+/g, " ").slice(0, 60);
const named = (element) => {
  const id = element.id ? `#${element.id}` : "";
  return `<${element.tagName.toLowerCase()}${id}> “${short(element.textContent)}”`;
};

const isVisible = (box) => box.width > 0 && box.height > 0;
const overlap = (a, b) =>
  Math.min(a.right, b.right) - Math.max(a.left, b.left) > SLACK &&
  Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > SLACK;
const contains = (outer, inner) =>
  inner.left >= outer.left - SLACK && inner.right <= outer.right + SLACK &&
  inner.top >= outer.top - SLACK && inner.bottom <= outer.bottom + SLACK;

function* pairs(items) {
  for (let i = 0; i < items.length; i++)
    for (let j = i + 1; j < items.length; j++) yield [items[i], items[j]];
}

const isNumber = (text) => /^-?\d+(\.\d+)?$/.test(text);

// What is drawn, without the background that fills the figure.
function marks(svg, frame) {
  const drawn = svg.querySelectorAll("polyline, polygon, path, line, circle, rect");
  const boxes = [...drawn].map((mark) => mark.getBoundingClientRect());
  return boxes.filter((box) => box.width < frame.width - 1 || box.height < frame.height - 1);
}

// Titles of the axes: the ordinates' stands above the middle, the abscissas' below.
function titles(texts, frame) {
  const middle = frame.top + frame.height / 2;
  const sides = { y: [], x: [] };
  for (const { text, box } of texts)
    if (!isNumber(text)) sides[box.top + box.height / 2 < middle ? "y" : "x"].push(text);
  return [sides.y.join(""), sides.x.join("")];
}

function figure(svg) {
  const frame = svg.getBoundingClientRect();
  const elements = [...svg.querySelectorAll("text")];
  const texts = elements.map((e) => ({
    text: e.textContent.trim(), box: e.getBoundingClientRect(),
  }));
  for (const [a, b] of pairs(texts))
    if (overlap(a.box, b.box)) report("figure text overlaps", `“${a.text}” and “${b.text}”`);
  for (const { text, box } of texts)
    if (!contains(frame, box)) report("figure text leaves", `“${text}”`);
  const boxes = marks(svg, frame);
  for (const { text, box } of texts)
    if (boxes.some((mark) => overlap(mark, box))) report("figure text is drawn over", `“${text}”`);
  const axes = titles(texts, frame);
  for (const title of axes)
    if (!/ ?\[[^\]?]+\]$/.test(title)) report("axis without unit", `“${title}”`);
  const curves = [...svg.querySelectorAll("polyline, circle, path")];
  const sized = curves.filter((c) => c.getBoundingClientRect().width > 0);
  if (sized.length === 0) report("empty figure", axes.join(", "));
  if (/NaN|undefined|Infinity/.test(svg.outerHTML)) report("not a number", axes.join(", "));
  const numbers = texts.filter(({ text }) => isNumber(text)).length;
  if (numbers < 4) report("axes without numbers", axes.join(", "));
  const size = (text) =>
    parseFloat(getComputedStyle(text).fontSize) * (frame.width / svg.viewBox.baseVal.width);
  return { axes, curves: sized.length, smallest: Math.min(...elements.map(size)) };
}

const scrolls = (element) => /auto|scroll/.test(getComputedStyle(element).overflowX);
const scroller = (element) => {
  for (let e = element.parentElement; e; e = e.parentElement) if (scrolls(e)) return e;
  return null;
};

// No block leaves the window, and none is cut off; what is wide scrolls in its own place.
function blocks(elements) {
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) report("page scrolls sideways", `${width} px`);
  for (const element of elements) {
    const { overflowX, display } = getComputedStyle(element);
    const box = element.getBoundingClientRect();
    const isOutside = box.left < -SLACK || box.right > width + SLACK;
    if (isOutside && !scroller(element)) report("block leaves the window", named(element));
    if (display.startsWith("inline")) continue;
    const spills = element.scrollWidth > element.clientWidth + 1
      || (overflowX !== "visible" && element.scrollHeight > element.clientHeight + 1);
    if (spills && !scrolls(element)) report("text is cut off", named(element));
  }
}

// Neighbours in the tree; cells may share a border.
function siblings(elements) {
  for (const parent of elements) {
    const children = [...parent.children].filter((child) =>
      child instanceof HTMLElement && !getComputedStyle(child).display.startsWith("inline"));
    const boxes = children.map((child) => child.getBoundingClientRect());
    for (const [i, j] of pairs([...children.keys()])) {
      const [a, b] = [boxes[i], boxes[j]];
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const along = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1.5 && along > 1.5)
        report("blocks overlap", `${named(children[i])} and ${named(children[j])}`);
    }
  }
}

// A column must hold a few letters side by side.
function cells() {
  for (const cell of document.querySelectorAll("td, th")) {
    const { clientWidth, innerText } = cell;
    const isNarrow = clientWidth < 3 * parseFloat(getComputedStyle(cell).fontSize);
    if (isNarrow && innerText.trim().length > 9) report("cell is squeezed", named(cell));
  }
}

// Lines of text outside figures, as far as they are not scrolled out of sight.
function lines() {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const found = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const parent = node.parentElement;
    if (!node.data.trim() || parent.closest("svg, script")) continue;
    const window = scroller(parent)?.getBoundingClientRect();
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const box of range.getClientRects())
      if (isVisible(box) && (!window || overlap(window, box)))
        found.push({ node, box, text: short(node.data) });
  }
  return found;
}

function words() {
  for (const [a, b] of pairs(lines()))
    if (a.node !== b.node && overlap(a.box, b.box))
      report("text overlaps", `“${a.text}” and “${b.text}”`);
  const text = document.body.innerText;
  for (const word of ["NaN", "undefined", "null", "[object"])
    if (text.includes(word)) report("not a number", word);
}

function measure() {
  const elements = [...document.body.querySelectorAll("*")].filter((e) =>
    e instanceof HTMLElement && e.tagName !== "SCRIPT");
  blocks(elements);
  siblings([document.body, ...elements]);
  cells();
  words();
  const figures = [...document.querySelectorAll("svg")].map(figure);
  const headings = [...document.querySelectorAll("h1, h2, h3")];
  for (const heading of headings)
    if (!isVisible(heading.getBoundingClientRect())) report("heading is hidden", named(heading));
  const resources = performance.getEntriesByType("resource").map((entry) => entry.name);
  for (const name of resources) report("request", name);
  const row = (tr) => [...tr.cells].map((cell) => cell.innerText.trim());
  return {
    problems, figures, resources,
    width: document.documentElement.clientWidth,
    height: document.documentElement.scrollHeight,
    title: document.querySelector("h1")?.innerText,
    headings: headings.map((heading) => heading.innerText.trim()),
    errors: [...document.querySelectorAll("#errors tr")].map(row),
  };
}

addEventListener("load", () => parent.postMessage(measure(), "*"));
