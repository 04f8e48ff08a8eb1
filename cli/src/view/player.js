// Time: play, pause, speed, slider; one time for the view and all curves.

const { motion, charts } = drawn;
const canvas = document.getElementById("view");
const camera = new Camera(drawn.distance);
const last = motion.states.length - 1;
const slider = document.getElementById("time");
const button = document.getElementById("play");
let time = 0;
let playing = false;

const cursors = charts.map((chart) => addChart(chart, motion.interval, (t) => go(t)));
slider.max = last;

function show() {
  const index = Math.min(last, Math.max(0, Math.round(time / motion.interval)));
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  drawMotion(context, camera, width, height, motion, index);
  slider.value = index;
  document.getElementById("clock").textContent = `${(index * motion.interval).toFixed(2)} s`;
  cursors.forEach((move) => move(index * motion.interval));
}

function go(t) {
  time = Math.min(last * motion.interval, Math.max(0, t));
  show();
}

function play(on) {
  if (on && time >= last * motion.interval) time = 0;
  playing = on;
  button.textContent = on ? "Pause" : "Play";
  if (on) requestAnimationFrame((now) => step(now, now));
}

function step(before, now) {
  if (!playing) return;
  go(time + ((now - before) / 1000) * Number(document.getElementById("speed").value));
  if (time >= last * motion.interval) play(false);
  else requestAnimationFrame((next) => step(now, next));
}

button.addEventListener("click", () => play(!playing));
slider.addEventListener("input", () => go(Number(slider.value) * motion.interval));
window.addEventListener("resize", show);
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || event.target !== document.body) return;
  event.preventDefault();
  play(!playing);
});

canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  camera.azimuth -= event.movementX / 150;
  camera.elevation = Math.min(1.5, Math.max(0.02, camera.elevation + event.movementY / 150));
  show();
});
canvas.addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    camera.distance = Math.min(6 * drawn.distance, Math.max(0.3 * drawn.distance, camera.distance * Math.exp(event.deltaY / 600)));
    show();
  },
  { passive: false },
);

show();
