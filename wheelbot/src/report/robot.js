// The robot as faces in space, in the frames of its model.

const WHEEL_RADIUS = 0.053;
const AXLE_HEIGHT = 0.11;
const RIM = 28;

// A wheel about an axle: its two sides in sectors of alternating shade, and its tread.
function wheelFaces(place, turn, axle, colours) {
  const half = 0.006;
  const rim = (k, side) => {
    const a = (2 * Math.PI * k) / RIM;
    const [c, s] = [WHEEL_RADIUS * Math.cos(a), WHEEL_RADIUS * Math.sin(a)];
    const point = axle === "y" ? [c, side * half, s] : [side * half, c, s];
    return sum(place, turned(turn, point));
  };
  const faces = [];
  for (let k = 0; k < RIM; k++) {
    for (const side of [-1, 1]) {
      const hub = sum(place, turned(turn, axle === "y" ? [0, side * half, 0] : [side * half, 0, 0]));
      faces.push({ corners: [hub, rim(k, side), rim(k + 1, side)], colour: colours[Math.floor((4 * k) / RIM) % 2] });
    }
    faces.push({ corners: [rim(k, -1), rim(k + 1, -1), rim(k + 1, 1), rim(k, 1)], colour: [45, 48, 52] });
  }
  return faces;
}

// The chassis: two posts that hold both axles, and a plate between them; forward is orange.
function boxFaces(place, turn, low, high, colour, front) {
  const corner = (i) => sum(place, turned(turn, [i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]]));
  const sides = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
  return sides.map((side, k) => ({ corners: side.map(corner), colour: k === 1 && front ? front : colour }));
}

// All faces at one state, and where the robot touches the floor.
function robotFaces(state) {
  const [x, y, roll, pitch, yaw, wheel, reaction] = state;
  const leaning = product(turnZ(yaw), turnX(roll));
  const hub = sum([x, y, 0], turned(leaning, [0, 0, WHEEL_RADIUS]));
  const body = product(leaning, turnY(pitch));
  const axle = sum(hub, turned(body, [0, 0, AXLE_HEIGHT]));
  const grey = [150, 158, 168];
  const orange = [213, 94, 0];
  const faces = [
    ...wheelFaces(hub, product(leaning, turnY(wheel)), "y", [[0, 114, 178], [120, 180, 215]]),
    ...wheelFaces(axle, product(body, turnX(reaction)), "x", [[0, 158, 115], [140, 205, 185]]),
  ];
  for (const side of [-1, 1]) {
    const [low, high] = side < 0 ? [-0.02, -0.012] : [0.012, 0.02];
    faces.push(...boxFaces(hub, body, [-0.012, low, -0.012], [0.012, high, 0.062], grey, orange));
    faces.push(...boxFaces(hub, body, [low, -0.012, 0.062], [high, 0.012, AXLE_HEIGHT + 0.012], grey, orange));
  }
  faces.push(...boxFaces(hub, body, [-0.045, -0.04, 0.054], [0.045, 0.04, 0.062], [110, 118, 128], orange));
  return { faces, contact: [x, y, 0], top: axle, heading: yaw };
}

// Draws floor, track, robot and push.
function drawRobot(context, camera, width, height, motion, index) {
  const { faces, contact, top, heading } = robotFaces(motion.states[index]);
  camera.target = [contact[0], contact[1], 0.09];
  camera.aim(width, height);
  context.fillStyle = "#f6f8fa";
  context.fillRect(0, 0, width, height);
  drawFloor(context, camera, contact);
  drawLine(context, camera, motion.states.slice(Math.max(0, index - 400), index + 1).map((q) => [q[0], q[1], 0]), "#d55e00", 2);
  const nearest = (face) => face.corners.reduce((total, p) => total + camera.depth(p), 0) / face.corners.length;
  for (const face of faces.sort((a, b) => nearest(b) - nearest(a))) drawFace(context, camera, face);
  const push = motion.pushes[index];
  if (push[0] !== 0 || push[1] !== 0) {
    const force = turned(turnZ(heading), [push[0], push[1], 0]);
    drawArrow(context, camera, difference(top, scaled(0.14, unit(force))), top);
  }
}

function drawFloor(context, camera, contact) {
  const step = 0.1;
  const [cx, cy] = [Math.round(contact[0] / step) * step, Math.round(contact[1] / step) * step];
  for (let k = -10; k <= 10; k++) {
    const a = k * step;
    drawLine(context, camera, [[cx + a, cy - 1, 0], [cx + a, cy + 1, 0]], "#d5dae0", 1);
    drawLine(context, camera, [[cx - 1, cy + a, 0], [cx + 1, cy + a, 0]], "#d5dae0", 1);
  }
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
