// Floor, lines, faces and arrows on a canvas.

// A box between two corners in a turned frame at a place; `front` is the colour of the side that looks along +x.
function boxFaces(place, turn, low, high, colour, front) {
  const corner = (i) => sum(place, turned(turn, [i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]]));
  const sides = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
  return sides.map((side, k) => ({ corners: side.map(corner), colour: k === 1 && front ? front : colour }));
}

// Squares of this width about a point, at its height.
function drawFloor(context, camera, middle, step) {
  const [cx, cy] = [Math.round(middle[0] / step) * step, Math.round(middle[1] / step) * step];
  const end = 10 * step;
  for (let k = -10; k <= 10; k++) {
    const a = k * step;
    drawLine(context, camera, [[cx + a, cy - end, middle[2]], [cx + a, cy + end, middle[2]]], "#d5dae0", 1);
    drawLine(context, camera, [[cx - end, cy + a, middle[2]], [cx + end, cy + a, middle[2]]], "#d5dae0", 1);
  }
}

// The farthest first.
function drawFaces(context, camera, faces) {
  const nearest = (face) => face.corners.reduce((total, p) => total + camera.depth(p), 0) / face.corners.length;
  for (const face of faces.sort((a, b) => nearest(b) - nearest(a))) drawFace(context, camera, face);
}

// Cut into short pieces, of which those behind the camera are left out.
function drawLine(context, camera, points, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  let before = null;
  const all = points.length === 2 ? Array.from({ length: 21 }, (_, k) => sum(scaled(1 - k / 20, points[0]), scaled(k / 20, points[1]))) : points;
  for (const point of all) {
    const place = camera.seen(point);
    if (place && before) context.lineTo(...place);
    else if (place) context.moveTo(...place);
    before = place;
  }
  context.stroke();
}

function drawFace(context, camera, face) {
  const places = face.corners.map((p) => camera.seen(p));
  if (places.includes(null)) return;
  const normal = unit(cross(difference(face.corners[1], face.corners[0]), difference(face.corners[2], face.corners[0])));
  const light = 0.72 + 0.28 * Math.abs(dot(normal, unit([0.4, -0.5, 0.8])));
  context.fillStyle = `rgb(${face.colour.map((c) => Math.round(c * light)).join(",")})`;
  context.strokeStyle = context.fillStyle;
  context.lineWidth = 1;
  context.beginPath();
  places.forEach((p, k) => (k ? context.lineTo(...p) : context.moveTo(...p)));
  context.closePath();
  context.fill();
  context.stroke();
}

function drawArrow(context, camera, from, to) {
  const [a, b] = [camera.seen(from), camera.seen(to)];
  if (!a || !b) return;
  const along = Math.atan2(b[1] - a[1], b[0] - a[0]);
  context.strokeStyle = "#94211a";
  context.lineWidth = 4;
  context.beginPath();
  context.moveTo(...a);
  context.lineTo(...b);
  for (const side of [-1, 1]) {
    context.moveTo(...b);
    context.lineTo(b[0] - 14 * Math.cos(along + 0.5 * side), b[1] - 14 * Math.sin(along + 0.5 * side));
  }
  context.stroke();
}
