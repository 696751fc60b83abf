// What is drawn over the particles of either view: forces, a path, a distance, a length to scale.

import { digits, withUnit } from "./scale.js";

const WIDEST = 5, STEPS = 8; // px of a line of the network, and how many widths there are
const BEYOND = 6; // times the usual force: what is larger is drawn as wide
const LONGEST = 90; // px of the arrow of the largest force on a wall
const FAINT = 0.01; // of that, below which none is drawn
const BEHIND = 60; // frames of a path

/**
 * Marks over a view, which gives: width, height (px), project(point) to px, place(particle, frame),
 * shows(particle, frame), radiusOf(particle), pixelsPerMetre(), count.
 */
export class Marks {
  constructor(view) {
    this.view = view;
    this.contacts = null; // set where the run kept any
    this.usual = 1; // force [N] of a line of WIDEST / BEYOND
    this.walls = []; // name and middle of each
    this.wallForce = null; // (frames, walls x dimensions) [N]
    this.largest = 1;
  }

  draw(context, state, theme) {
    if (state.network && this.contacts) this.drawNetwork(context, state, theme);
    if (state.wallForces && this.wallForce) this.drawWallForces(context, state, theme);
    if (state.picked >= 0) this.drawPicked(context, state, theme);
    this.drawMeasure(context, state, theme);
    this.drawLength(context, theme);
  }

  /** Lines between centres that touch, or from a centre to a wall, as wide as their force. */
  drawNetwork(context, { frame }, theme) {
    const { view, contacts } = this;
    const moment = contacts.momentOf[frame];
    if (moment < 0) return;
    const pushing = Array.from({ length: STEPS }, () => []), pulling = [];
    contacts.forEach(moment, (k, wall) => {
      const first = contacts.first.integers[k], second = contacts.second.integers[k];
      if (!view.shows(first, frame) || (wall < 0 && !view.shows(second, frame))) return;
      const start = view.place(first, frame);
      const end = wall < 0 ? view.place(second, frame)
        : start.map((value, axis) => value + contacts.branch.at(wall, axis));
      const part = Math.min(contacts.size(k) / this.usual / BEYOND, 1);
      const pulls = contacts.pulls.integers[k] === 1;
      const lines = pulls ? pulling : pushing[Math.min(Math.floor(STEPS * part), STEPS - 1)];
      lines.push(view.project(start), view.project(end));
    });
    context.lineCap = "round";
    pushing.forEach((lines, k) =>
      strokeLines(context, lines, theme.network, WIDEST * (k + 0.5) / STEPS));
    strokeLines(context, pulling, theme.pull, 1.5);
  }

  drawWallForces(context, { frame }, theme) {
    const { view, wallForce } = this;
    const axes = wallForce.width / this.walls.length;
    this.walls.forEach(({ middle }, wall) => {
      if (!middle) return; // a door that is away
      const force = middle.map((_, axis) => wallForce.at(frame, wall * axes + axis));
      const size = Math.hypot(...force);
      if (size < FAINT * this.largest) return;
      const base = view.onEnclosure ? view.onEnclosure(middle, frame) : middle;
      const start = view.project(base);
      const length = LONGEST * Math.min(size / this.largest, 1.2) / view.pixelsPerMetre();
      const end = view.project(base.map((value, axis) => value + (length * force[axis]) / size));
      arrow(context, start, end, theme.force);
      this.label(context, withUnit(size, "N"), this.beside(start, end), theme, theme.force);
    });
  }

  /** Where the words on an arrow stand: at its point, or at its foot where that is off the stage. */
  beside(start, end) {
    const { width, height } = this.view;
    const fits = end[0] > 4 && end[0] < width - 60 && end[1] > 14 && end[1] < height - 14;
    const [x, y] = fits ? end : start;
    return [Math.max(4, Math.min(x + 6, width - 62)), Math.max(16, Math.min(y - 6, height - 6))];
  }

  drawPicked(context, { frame, picked, path }, theme) {
    const { view } = this;
    if (path) {
      const points = [];
      for (let k = Math.max(0, frame - BEHIND); k <= frame; k++) {
        if (view.shows(picked, k)) points.push(view.project(view.place(picked, k)));
      }
      context.strokeStyle = theme.picked;
      context.lineWidth = 1.5;
      context.beginPath();
      points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.stroke();
    }
    if (!view.shows(picked, frame)) return;
    const [x, y] = view.project(view.place(picked, frame));
    context.strokeStyle = theme.picked;
    context.lineWidth = 3;
    context.beginPath();
    context.arc(x, y, view.radiusOf(picked) * view.pixelsPerMetre() + 3, 0, 2 * Math.PI);
    context.stroke();
  }

  drawMeasure(context, { points }, theme) {
    if (!points.length) return;
    const ends = points.map((point) => this.view.project(point));
    if (ends.length === 2) strokeLines(context, ends, theme.measure, 2);
    context.fillStyle = theme.measure;
    for (const [x, y] of ends) {
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fill();
    }
    if (ends.length < 2) return;
    const middle = [(ends[0][0] + ends[1][0]) / 2 + 8, (ends[0][1] + ends[1][1]) / 2 - 8];
    this.label(context, withUnit(distance(points), "m"), middle, theme, theme.measure);
  }

  /** A bar of 1, 2 or 5 times a power of ten, a fifth of the stage at most. */
  drawLength(context, theme) {
    const { width, height } = this.view;
    const scale = this.view.pixelsPerMetre();
    const most = Math.min(width / 5, 160) / scale;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = Math.max(...[1, 2, 5].map((k) => k * power).filter((one) => one <= most * 1.001));
    const [left, y] = [width - 12 - length * scale, height - 12];
    strokeLines(context, [[left, y], [width - 12, y]], theme.ink, 3);
    context.textAlign = "right";
    this.label(context, `${digits(1e3 * length)} mm`, [width - 12, y - 8], theme, theme.ink);
    context.textAlign = "left";
  }

  label(context, words, [x, y], theme, colour) {
    context.font = "600 13px system-ui, sans-serif";
    context.lineJoin = "round";
    context.lineWidth = 4;
    context.strokeStyle = theme.stage;
    context.strokeText(words, x, y);
    context.fillStyle = colour;
    context.fillText(words, x, y);
  }
}

/** Gives a canvas whole pixels of the screen: the stage may be a part of one wider. */
export function fitCanvas(canvas, width, height, ratio) {
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
}

/** Distance of two points [m]. */
export function distance([a, b]) {
  return Math.hypot(...a.map((value, axis) => value - b[axis]));
}

/** Lines from each even point to the next one. */
function strokeLines(context, points, colour, width) {
  if (!points.length) return;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  for (let k = 0; k < points.length; k += 2) {
    context.moveTo(points[k][0], points[k][1]);
    context.lineTo(points[k + 1][0], points[k + 1][1]);
  }
  context.stroke();
}

function arrow(context, start, end, colour) {
  const [dx, dy] = [end[0] - start[0], end[1] - start[1]];
  const length = Math.hypot(dx, dy) || 1;
  const [ux, uy] = [dx / length, dy / length];
  strokeLines(context, [start, end], colour, 3);
  context.fillStyle = colour;
  context.beginPath();
  context.moveTo(end[0] + 8 * ux, end[1] + 8 * uy);
  context.lineTo(end[0] - 5 * uy, end[1] + 5 * ux);
  context.lineTo(end[0] + 5 * uy, end[1] - 5 * ux);
  context.fill();
}
