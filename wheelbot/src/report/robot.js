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

// All faces at one state, and where the robot touches the floor.
function robotFaces(state, lift) {
  const [x, y, roll, pitch, yaw, wheel, reaction] = state;
  const leaning = product(turnZ(yaw), turnX(roll));
  const hub = sum([x, y, lift], turned(leaning, [0, 0, WHEEL_RADIUS]));
  const body = product(leaning, turnY(pitch));
  const axle = sum(hub, turned(body, [0, 0, AXLE_HEIGHT]));
  const grey = [150, 158, 168];
  const orange = [213, 94, 0];
  const faces = [
    ...wheelFaces(hub, product(leaning, turnY(wheel)), "y", [[0, 114, 178], [120, 180, 215]]),
    ...wheelFaces(axle, product(body, turnX(reaction)), "x", [[0, 158, 115], [140, 205, 185]]),
  ];
  // The chassis: two posts that hold both axles, and a plate between them; forward is orange.
  for (const side of [-1, 1]) {
    const [low, high] = side < 0 ? [-0.02, -0.012] : [0.012, 0.02];
    faces.push(...boxFaces(hub, body, [-0.012, low, -0.012], [0.012, high, 0.062], grey, orange));
    faces.push(...boxFaces(hub, body, [low, -0.012, 0.062], [high, 0.012, AXLE_HEIGHT + 0.012], grey, orange));
  }
  faces.push(...boxFaces(hub, body, [-0.045, -0.04, 0.054], [0.045, 0.04, 0.062], [110, 118, 128], orange));
  return { faces, contact: [x, y, 0], top: axle, heading: yaw, hub, body };
}

// The edges of the chassis as lines: what touches the floor when the robot lies down.
function drawChassis(context, camera, hub, body, { half, bottom, top }) {
  const corner = (i) => sum(hub, turned(body, [i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? top : bottom]));
  for (let i = 0; i < 8; i++) {
    for (const bit of [1, 2, 4]) {
      if (!(i & bit)) drawLine(context, camera, [corner(i), corner(i | bit)], "#5b6570", 1.5);
    }
  }
}

// Draws floor, track, robot and push.
function drawMotion(context, camera, width, height, motion, index) {
  const { faces, contact, top, heading, hub, body } = robotFaces(motion.states[index], motion.lifts[index]);
  camera.target = [contact[0], contact[1], 0.09];
  camera.aim(width, height);
  context.fillStyle = "#f6f8fa";
  context.fillRect(0, 0, width, height);
  drawFloor(context, camera, contact, 0.1);
  drawLine(context, camera, motion.states.slice(Math.max(0, index - 400), index + 1).map((q) => [q[0], q[1], 0]), "#d55e00", 2);
  drawFaces(context, camera, faces);
  if (motion.chassis) drawChassis(context, camera, hub, body, motion.chassis);
  const push = motion.pushes[index];
  if (push[0] !== 0 || push[1] !== 0) {
    const force = turned(turnZ(heading), [push[0], push[1], 0]);
    drawArrow(context, camera, difference(top, scaled(0.14, unit(force))), top);
  }
}
