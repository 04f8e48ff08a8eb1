// Maps and clouds of runs as SVG: blue where the robot stood.

// Adds a map.
function addMap(map) {
  const figure = document.getElementById("maps").appendChild(document.createElement("figure"));
  caption(figure, map.title, []);
  const [size, edge] = [300, 46];
  const svg = figure.appendChild(element("svg", { viewBox: `0 0 ${size + edge + 10} ${size + edge}` }));
  const cell = size / map.values.length;
  map.stood.forEach((row, j) =>
    row.forEach((stood, i) => {
      const place = { x: edge + i * cell, y: size - (j + 1) * cell, width: cell + 0.3, height: cell + 0.3 };
      element("rect", { ...place, fill: stood ? "#0072b2" : "#e6e9ed" }, svg);
    }),
  );
  map.values.forEach((value, k) => {
    if (k % 6) return;
    const at = (k + 0.5) * cell;
    element("text", { x: edge + at, y: size + 16, "text-anchor": "middle" }, svg).textContent = written(value);
    element("text", { x: edge - 6, y: size - at + 4, "text-anchor": "end" }, svg).textContent = written(value);
  });
  element("text", { x: edge + size / 2, y: size + 36, "text-anchor": "middle" }, svg).textContent = map.axes[0];
  const upright = { x: -size / 2, y: 12, transform: "rotate(-90)", "text-anchor": "middle" };
  element("text", upright, svg).textContent = map.axes[1];
}

// Adds a cloud: a run is a point, filled where the robot stood.
function addCloud(cloud) {
  const figure = document.getElementById("maps").appendChild(document.createElement("figure"));
  caption(figure, cloud.title, []);
  const [size, edge] = [300, 62];
  const svg = figure.appendChild(element("svg", { viewBox: `0 0 ${size + edge + 10} ${size + edge}` }));
  const scale = (axis) => {
    const all = cloud.points.map((point) => point[axis]);
    const [low, high] = [Math.min(...all), Math.max(...all)];
    const margin = 0.05 * (high - low) || 1;
    return { low: low - margin, high: high + margin, share: (v) => (v - low + margin) / (high - low + 2 * margin) };
  };
  const [across, up] = [scale(0), scale(1)];
  const x = (v) => edge + size * across.share(v);
  const y = (v) => size * (1 - up.share(v));
  for (const tick of ticks(across.low, across.high, 5)) {
    element("line", { x1: x(tick), x2: x(tick), y1: 0, y2: size, stroke: "#e6e9ed" }, svg);
    element("text", { x: x(tick), y: size + 16, "text-anchor": "middle" }, svg).textContent = written(tick);
  }
  for (const tick of ticks(up.low, up.high, 5)) {
    element("line", { x1: edge, x2: edge + size, y1: y(tick), y2: y(tick), stroke: "#e6e9ed" }, svg);
    element("text", { x: edge - 6, y: y(tick) + 4, "text-anchor": "end" }, svg).textContent = written(tick);
  }
  cloud.points.forEach(([a, b], k) => {
    const colour = cloud.stood[k] ? "#0072b2" : "#d55e00";
    const fill = cloud.stood[k] ? "#0072b2" : "#ffffff";
    element("circle", { cx: x(a), cy: y(b), r: cloud.stood[k] ? 3 : 4.5, fill, stroke: colour, "stroke-width": 1.6 }, svg);
  });
  element("text", { x: edge + size / 2, y: size + 36, "text-anchor": "middle" }, svg).textContent = cloud.axes[0];
  const upright = { x: -size / 2, y: 12, transform: "rotate(-90)", "text-anchor": "middle" };
  element("text", upright, svg).textContent = cloud.axes[1];
}

drawn.maps.forEach(addMap);
drawn.clouds.forEach(addCloud);
