// Particles of the plane, on a Canvas 2D: polygons, walls; moved, enlarged, and pointed at.

import { Marks, fitCanvas } from "./marks.js";

const LEFT_OUT = 0.3; // px by which an outline may lie off the stored one: its corners are many
const MARGIN = 14; // px round what is shown

/** View of a scene in the plane. */
export class Plane {
  constructor(stage, data, arrays) {
    this.stage = stage;
    this.canvas = stage.appendChild(document.createElement("canvas"));
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.scene = data.plane;
    const { x, y, angle, inside, kind, time } = arrays;
    Object.assign(this, { x, y, angle, inside, time, kinds: kind.integers });
    this.count = kind.integers.length;
    this.marks = new Marks(this);
    this.moved = false; // by hand; else the whole scene is shown
  }

  resize(width, height, ratio) {
    Object.assign(this, { width, height, ratio });
    fitCanvas(this.canvas, width, height, ratio);
    if (!this.moved) this.fit();
    else this.simplify();
  }

  /** Shows the whole scene. */
  fit() {
    const [left, right, bottom, top] = this.scene.window;
    this.scale = Math.min((this.width - 2 * MARGIN) / (right - left),
      (this.height - 2 * MARGIN) / (top - bottom));
    this.centre = [(left + right) / 2, (bottom + top) / 2];
    this.moved = false;
    this.simplify();
  }

  zoom(factor, at = [this.width / 2, this.height / 2]) {
    const before = this.unproject(at);
    const [left, right] = this.scene.window;
    const least = 0.3 * this.width / (right - left);
    this.scale = Math.max(least, Math.min(this.scale * factor, 400 * least));
    const after = this.unproject(at);
    this.centre = this.centre.map((value, k) => value + before[k] - after[k]);
    this.moved = true;
    this.simplify();
  }

  drag(dx, dy) {
    this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
    this.moved = true;
  }

  /** Brings a point into the middle. */
  lookAt(point) {
    this.centre = point;
    this.moved = true;
  }

  /** Point of the scene (m) as one of the canvas (px). */
  project([x, y]) {
    return [this.width / 2 + (x - this.centre[0]) * this.scale,
      this.height / 2 - (y - this.centre[1]) * this.scale];
  }

  unproject([px, py]) {
    return [this.centre[0] + (px - this.width / 2) / this.scale,
      this.centre[1] - (py - this.height / 2) / this.scale];
  }

  pixelsPerMetre() {
    return this.scale;
  }

  centreOf(particle, frame) {
    return [this.x.at(frame, particle), this.y.at(frame, particle)];
  }

  /** Centre of a particle as it is drawn. */
  place(particle, frame) {
    return this.centreOf(particle, frame);
  }

  shows(particle, frame) {
    return this.inside.integers[frame * this.count + particle] === 1;
  }

  radiusOf(particle) {
    return this.reach[this.kinds[particle]];
  }

  /** Outlines for the scale of now, as paths in metres. */
  simplify() {
    const { outlines } = this.scene;
    this.reach = outlines.map((points) => Math.max(...points.map(([x, y]) => Math.hypot(x, y))));
    this.paths = outlines.map((points) => {
      const path = new Path2D();
      thinned(points, LEFT_OUT / (this.scale * this.ratio)).forEach(([x, y], k) =>
        k ? path.lineTo(x, y) : path.moveTo(x, y));
      path.closePath();
      return path;
    });
  }

  /** Draws a frame: state as in player.js, tones the colour of each particle, theme the page's. */
  draw(state, tones, colours, theme) {
    const { context, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = theme.stage;
    context.fillRect(0, 0, this.width, this.height);
    this.drawParticles(state.frame, tones, colours, theme, state.network);
    this.drawWalls(state.frame, theme);
    this.marks.draw(context, state, theme);
  }

  drawParticles(frame, tones, colours, theme, pale) {
    const { context, x, y, angle, ratio, scale, count } = this;
    const k = scale * ratio;
    const left = ratio * (this.width / 2 - this.centre[0] * scale);
    const top = ratio * (this.height / 2 + this.centre[1] * scale);
    context.globalAlpha = pale ? theme.pale : 1;
    context.strokeStyle = theme.edge;
    context.lineWidth = 0.8 / scale;
    context.lineJoin = "round";
    let last = -1;
    for (let particle = 0, at = frame * count; particle < count; particle++, at++) {
      if (this.inside.integers[at] !== 1) continue;
      const px = left + k * x.value(x.integers[at]), py = top - k * y.value(y.integers[at]);
      const reach = k * this.reach[this.kinds[particle]];
      if (px < -reach || py < -reach || px > this.canvas.width + reach ||
        py > this.canvas.height + reach) continue;
      const turn = angle.value(angle.integers[at]);
      const cos = k * Math.cos(turn), sin = k * Math.sin(turn);
      context.setTransform(cos, -sin, -sin, -cos, px, py); // y counts upwards in the scene
      if (tones[particle] !== last) {
        last = tones[particle];
        context.fillStyle = colours[last];
      }
      const path = this.paths[this.kinds[particle]];
      context.fill(path);
      context.stroke(path);
    }
    context.globalAlpha = 1;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  drawWalls(frame, theme) {
    const { context, scene } = this;
    context.strokeStyle = theme.wall;
    context.lineCap = "round";
    context.lineWidth = 2.5;
    const line = (a, b) => {
      context.moveTo(...this.project(a));
      context.lineTo(...this.project(b));
    };
    context.beginPath();
    for (const { ends } of scene.walls) if (ends) line(...ends);
    const drawn = scene.doorSpeed === null ? Infinity : scene.doorSpeed * this.time.at(frame);
    const [[left, y], [right]] = scene.lips;
    if (left + drawn < right) line([left + drawn, y], [right, y]);
    const moves = scene.gateTimes.filter((time) => time <= this.time.at(frame)).length;
    if (moves % 2) for (const ends of scene.doors) line(...ends);
    context.stroke();
    context.lineWidth = 1;
    context.setLineDash([4, 4]);
    context.beginPath();
    line(...scene.lips);
    context.stroke();
    context.setLineDash([]);
  }

  /** The particle at a point of the canvas, or -1. */
  pick(at, frame) {
    const [x, y] = this.unproject(at);
    for (let particle = this.count - 1; particle >= 0; particle--) {
      if (!this.shows(particle, frame)) continue;
      const [cx, cy] = this.centreOf(particle, frame);
      const turn = -this.angle.at(frame, particle);
      const [dx, dy] = [x - cx, y - cy];
      const own = [dx * Math.cos(turn) - dy * Math.sin(turn), dx * Math.sin(turn) + dy * Math.cos(turn)];
      if (holds(this.scene.outlines[this.kinds[particle]], own)) return particle;
    }
    return -1;
  }

  /** Point of the scene that a point of the canvas shows. */
  pointAt(at) {
    return this.unproject(at);
  }
}

/** An outline without corners, those left out within a distance of the lines past them. */
function thinned(points, distance) {
  const kept = [points[0]];
  for (let last = 0, k = 1; k < points.length; k++) {
    const past = points.slice(last + 1, k + 1), next = points[(k + 1) % points.length];
    if (past.some((point) => offLine(point, points[last], next) > distance)) {
      kept.push(points[k]);
      last = k;
    }
  }
  return kept.length > 2 ? kept : points;
}

/** Distance of a point from the line through two others. */
function offLine([x, y], [ax, ay], [bx, by]) {
  const length = Math.hypot(bx - ax, by - ay) || 1e-12;
  return Math.abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length;
}

/** Whether a polygon holds a point: an odd number of its edges is to the right. */
function holds(points, [x, y]) {
  let inside = false;
  for (let k = 0, j = points.length - 1; k < points.length; j = k++) {
    const [ax, ay] = points[k], [bx, by] = points[j];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  }
  return inside;
}
