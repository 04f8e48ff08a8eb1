// Curves over time as SVG.

const SVG = "http://www.w3.org/2000/svg";
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#1c2228"];
const [WIDTH, HEIGHT] = [600, 150];
const [LEFT, RIGHT, TOP, BOTTOM] = [52, 10, 8, 22];

function element(name, attributes, parent) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (parent) parent.appendChild(made);
  return made;
}

// Round numbers that cut a range into about `count` pieces.
function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const all = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) all.push(k * step);
  return all;
}

function written(value) {
  return String(Number(value.toPrecision(6)));
}

function caption(figure, title, names) {
  const text = figure.appendChild(document.createElement("figcaption"));
  text.textContent = title;
  names.forEach((name, k) => {
    const key = text.appendChild(document.createElement("span"));
    key.className = "key";
    key.style.color = COLOURS[k];
    key.textContent = `― ${name}`;
  });
}

// Adds a chart to the page; the answer moves its cursor to a time.
function addChart(chart, interval, seek) {
  const figure = document.getElementById("charts").appendChild(document.createElement("figure"));
  caption(figure, chart.title, chart.curves.map((curve) => curve[0]));
  const svg = figure.appendChild(element("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}` }));
  const all = chart.curves.flatMap((curve) => curve[1]).filter((v) => v !== null);
  let [low, high] = all.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  const margin = 0.06 * (high - low) || 1;
  [low, high] = [low - margin, high + margin];
  const end = interval * (chart.curves[0][1].length - 1);
  const x = (t) => LEFT + ((WIDTH - LEFT - RIGHT) * t) / end;
  const y = (v) => HEIGHT - BOTTOM - ((HEIGHT - TOP - BOTTOM) * (v - low)) / (high - low);
  for (const tick of ticks(low, high, 5)) {
    element("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(tick), y2: y(tick), stroke: "#e6e9ed" }, svg);
    element("text", { x: LEFT - 6, y: y(tick) + 4, "text-anchor": "end" }, svg).textContent = written(tick);
  }
  for (const tick of ticks(0, end, 8)) {
    element("text", { x: x(tick), y: HEIGHT - 5, "text-anchor": "middle" }, svg).textContent = written(tick) + (tick === 0 ? " s" : "");
  }
  chart.curves.forEach(([, values], k) => {
    const points = values.map((v, i) => (v === null ? "" : `${x(i * interval).toFixed(1)},${y(v).toFixed(1)}`));
    element("polyline", { points: points.join(" "), fill: "none", stroke: COLOURS[k], "stroke-width": 1.3 }, svg);
  });
  const cursor = element("line", { y1: TOP, y2: HEIGHT - BOTTOM, stroke: "#1c2228", "stroke-width": 1 }, svg);
  svg.addEventListener("click", (event) => {
    const box = svg.getBoundingClientRect();
    const place = ((event.clientX - box.left) / box.width) * WIDTH;
    seek(((place - LEFT) / (WIDTH - LEFT - RIGHT)) * end);
  });
  return (t) => {
    cursor.setAttribute("x1", x(t));
    cursor.setAttribute("x2", x(t));
  };
}
