// Particles in space, by WebGL2: spheres or surfaces in their enclosure; orbit, cut, pointing.

import { Marks, fitCanvas } from "./marks.js";
import { rgb } from "./scale.js";
import { EDGES, FACES, SPHERES, SURFACES } from "./shaders.js";

const FROM = [0.5, 0.33]; // rad to the right and up, from which a scene is seen at first
const EDGE = 0.9; // px, half the width of an edge
const ROOM = 1.12; // of the stage over what is in it

/** View of a scene in space. Throws an Error where the browser has no WebGL2. */
export class Space {
  constructor(stage, data, arrays) {
    this.stage = stage;
    this.canvas = stage.appendChild(document.createElement("canvas"));
    this.overlay = stage.appendChild(document.createElement("canvas"));
    this.context = this.overlay.getContext("2d");
    // Smoothed edges would cost more than all else without a graphics card; spheres gain nothing.
    const gl = this.canvas.getContext("webgl2", { antialias: false, alpha: false });
    if (!gl) {
      throw new Error("This browser shows no WebGL2, which the picture in space needs; "
        + "switch it on, or use another browser. The curves and numbers are here all the same.");
    }
    this.gl = gl;
    this.scene = data.space;
    this.arrays = arrays;
    this.place_ = arrays.position;
    this.count = arrays.radius.integers.length;
    this.radii = Float32Array.from({ length: this.count }, (_, k) => arrays.radius.at(k));
    this.turns = arrays.turn ?? null;
    this.scales = this.turns && valuesOf(arrays.scale);
    this.arms = this.turns ? this.armsOfSpheres() : [];
    this.marks = new Marks(this);
    this.inLab = true;
    this.cut = { axis: "none", part: 0.5 };
    this.orbit = [...FROM];
    this.build();
    this.fit();
  }

  /** Spheres of each form of particle: where they are, and how large. */
  armsOfSpheres() {
    const { sphere, sphere_end: end } = this.arrays; // (spheres, 4): offset and radius
    const all = Array.from({ length: sphere.rows }, (_, k) => ({
      arm: [0, 1, 2].map((axis) => sphere.at(k, axis)),
      radius: sphere.at(k, 3),
    }));
    return Array.from({ length: end.rows }, (_, k) => all.slice(k ? end.at(k - 1) : 0, end.at(k)));
  }

  /** Programs and what does not change. */
  build() {
    const { gl, arrays, turns } = this;
    this.programs = {};
    const particles = turns ? SURFACES : SPHERES;
    const cut = { ...particles, fragment: particles.fragment.replace("\n", "\n#define CUT\n") };
    const sources = { particles, cut, edges: EDGES, faces: FACES };
    for (const [name, source] of Object.entries(sources)) {
      this.programs[name] = compiled(gl, source);
    }
    const names = ["place", "tone", "more", "scale"];
    this.moving = Object.fromEntries(names.map((name) => [name, gl.createBuffer()]));
    this.particles = gl.createVertexArray();
    gl.bindVertexArray(this.particles);
    attribute(gl, this.moving.place, 0, 3, gl.UNSIGNED_SHORT, 1);
    attribute(gl, this.moving.tone, 1, 1, gl.UNSIGNED_BYTE, 1);
    if (turns) {
      attribute(gl, this.moving.more, 2, 4, gl.UNSIGNED_SHORT, 1);
      attribute(gl, filled(gl, valuesOf(arrays.surface_corner)), 3, 3, gl.FLOAT, 0);
      attribute(gl, filled(gl, valuesOf(arrays.surface_normal)), 4, 3, gl.FLOAT, 0);
      attribute(gl, this.moving.scale, 5, 1, gl.FLOAT, 1);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, arrays.surface_triangle.integers, gl.STATIC_DRAW);
    } else {
      attribute(gl, this.moving.more, 2, 1, gl.FLOAT, 1);
    }
    this.edges = gl.createVertexArray();
    gl.bindVertexArray(this.edges);
    const ends = filled(gl, valuesOf(arrays.edge)); // two points of each
    const normals = filled(gl, valuesOf(arrays.edge_normal));
    for (let k = 0; k < 2; k++) {
      attribute(gl, ends, k, 3, gl.FLOAT, 1, 24, 12 * k);
      attribute(gl, normals, 2 + k, 3, gl.FLOAT, 1, 24, 12 * k);
    }
    this.faces = gl.createVertexArray();
    gl.bindVertexArray(this.faces);
    attribute(gl, filled(gl, valuesOf(arrays.face)), 0, 3, gl.FLOAT, 0);
    gl.bindVertexArray(null);
  }

  resize(width, height, ratio) {
    Object.assign(this, { width, height, ratio });
    for (const canvas of [this.canvas, this.overlay]) fitCanvas(canvas, width, height, ratio);
    if (!this.moved) this.fit();
  }

  /** Shows the whole enclosure, wherever it goes, from the first side. */
  fit() {
    this.orbit = [...FROM];
    this.turnTo();
    const { low, high } = this.scene;
    this.middle = low.map((value, axis) => (value + high[axis]) / 2);
    const reach = Math.hypot(...low.map((value, axis) => high[axis] - value)) / 2;
    this.depth = 2.5 * reach;
    this.front = reach;
    const [halfWide, halfHigh] = [0, 1].map((row) => this.extentAlong(this.camera[row]));
    if (this.width) {
      this.scale = Math.min(this.width / halfWide, this.height / halfHigh) / 2 / ROOM;
    }
    this.moved = false;
  }

  /** Half the extent of what is shown along a direction [m]. */
  extentAlong(direction) {
    const { low, high } = this.scene;
    return direction.reduce((sum, c, axis) => sum + Math.abs(c) * (high[axis] - low[axis]) / 2, 0);
  }

  /** Unit vectors right, up and towards the eye, from the angles of the orbit. */
  turnTo() {
    const { right, up, nearer } = this.scene;
    const [round, above] = this.orbit;
    const eye = combined([Math.cos(above) * Math.cos(round), nearer],
      [Math.cos(above) * Math.sin(round), right], [Math.sin(above), up]);
    const across = combined([Math.cos(round), right], [-Math.sin(round), nearer]);
    this.camera = [across, cross(eye, across), eye];
  }

  turn(round, above) {
    const most = Math.PI / 2;
    this.orbit = [this.orbit[0] + round, Math.max(-most, Math.min(most, this.orbit[1] + above))];
    this.turnTo();
  }

  zoom(factor, at = [this.width / 2, this.height / 2]) {
    const before = this.unproject(at);
    const least = 0.3 * Math.min(this.width, this.height) / (2 * this.front);
    this.scale = Math.max(least, Math.min(this.scale * factor, 100 * least));
    const after = this.unproject(at);
    this.middle = this.middle.map((value, axis) => value + before[axis] - after[axis]);
    this.moved = true;
  }

  drag(dx, dy) {
    const [right, up] = this.camera;
    this.middle = combined([1, this.middle], [-dx / this.scale, right], [dy / this.scale, up]);
    this.moved = true;
  }

  lookAt(point) {
    this.middle = point;
    this.moved = true;
  }

  project(point) {
    const arm = point.map((value, axis) => value - this.middle[axis]);
    return [this.width / 2 + this.scale * dot(arm, this.camera[0]),
      this.height / 2 - this.scale * dot(arm, this.camera[1]), dot(arm, this.camera[2])];
  }

  /** Point of the plane through the middle that faces the eye. */
  unproject([px, py]) {
    return combined([1, this.middle], [(px - this.width / 2) / this.scale, this.camera[0]],
      [-(py - this.height / 2) / this.scale, this.camera[1]]);
  }

  pixelsPerMetre() {
    return this.scale;
  }

  /** How far the enclosure is from where it rests, as it is drawn. */
  shift(frame) {
    return [0, 1, 2].map((axis) => (this.inLab ? this.arrays.shift.at(frame, axis) : 0));
  }

  /** Centre of a particle in the enclosure. */
  centreOf(particle, frame) {
    return [0, 1, 2].map((axis) => this.place_.at(frame, 3 * particle + axis));
  }

  place(particle, frame) {
    return this.onEnclosure(this.centreOf(particle, frame), frame);
  }

  onEnclosure(point, frame) {
    const shift = this.shift(frame);
    return point.map((value, axis) => value + shift[axis]);
  }

  shows() {
    return true;
  }

  radiusOf(particle) {
    return this.turns ? this.scene.reach : this.radii[particle];
  }

  draw(state, tones, colours, theme) {
    const { gl } = this;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    const paper = rgb(theme.stage).map((value) => value / 255);
    gl.clearColor(...paper, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawFaces(state.frame, theme);
    this.drawParticles(state, tones, colours, paper, theme);
    this.drawEdges(state.frame, theme);
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.marks.draw(this.context, state, theme);
  }

  use(name, frame) {
    const { gl } = this, { program, at } = this.programs[name];
    gl.useProgram(program);
    gl.uniformMatrix3fv(at("camera"), true, this.camera.flat());
    gl.uniform3fv(at("middle"), this.middle);
    gl.uniform3fv(at("shift"), this.shift(frame));
    gl.uniform3f(at("halves"), this.width / 2 / this.scale, this.height / 2 / this.scale, this.depth);
    return at;
  }

  drawFaces(frame, theme) {
    const { gl } = this, at = this.use("faces", frame);
    gl.bindVertexArray(this.faces);
    gl.uniform4f(at("tint"), ...rgb(theme.shell).map((value) => value / 255), 1);
    gl.drawArrays(gl.TRIANGLES, 0, this.arrays.face.integers.length / 3);
  }

  drawParticles({ frame, picked, network }, tones, colours, paper, theme) {
    const { gl, place_: place, turns } = this, whole = this.cut.axis === "none";
    const at = this.use(whole ? "particles" : "cut", frame);
    const order = this.fromTheNearest(frame);
    gl.bindVertexArray(this.particles);
    gl.uniform3f(at("low"), place.low, place.low, place.low);
    gl.uniform3f(at("step_"), place.step, place.step, place.step);
    const part = network ? theme.pale : 1; // under a network of forces colours are paler
    const shown = colours.flatMap((colour) =>
      rgb(colour).map((value, k) => part * value / 255 + (1 - part) * paper[k]));
    gl.uniform3fv(at("colours"), shown);
    gl.uniform4fv(at("cut"), this.cutSeen(frame));
    gl.uniform1f(at("front"), this.front);
    const prepared = (some) => {
      upload(gl, this.moving.place, inOrder(place.row(frame), some, 3));
      upload(gl, this.moving.tone, inOrder(tones, some, 1));
      gl.uniform1i(at("picked"), picked < 0 ? -1 : some.indexOf(picked));
    };
    if (!turns) {
      prepared(order);
      upload(gl, this.moving.more, inOrder(this.radii, order, 1));
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
      return;
    }
    const { form, surface_end: end } = this.arrays;
    gl.uniform2f(at("turnScale"), turns.low, turns.step);
    if (whole) gl.enable(gl.CULL_FACE);
    for (let k = 0, begin = 0; k < end.rows; begin = end.at(k++)) {
      const some = order.filter((particle) => form.at(particle) === k);
      prepared(some);
      upload(gl, this.moving.more, inOrder(turns.row(frame), some, 4));
      upload(gl, this.moving.scale, inOrder(this.scales, some, 1));
      gl.drawElementsInstanced(gl.TRIANGLES, 3 * (end.at(k) - begin), gl.UNSIGNED_SHORT, 6 * begin,
        some.length);
    }
    gl.disable(gl.CULL_FACE);
  }

  /** Numbers of the particles, the nearest first: what is hidden is then not shaded at all. */
  fromTheNearest(frame) {
    const eye = this.camera[2], integers = this.place_.row(frame);
    this.nearness ??= new Float32Array(this.count);
    this.order ??= Array.from({ length: this.count }, (_, k) => k);
    for (let k = 0; k < this.count; k++) {
      this.nearness[k] = dot(eye, [integers[3 * k], integers[3 * k + 1], integers[3 * k + 2]]);
    }
    return this.order.sort((a, b) => this.nearness[b] - this.nearness[a]);
  }

  drawEdges(frame, theme) {
    const { gl } = this, at = this.use("edges", frame);
    gl.bindVertexArray(this.edges);
    gl.uniform4f(at("tint"), ...rgb(theme.wall).map((value) => value / 255), 1);
    gl.uniform1f(at("width"), EDGE / this.scale);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.arrays.edge.rows);
  }

  /** Plane of the cut: unit normal towards what is taken away, and its offset in the enclosure. */
  cutPlane() {
    const { axis, part } = this.cut;
    if (axis === "none") return null;
    const normal = this.scene[axis]; // right, up or nearer
    const ends = [this.scene.inner_low, this.scene.inner_high].map((corner) => dot(corner, normal));
    const [low, high] = [Math.min(...ends), Math.max(...ends)];
    return { normal, offset: low + part * (high - low) };
  }

  /** The same in camera coordinates. */
  cutSeen(frame) {
    const plane = this.cutPlane();
    if (!plane) return [0, 0, 0, 1];
    const shift = this.shift(frame);
    const away = this.middle.map((value, axis) => value - shift[axis]);
    return [...this.camera.map((row) => dot(row, plane.normal)),
      plane.offset - dot(plane.normal, away)];
  }

  /** The particle that a point of the canvas shows, or -1. */
  pick(at, frame) {
    return this.hit(at, frame).particle;
  }

  /** Point of the scene that a point of the canvas shows: of a particle, or of the plane behind. */
  pointAt(at, frame) {
    return this.hit(at, frame).point ?? this.unproject(at);
  }

  /** The nearest sphere on the line of sight, as the shaders see it. */
  hit(at, frame) {
    const start = this.unproject(at);
    const eye = this.camera[2];
    const plane = this.cutPlane(), shift = this.shift(frame);
    let nearest = -Infinity, found = { particle: -1 };
    for (let particle = 0; particle < this.count; particle++) {
      for (const [centre, radius] of this.spheresOf(particle, frame)) {
        const arm = centre.map((value, axis) => value - start[axis]);
        const along = dot(arm, eye);
        const across = dot(arm, arm) - along * along;
        if (across > radius * radius) continue;
        const half = Math.sqrt(radius * radius - across);
        let way = along + half;
        if (plane) {
          const inFront = dot(plane.normal, start) - dot(plane.normal, shift) - plane.offset;
          const rate = dot(plane.normal, eye);
          if (inFront + way * rate > 0) { // its front is cut away
            way = -inFront / rate;
            if (rate <= 0 || way < along - half) continue;
          }
        }
        if (way > nearest) {
          nearest = way;
          found = { particle, point: combined([1, start], [way, eye]) };
        }
      }
    }
    return found;
  }

  spheresOf(particle, frame) {
    const centre = this.place(particle, frame);
    if (!this.turns) return [[centre, this.radii[particle]]];
    const q = [0, 1, 2, 3].map((k) => this.turns.at(frame, 4 * particle + k));
    const scale = this.scales[particle];
    return this.arms[this.arrays.form.at(particle)].map(({ arm, radius }) =>
      [combined([1, centre], [scale, turned(q, arm)]), scale * radius]);
  }
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Sum of vectors, each times a number. */
function combined(...terms) {
  return [0, 1, 2].map((axis) => terms.reduce((sum, [factor, v]) => sum + factor * v[axis], 0));
}

/** A vector turned by a unit quaternion (w, x, y, z). */
function turned(q, arm) {
  const about = q.slice(1);
  return combined([1, arm], [2 * q[0], cross(about, arm)], [2, cross(about, cross(about, arm))]);
}

function valuesOf(array) {
  return Float32Array.from(array.integers, (integer) => array.value(integer));
}

function filled(gl, values) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  return buffer;
}

function upload(gl, buffer, values) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
}

/** Rows of so many numbers in another order. */
function inOrder(values, order, size) {
  const sorted = new values.constructor(size * order.length);
  order.forEach((from, to) => {
    for (let k = 0; k < size; k++) sorted[size * to + k] = values[size * from + k];
  });
  return sorted;
}

/** Numbers of a buffer for a place of the program: each for one instance, or for a corner (0). */
function attribute(gl, buffer, location, size, type, instances, stride = 0, offset = 0) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(location);
  gl.vertexAttribPointer(location, size, type, false, stride, offset);
  gl.vertexAttribDivisor(location, instances);
}

/** A program, and where its uniforms are. */
function compiled(gl, { vertex, fragment }) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const known = {};
  return { program, at: (name) => (known[name] ??= gl.getUniformLocation(program, name)) };
}
