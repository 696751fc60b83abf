// A view of space on a canvas: edges of an enclosure, spheres; turned by dragging or the arrow keys.

import { filled } from "./dom.js";

const MARGIN = 24; // px
const TURN = 0.009; // rad a pixel
const SPRITE = 96; // px of the shaded sphere that all are drawn with

export class Space {
  constructor(stage) {
    this.canvas = stage.appendChild(document.createElement("canvas"));
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", "The enclosure and its particles; arrows turn the view");
    this.context = this.canvas.getContext("2d");
    this.azimuth = -0.55;
    this.elevation = 0.32;
    this.zoomed = 1;
    this.scene = null; // walls {ends, normals}, up, along, spheres [[x, y, z, r]], which, speed
    this.sprites = new Map();
    this.watch();
    new ResizeObserver(() => this.resize()).observe(stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.sprites.clear(); this.draw(); });
  }

  watch() {
    let last = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.turn(TURN * (event.clientX - last[0]), TURN * (event.clientY - last[1]));
      last = [event.clientX, event.clientY];
    });
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => { last = null; });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomed = Math.max(0.3, Math.min(20, this.zoomed * Math.exp(-event.deltaY / 600)));
      this.draw();
    }, { passive: false });
    this.canvas.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
      if (!by) return;
      event.preventDefault();
      this.turn(...by);
    });
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + elevation));
    this.draw();
  }

  resize() {
    if (!filled(this)) return;
    this.draw();
  }

  show(scene) {
    this.scene = scene;
    this.draw();
  }

  colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  /** Axes of the view: right, up, towards the eye; gravity points down. */
  axes() {
    const up = unit(this.scene.up.some(Boolean) ? this.scene.up : [0, 0, 1]);
    const across = unit(cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]));
    const ahead = cross(across, up);
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const right = across.map((value, k) => ca * value + sa * ahead[k]);
    const level = across.map((value, k) => -sa * value + ca * ahead[k]);
    return [right, up.map((value, k) => ce * value - se * level[k]), up.map((value, k) => se * value + ce * level[k])];
  }

  draw() {
    const { context, scene } = this;
    if (!this.width) return;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    if (!scene) return;
    const axes = this.axes();
    const ends = scene.walls.ends;
    const points = ends.flat();
    const middle = [0, 1, 2].map((k) => (Math.min(...points.map((p) => p[k])) + Math.max(...points.map((p) => p[k]))) / 2);
    const reach = Math.max(...points.map((p) => Math.hypot(...p.map((value, k) => value - middle[k]))));
    const scale = this.zoomed * (Math.min(this.width, this.height) / 2 - MARGIN) / reach;
    const project = (point) => {
      const from = point.map((value, k) => value - middle[k]);
      const [x, y, z] = axes.map((axis) => dot(axis, from));
      return [this.width / 2 + scale * x, this.height / 2 - scale * y, z];
    };
    this.edges(project, axes[2], -1);
    this.spheres(project, scale);
    this.edges(project, axes[2], 1);
    this.arrow(project, middle, reach);
  }

  /** Edges behind (-1) or before (1) the middle: sharp ones, and outlines of curved faces. */
  edges(project, eye, side) {
    const { context, scene } = this;
    context.strokeStyle = this.colour("wall");
    context.globalAlpha = side > 0 ? 0.9 : 0.4;
    context.lineWidth = side > 0 ? 1.6 : 1;
    context.beginPath();
    scene.walls.ends.forEach(([from, to], k) => {
      const [one, other] = scene.walls.normals[k];
      const curved = one.some(Boolean);
      if (curved && dot(one, eye) * dot(other, eye) > 0) return;
      const [ax, ay, az] = project(from);
      const [bx, by, bz] = project(to);
      if ((az + bz >= 0) !== (side > 0)) return;
      context.moveTo(ax, ay);
      context.lineTo(bx, by);
    });
    context.stroke();
    context.globalAlpha = 1;
  }

  spheres(project, scale) {
    const { context, scene } = this;
    if (!scene.spheres) return;
    const seen = scene.spheres.map(([x, y, z, r], k) => [...project([x, y, z]), r * scale, k]);
    seen.sort((a, b) => a[2] - b[2]);
    for (const [x, y, , r, k] of seen) {
      const particle = scene.which[k];
      const tone = scene.speed ? Math.round(9 * scene.speed[particle]) : 0;
      context.drawImage(this.sprite(tone), x - r, y - r, 2 * r, 2 * r);
    }
  }

  /** A shaded sphere in one of ten tones. */
  sprite(tone) {
    if (this.sprites.has(tone)) return this.sprites.get(tone);
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = SPRITE;
    const context = canvas.getContext("2d");
    const half = SPRITE / 2;
    const hue = 205 - 18 * tone;
    const shade = context.createRadialGradient(0.7 * half, 0.6 * half, 0.05 * half, half, half, half);
    shade.addColorStop(0, `hsl(${hue} 75% 85%)`);
    shade.addColorStop(0.55, `hsl(${hue} 55% 55%)`);
    shade.addColorStop(1, `hsl(${hue} 60% 26%)`);
    context.fillStyle = shade;
    context.beginPath();
    context.arc(half, half, half - 1, 0, 2 * Math.PI);
    context.fill();
    this.sprites.set(tone, canvas);
    return canvas;
  }

  /** The direction of the motion. */
  arrow(project, middle, reach) {
    const { context, scene } = this;
    if (!scene.along?.some(Boolean)) return;
    const [from, to] = [-1, 1].map((side) => project(middle.map((value, k) => value + side * 1.12 * reach * scene.along[k] * 0.85)));
    context.strokeStyle = context.fillStyle = this.colour("line");
    context.lineWidth = 2;
    for (const [tip, tail] of [[to, from], [from, to]]) {
      const length = Math.hypot(tip[0] - tail[0], tip[1] - tail[1]) || 1;
      const [dx, dy] = [(tip[0] - tail[0]) / length, (tip[1] - tail[1]) / length];
      context.beginPath();
      context.moveTo(tip[0] - 14 * dx, tip[1] - 14 * dy);
      context.lineTo(tip[0], tip[1]);
      context.moveTo(tip[0] - 6 * dx - 4 * dy, tip[1] - 6 * dy + 4 * dx);
      context.lineTo(tip[0], tip[1]);
      context.lineTo(tip[0] - 6 * dx + 4 * dy, tip[1] - 6 * dy - 4 * dx);
      context.stroke();
    }
  }
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(a) {
  const length = Math.hypot(...a);
  return a.map((value) => value / length);
}
