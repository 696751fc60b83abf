// A plane on a canvas: silo, particles, grid; moved by dragging, enlarged by the wheel. Metres, y up.

import { filled } from "./dom.js";

const MARGIN = 18; // px

export class Plane {
  constructor(stage) {
    this.canvas = stage.appendChild(document.createElement("canvas"));
    this.context = this.canvas.getContext("2d");
    this.window = [-0.2, 0.2, -0.05, 0.6]; // left, right, bottom, top [m] that is fitted
    this.layers = []; // functions that draw, in turn
    this.moved = false;
    this.grid = 0; // [m] between lines; 0: none
    this.after = () => {}; // called when what is seen has changed
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.watchDrags();
    new ResizeObserver(() => this.resize()).observe(stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  resize() {
    if (!filled(this)) return;
    if (!this.moved) this.fit();
    this.draw();
  }

  /** Shows a window, or the last one. */
  fit(window = this.window) {
    this.window = window;
    if (!this.width) return;
    const [left, right, bottom, top] = window;
    this.scale = Math.min((this.width - 2 * MARGIN) / (right - left), (this.height - 2 * MARGIN) / (top - bottom));
    this.centre = [(left + right) / 2, (bottom + top) / 2];
    this.moved = false;
    this.draw();
  }

  zoom(factor, [px, py] = [this.width / 2, this.height / 2]) {
    const [x, y] = this.toPlane(px, py);
    this.scale *= factor;
    const [nowX, nowY] = this.toPlane(px, py);
    this.centre = [this.centre[0] + x - nowX, this.centre[1] + y - nowY];
    this.moved = true;
    this.draw();
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY / 500), [event.offsetX, event.offsetY]);
  }

  /** Moves the plane with the pointer; `takes` may keep a pointer for itself. */
  watchDrags() {
    this.takes = () => false;
    let last = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      if (this.takes(event)) return;
      last = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.centre[0] -= (event.clientX - last[0]) / this.scale;
      this.centre[1] += (event.clientY - last[1]) / this.scale;
      last = [event.clientX, event.clientY];
      this.moved = true;
      this.draw();
    });
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => { last = null; });
  }

  toPlane(px, py) {
    return [this.centre[0] + (px - this.width / 2) / this.scale, this.centre[1] - (py - this.height / 2) / this.scale];
  }

  toPixels([x, y]) {
    return [this.width / 2 + (x - this.centre[0]) * this.scale, this.height / 2 - (y - this.centre[1]) * this.scale];
  }

  colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  draw() {
    if (!this.width || !this.centre) return;
    const { context } = this;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    if (this.grid) this.drawGrid();
    for (const layer of this.layers) layer(this, context);
    this.after();
  }

  drawGrid() {
    const { context, width, height } = this;
    let step = this.grid;
    while (step * this.scale < 7) step *= step.toExponential().startsWith("2") ? 2.5 : 2;
    const [left, top] = this.toPlane(0, 0);
    const [right, bottom] = this.toPlane(width, height);
    for (const strong of [false, true]) {
      const every = strong ? 10 * step : step;
      context.strokeStyle = this.colour(strong ? "rule" : "grid");
      context.lineWidth = 1;
      context.beginPath();
      for (let x = Math.ceil(left / every); x <= right / every; x++) {
        const px = Math.round(this.toPixels([x * every, 0])[0]) + 0.5;
        context.moveTo(px, 0);
        context.lineTo(px, height);
      }
      for (let y = Math.ceil(bottom / every); y <= top / every; y++) {
        const py = Math.round(this.toPixels([0, y * every])[1]) + 0.5;
        context.moveTo(0, py);
        context.lineTo(width, py);
      }
      context.stroke();
    }
  }

  /** A path through points [m], in pixels. */
  trace(points, closed) {
    const { context } = this;
    context.beginPath();
    points.forEach((point, k) => {
      const [px, py] = this.toPixels(point);
      if (k) context.lineTo(px, py);
      else context.moveTo(px, py);
    });
    if (closed) context.closePath();
  }

  /** Particles: shapes [{outline}], kind and pose (x, y, angle) of each; layer: their colour. */
  particles({ kind, pose, layer }, shapes) {
    const { context, ratio, scale } = this;
    const paths = shapes.map(({ outline }) => {
      const path = new Path2D();
      outline.forEach(([x, y], k) => (k ? path.lineTo(x, y) : path.moveTo(x, y)));
      path.closePath();
      return path;
    });
    const tones = [this.colour("wood"), this.colour("dark-wood")];
    context.strokeStyle = this.colour("edge");
    context.lineWidth = 0.6 / scale;
    pose.forEach(([x, y, angle], k) => {
      const [px, py] = this.toPixels([x, y]);
      if (px < -60 || py < -60 || px > this.width + 60 || py > this.height + 60) return;
      const cos = scale * ratio * Math.cos(angle);
      const sin = scale * ratio * Math.sin(angle);
      context.setTransform(cos, -sin, -sin, -cos, px * ratio, py * ratio);
      context.fillStyle = tones[layer ? ((layer[k] % 2) + 2) % 2 : 0];
      context.fill(paths[kind[k]]);
      context.stroke(paths[kind[k]]);
    });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }
}
