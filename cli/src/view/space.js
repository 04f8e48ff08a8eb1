// Vectors, turns, and a camera.

const drawn = JSON.parse(document.getElementById("drawn").textContent);

const turnX = (a) => [[1, 0, 0], [0, Math.cos(a), -Math.sin(a)], [0, Math.sin(a), Math.cos(a)]];
const turnY = (a) => [[Math.cos(a), 0, Math.sin(a)], [0, 1, 0], [-Math.sin(a), 0, Math.cos(a)]];
const turnZ = (a) => [[Math.cos(a), -Math.sin(a), 0], [Math.sin(a), Math.cos(a), 0], [0, 0, 1]];
const turned = (r, p) => r.map((row) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
const product = (a, b) => a.map((row) => [0, 1, 2].map((k) => row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]));
const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const difference = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (s, a) => a.map((x) => s * x);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scaled(1 / Math.hypot(...a), a);

// A perspective camera at a distance from a target, seen under azimuth and elevation.
class Camera {
  constructor(distance) {
    this.azimuth = -0.9;
    this.elevation = 0.3;
    this.distance = distance;
    this.target = [0, 0, 0];
  }

  // Fits the camera to a canvas of this size.
  aim(width, height) {
    const level = [Math.cos(this.azimuth), Math.sin(this.azimuth), 0];
    const back = sum(scaled(Math.cos(this.elevation), level), [0, 0, Math.sin(this.elevation)]);
    this.eye = sum(this.target, scaled(this.distance, back));
    this.right = unit(cross([0, 0, 1], back));
    this.up = cross(back, this.right);
    this.back = back;
    this.middle = [width / 2, height / 2];
    this.focus = 1.6 * Math.min(width, height);
  }

  // Depth along the line of sight, positive in front of the camera.
  depth(p) {
    return dot(difference(this.eye, p), this.back);
  }

  // Place on the canvas, or nothing behind the camera.
  seen(p) {
    const depth = this.depth(p);
    if (depth < 0.03 * this.distance) return null;
    const from = difference(p, this.eye);
    const size = this.focus / depth;
    return [this.middle[0] + size * dot(from, this.right), this.middle[1] - size * dot(from, this.up)];
  }
}
