// An outline drawn on a plane with the mouse, or with the keys: points on a grid, closed at the first.

const NEAR = 9; // px, at most

export class Outline {
  /**
   * changed: called when the outline is, after an undo with what `kept` gave before that step.
   */
  constructor(plane, changed, kept = () => null) {
    Object.assign(this, { plane, changed, kept });
    this.measure("mm", 1e-3);
    this.points = []; // in its unit
    this.closed = false;
    this.active = false; // whether pointers draw
    this.grid = 0.01; // m between points
    this.cursor = null; // where a key would set a point
    this.picked = null; // number of the point that is moved
    this.past = [];
    plane.takes = (event) => this.down(event);
    const { canvas } = plane;
    canvas.tabIndex = 0;
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", () => this.up());
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("blur", () => { this.cursor = null; plane.draw(); });
    plane.layers.push(() => this.draw());
  }

  /** Whether pointers draw, or move the plane. */
  activate(active) {
    this.active = active;
    this.plane.canvas.classList.toggle("draws", active);
    this.plane.draw();
  }

  /** The unit of the points, and how long it is [m]. */
  measure(name, unit) {
    Object.assign(this, { name, unit });
  }

  /** Distance [m] between lines of the grid. */
  get step() {
    return this.grid / this.unit;
  }

  set(points, closed = true) {
    Object.assign(this, { points: points.map(([x, y]) => [x, y]), closed, picked: null });
    this.plane.draw();
  }

  clear() {
    this.remember();
    this.set([], false);
    this.changed();
  }

  undo() {
    if (!this.past.length) return;
    const [points, closed, kept] = this.past.pop();
    Object.assign(this, { points, closed, picked: null });
    this.changed(kept);
    this.plane.draw();
  }

  remember() {
    this.past.push([this.points.map((point) => [...point]), this.closed, this.kept()]);
    if (this.past.length > 100) this.past.shift();
  }

  /** The place on the grid that is nearest to a point on the canvas. */
  snapped(px, py) {
    const [x, y] = this.plane.toPlane(px, py);
    return [x, y].map((value) => round(Math.round(value / this.unit / this.step) * this.step));
  }

  cornerAt(px, py) {
    const found = this.points.findIndex((point) => {
      const [x, y] = this.pixels(point);
      return Math.hypot(x - px, y - py) <= this.near();
    });
    return found < 0 ? null : found;
  }

  /** How near [px] the pointer must be: corners on neighbouring points of the grid stay apart. */
  near() {
    return Math.min(NEAR, (this.grid * this.plane.scale) / 2);
  }

  pixels([x, y]) {
    return this.plane.toPixels([x * this.unit, y * this.unit]);
  }

  down(event) {
    if (!this.active || event.button !== 0) return false;
    const { offsetX: px, offsetY: py } = event;
    this.plane.canvas.focus({ preventScroll: true });
    const at = this.cornerAt(px, py);
    if (at !== null && !(at === 0 && !this.closed && this.points.length > 2)) {
      this.remember();
      this.picked = at;
      this.dragged = true;
      this.plane.canvas.setPointerCapture(event.pointerId);
      this.plane.draw();
    } else {
      this.place(at === 0 ? this.points[0] : this.snapped(px, py), [px, py]);
    }
    return true;
  }

  /** Sets a point: at the end of an open outline, or in the edge of a closed one that it is on. */
  place(point, at = this.pixels(point)) {
    this.remember();
    if (!this.closed && this.points.length > 2 && same(point, this.points[0])) {
      this.closed = true;
      if (area(this.points) < 0) this.points.reverse();
    } else if (!this.closed) {
      if (!this.points.length || !same(point, this.points.at(-1))) this.points.push(point);
    } else {
      const edge = this.edgeAt(at);
      if (edge === null) { this.past.pop(); return; }
      this.points.splice(edge + 1, 0, point);
      this.picked = edge + 1;
    }
    this.plane.draw();
    this.changed();
  }

  edgeAt(at) {
    const ends = this.points.map((point) => this.pixels(point));
    const found = ends.findIndex((from, k) => distance(at, from, ends[(k + 1) % ends.length]) <= this.near());
    return found < 0 ? null : found;
  }

  move(event) {
    if (!this.active) return;
    this.cursor = this.snapped(event.offsetX, event.offsetY);
    if (this.dragged && this.picked !== null) this.points[this.picked] = this.cursor;
    this.plane.draw();
  }

  up() {
    if (!this.dragged) return;
    this.dragged = false;
    this.changed();
  }

  /** Arrows move the cursor, Enter sets or closes, Delete takes the point there away. */
  key(event) {
    if (!this.active) return;
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const far = this.step * (event.shiftKey ? 10 : 1);
    if (by) {
      const from = this.cursor ?? this.points.at(-1) ?? [0, 0];
      this.cursor = from.map((value, k) => round(value + by[k] * far));
    } else if (event.key === "Enter" && this.cursor) {
      this.place(this.cursor);
    } else if (event.key === "Delete" || event.key === "Backspace") {
      this.remove();
    } else if (event.key === "z" && (event.ctrlKey || event.metaKey)) {
      this.undo();
    } else {
      return;
    }
    event.preventDefault();
    this.plane.draw();
  }

  /** Takes the point away that is picked, or under the cursor, or the last. */
  remove() {
    const under = this.cursor ? this.points.findIndex((point) => same(point, this.cursor)) : -1;
    const which = this.picked ?? (under >= 0 ? under : this.points.length - 1);
    if (which < 0) return;
    this.remember();
    this.points.splice(which, 1);
    this.picked = null;
    if (this.points.length < 3) this.closed = false;
    this.changed();
  }

  draw() {
    const { plane, points } = this;
    const { context } = plane;
    if (points.length) {
      plane.trace(points.map(([x, y]) => [x * this.unit, y * this.unit]), this.closed);
      context.strokeStyle = plane.colour(this.closed ? "wall" : "line");
      context.lineWidth = this.closed ? 2 : 1.5;
      if (this.active || !this.closed) context.stroke();
    }
    if (!this.active) return;
    points.forEach((point, k) => {
      const [px, py] = this.pixels(point);
      context.beginPath();
      context.arc(px, py, k === 0 && !this.closed ? 6 : 4, 0, 2 * Math.PI);
      context.fillStyle = plane.colour(k === this.picked ? "line" : "accent");
      context.fill();
    });
    if (!this.cursor) return;
    const [px, py] = this.pixels(this.cursor);
    context.strokeStyle = plane.colour("line");
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(px - 9, py);
    context.lineTo(px + 9, py);
    context.moveTo(px, py - 9);
    context.lineTo(px, py + 9);
    context.stroke();
    context.fillStyle = plane.colour("ink");
    context.font = "12px system-ui, sans-serif";
    context.fillText(`${this.cursor[0]}, ${this.cursor[1]} ${this.name}`, px + 10, py - 8);
  }
}

function round(value) {
  return Math.round(value * 1e4) / 1e4 + 0;
}

function same(one, other) {
  return other && one[0] === other[0] && one[1] === other[1];
}

/** Area of a polygon, above 0 where it is counter-clockwise. */
export function area(points) {
  return points.reduce((sum, [x, y], k) => {
    const [nextX, nextY] = points[(k + 1) % points.length];
    return sum + (x * nextY - nextX * y) / 2;
  }, 0);
}

/** Distance of a point from the line between two. */
function distance([px, py], [ax, ay], [bx, by]) {
  const length = (bx - ax) ** 2 + (by - ay) ** 2;
  const t = length ? Math.max(0, Math.min(1, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length)) : 0;
  return Math.hypot(px - ax - t * (bx - ax), py - ay - t * (by - ay));
}
