// A machine: bodies as boxes of their inertia, frames, and what may touch a plane.

const { scene } = drawn;
const SHADES = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [110, 118, 128]];
const AXES = ["#d55e00", "#009e73", "#0072b2"];
const SIDES = 36;
// What is nearer to a plane than this share of the machine touches it.
const TOUCHING = 2e-3;

function turnOf([, , , x, y, z, w]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
  ];
}

const wanted = (name) => document.getElementById(name).checked;
for (const name of ["names", "frames", "contacts"]) document.getElementById(name).addEventListener("change", () => show());

// The middle of the bodies.
function middle(poses) {
  const total = scene.bodies.reduce((all, body) => sum(all, poses[body.pose].slice(0, 3)), [0, 0, 0]);
  return scaled(1 / Math.max(1, scene.bodies.length), total);
}

// The camera stays unless the machine goes away.
const start = middle(drawn.motion.states[0]);
const farthest = Math.max(...drawn.motion.states.map((poses) => Math.hypot(...difference(middle(poses), start))));
const follows = farthest > 0.7 * scene.size;

// The height of the squares: that of the first plane, or below everything that hangs.
const [plane] = scene.contacts.map((contact) => (contact.plane === null ? 0 : drawn.motion.states[0][contact.plane][2]));
const lowest = Math.min(...drawn.motion.states.flatMap((poses) => scene.bodies.map((body) => poses[body.pose][2])));
const ground = plane ?? Math.min(0, lowest - 0.1 * scene.size);

function drawMotion(context, camera, width, height, motion, index) {
  const poses = motion.states[index];
  camera.target = follows ? middle(poses) : start;
  camera.aim(width, height);
  context.fillStyle = "#f6f8fa";
  context.fillRect(0, 0, width, height);
  const step = 10 ** Math.floor(Math.log10(scene.size)) * (scene.size / 10 ** Math.floor(Math.log10(scene.size)) > 4 ? 1 : 0.25);
  drawFloor(context, camera, [camera.target[0], camera.target[1], ground], step);
  if (follows) drawLine(context, camera, trail(motion, index), "#b9c2cc", 1.5);
  const faces = [];
  scene.bodies.forEach((body, k) => faces.push(...faces_of(body, poses[body.pose], SHADES[k % SHADES.length])));
  for (const body of scene.bodies) {
    if (body.parent === null) continue;
    drawLine(context, camera, [poses[body.parent].slice(0, 3), poses[body.pose].slice(0, 3)], "#8a949e", 3);
  }
  drawFaces(context, camera, faces);
  if (wanted("contacts")) scene.contacts.forEach((contact) => drawContact(context, camera, contact, poses));
  if (wanted("frames")) scene.frames.forEach((frame) => drawAxes(context, camera, poses[frame.pose], wanted("names") ? frame.name : ""));
  if (wanted("names")) scene.bodies.forEach((body) => drawName(context, camera, place(body, poses[body.pose]), body.name));
}

// Where the machine was in the last frames, but for the present one if it is the only one.
function trail(motion, index) {
  const from = Math.max(0, index - 300);
  const points = motion.states.slice(from, index + 1).map(middle);
  return points.length === 2 ? [points[0], points[0], points[1]] : points;
}

const place = (body, pose) => sum(pose.slice(0, 3), turned(turnOf(pose), body.center));

function faces_of(body, pose, colour) {
  return boxFaces(place(body, pose), product(turnOf(pose), body.axes), scaled(-1, body.half), body.half, colour, null);
}

function drawName(context, camera, point, name) {
  const at = camera.seen(point);
  if (!at) return;
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = "#1c2228";
  context.fillText(name, at[0] + 8, at[1] - 8);
}

function drawAxes(context, camera, pose, name) {
  const [origin, turn] = [pose.slice(0, 3), turnOf(pose)];
  [0, 1, 2].forEach((k) => {
    const along = scaled(0.08 * scene.size, turn.map((row) => row[k]));
    drawLine(context, camera, [origin, sum(origin, along)], AXES[k], 2);
  });
  if (name) drawName(context, camera, origin, name);
}

// The shape's rim, and its nearest point where it touches.
function drawContact(context, camera, contact, poses) {
  const origin = poses[contact.pose].slice(0, 3);
  const turn = turnOf(poses[contact.pose]);
  const plane = contact.plane === null ? [0, 0, 0, 0, 0, 0, 1] : poses[contact.plane];
  const normal = turnOf(plane).map((row) => row[contact.normal]);
  const axis = turn.map((row) => row[contact.axis]);
  let arm = [0, 0, 0];
  if (contact.shape === "sphere") arm = scaled(-contact.radius, normal);
  if (contact.shape === "disc") {
    const across = difference(normal, scaled(dot(normal, axis), axis));
    const length = Math.hypot(...across);
    if (length > 1e-9) arm = scaled(-contact.radius / length, across);
    drawLine(context, camera, ring(origin, axis, contact.radius), "#1c2228", 1.5);
  }
  if (contact.shape === "sphere") drawLine(context, camera, ring(origin, camera.back, contact.radius), "#1c2228", 1.5);
  const nearest = sum(origin, arm);
  const gap = dot(normal, difference(nearest, plane.slice(0, 3)));
  const at = camera.seen(nearest);
  if (!at) return;
  const touches = gap < TOUCHING * scene.size;
  context.beginPath();
  context.arc(at[0], at[1], touches ? 5 : 2.5, 0, 2 * Math.PI);
  context.fillStyle = touches ? "#94211a" : "#8a949e";
  context.fill();
}

function ring(origin, axis, radius) {
  const helper = Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const first = unit(cross(axis, helper));
  const second = cross(axis, first);
  return Array.from({ length: SIDES + 1 }, (_, k) => {
    const angle = (2 * Math.PI * k) / SIDES;
    return sum(origin, sum(scaled(radius * Math.cos(angle), first), scaled(radius * Math.sin(angle), second)));
  });
}
