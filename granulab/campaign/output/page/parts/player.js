// The player of a run: what is shown, and how it is played, pointed at, measured and saved.

import { Contacts } from "./contacts.js";
import { bindControls } from "./controls.js";
import { Curves } from "./curves.js";
import { readData, unpack } from "./data.js";
import { drawLegend } from "./legend.js";
import { distance } from "./marks.js";
import { savePicture } from "./picture.js";
import { Plane } from "./plane.js";
import { Scale, digits, withUnit } from "./scale.js";
import { Space } from "./space.js";
import { onThemeChange, readTheme } from "./theme.js";

const PER_SECOND = 25; // frames, at pace 1

class Player {
  constructor(data, arrays) {
    Object.assign(this, { data, arrays });
    this.frames = data.frames;
    this.time = arrays.time;
    this.state = { frame: 0, playing: false, pace: 1, colour: 0, network: false, wallForces: false,
      picked: -1, follow: false, path: true, measuring: false, points: [] };
    this.stage = document.getElementById("stage");
    this.legend = document.getElementById("legend");
    this.theme = readTheme();
    this.contacts = arrays.first ? new Contacts(arrays, data.frames, data.particles) : null;
    this.scales = data.colours.map((spec) => new Scale(spec, arrays[spec.array]));
    this.curves = new Curves(document.getElementById("curves"), data.curves, arrays, data.clock);
    this.view = this.makeView();
    this.listeners = []; // called after each frame that is drawn
    this.drawn = { frame: -1 };
    onThemeChange(() => {
      this.theme = readTheme();
      this.redraw();
    });
    new ResizeObserver(() => this.resize()).observe(this.stage);
    this.resize();
  }

  /** The picture of the particles; null where the browser cannot show it, which is said. */
  makeView() {
    try {
      const View = this.data.space ? Space : Plane;
      const view = new View(this.stage, this.data, this.arrays);
      const { marks } = view;
      Object.assign(marks, { contacts: this.contacts, usual: this.data.usual_force,
        walls: this.data.walls, wallForce: this.arrays.wall_force ?? null,
        largest: this.data.largest_wall_force });
      return view;
    } catch (error) {
      say(error.message);
      return null;
    }
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (this.view && width > 1 && height > 1) this.view.resize(width, height, ratio);
    const course = document.getElementById("curves").getBoundingClientRect();
    this.curves.resize(course.width, course.height, ratio);
    this.ratio = ratio;
    this.redraw();
  }

  // What follows changes the state; the next picture shows it.

  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      this.advance(now);
      this.render();
      if (this.state.playing) this.redraw();
    });
  }

  set(changes) {
    Object.assign(this.state, changes);
    this.redraw();
  }

  show(frame) {
    this.set({ frame: Math.max(0, Math.min(this.frames - 1, Math.round(frame))) });
  }

  play(playing = !this.state.playing) {
    if (playing && this.state.frame === this.frames - 1) this.state.frame = 0;
    this.since = null;
    this.set({ playing });
  }

  /** The frame that belongs to a moment (ms) while the run plays. */
  advance(now) {
    const { state } = this;
    if (!state.playing) return;
    if (this.since === null) this.since = { now, frame: state.frame, pace: state.pace };
    if (this.since.pace !== state.pace) this.since = { now, frame: state.frame, pace: state.pace };
    const past = Math.floor((now - this.since.now) / 1e3 * PER_SECOND * state.pace);
    state.frame = Math.min(this.since.frame + past, this.frames - 1);
    if (state.frame === this.frames - 1) state.playing = false;
  }

  pick(particle) {
    const found = particle >= 0 && particle < this.data.particles ? particle : -1;
    this.set({ picked: found, follow: found >= 0 && this.state.follow });
  }

  measureAt(at) {
    const { points } = this.state;
    const point = this.view.pointAt(at, this.state.frame);
    this.set({ points: points.length === 1 ? [...points, point] : [point] });
  }

  /** Draws what the state says. */
  render() {
    const { state, view, theme } = this;
    const scale = this.scales[state.colour];
    if (view) {
      if (state.follow && state.picked >= 0) view.lookAt(view.place(state.picked, state.frame));
      view.draw(state, this.tones(scale, state.frame), scale.tones, theme);
    }
    this.curves.draw(this.time.at(state.frame), theme);
    if (this.drawn.colour !== state.colour || this.drawn.theme !== theme) this.renderLegend(scale);
    this.drawn = { colour: state.colour, theme };
    for (const listener of this.listeners) listener();
  }

  renderLegend(scale) {
    const most = Math.max(120, Math.min(this.stage.clientWidth - 200, 420));
    const context = this.legend.getContext("2d");
    const [wide, high] = drawLegend(context, scale, [0, 0], most, this.theme);
    this.legend.width = (wide + 40) * this.ratio;
    this.legend.height = high * this.ratio;
    this.legend.style.width = `${wide + 40}px`;
    this.legend.style.height = `${high}px`;
    context.scale(this.ratio, this.ratio);
    drawLegend(context, scale, [4, 0], most, this.theme);
  }

  /** Integers that a scale has for all particles in a frame; null where there is nothing yet. */
  integers(scale, frame) {
    if (scale.per === "particle") return scale.array.integers;
    if (scale.per === "frame") return scale.array.row(frame);
    const moment = this.contacts.momentOf[frame];
    if (moment < 0) return null;
    return scale.array === this.contacts.force ? this.contacts.sums(moment) : scale.array.row(moment);
  }

  /** Number of the colour of each particle. */
  tones(scale, frame) {
    const integers = this.integers(scale, frame);
    this.toneBuffer ??= new Uint8Array(this.data.particles);
    for (let k = 0; k < this.toneBuffer.length; k++) {
      this.toneBuffer[k] = integers ? scale.tone(integers[k]) : 0;
    }
    return this.toneBuffer;
  }

  // Words.

  /** Time of the frame that is shown, and how far the run is by then. */
  clockWords() {
    const { clock, period } = this.data, { frame } = this.state;
    const time = this.time.at(frame);
    const words = [`${(clock.factor * time).toFixed(clock.digits)} ${clock.unit}`];
    if (period) {
      const part = Math.round(1e3 * time / period) / 1e3; // times come in steps
      words.push(`cycle ${Math.floor(part) + 1}, ${(part % 1).toFixed(2)} of it`);
    }
    if (this.arrays.counted) words.push(`${this.arrays.counted.at(frame)} ${this.data.counted}`);
    return words.join(" \u00b7 ");
  }

  /** How the pictures run against the time of the run. */
  paceWords(pace) {
    const { time, frames } = this;
    if (frames < 2) return "";
    const each = (time.at(frames - 1) - time.at(0)) / (frames - 1);
    const factor = 1 / (PER_SECOND * pace * each);
    if (Math.abs(factor - 1) < 0.05) return "real time";
    return `${digits(Math.max(factor, 1 / factor))}\u00d7 ${factor > 1 ? "slower" : "faster"}`;
  }

  /** What is known of the picked particle: names and values. */
  particleRows() {
    const { picked, frame } = this.state;
    const rows = this.scales.map((scale) => {
      const integers = this.integers(scale, frame);
      return [scale.label, integers ? scale.words(integers[picked]) : "–"];
    });
    if (this.view) {
      const place = this.view.centreOf(picked, frame).map((value) => digits(1e3 * value));
      rows.unshift([this.data.space ? "centre in the enclosure" : "centre", `${place.join(", ")} mm`]);
      if (!this.view.shows(picked, frame)) rows.unshift(["", "it has left"]);
    }
    return rows;
  }

  wallRows() {
    const { wall_force: force } = this.arrays;
    const axes = force.width / this.data.walls.length;
    return this.data.walls.map(({ name }, wall) => {
      const parts = Array.from({ length: axes }, (_, k) => force.at(this.state.frame, wall * axes + k));
      return [name, withUnit(Math.hypot(...parts), "N")];
    });
  }

  measuredWords() {
    const { points, measuring } = this.state;
    if (points.length === 2) return `Distance: ${withUnit(distance(points), "m")}`;
    return measuring ? `Click the ${points.length ? "second" : "first"} point.` : "";
  }

  networkWords() {
    const { network, frame, colour } = this.state;
    const used = network || this.scales[colour].per === "moment";
    if (!this.contacts || !used) return "";
    const moment = this.contacts.momentOf[frame];
    if (moment < 0) return "no contacts yet";
    const { clock } = this.data;
    const time = this.arrays.moment_time.at(moment);
    const when = Math.abs(time - this.time.at(frame)) < 1e-9 ? ""
      : `Contacts as of ${(clock.factor * time).toFixed(clock.digits)} ${clock.unit}. `;
    return network ? `${when}Lines: forces between bodies; the widest are `
      + `${withUnit(6 * this.data.usual_force, "N")} and more. ${this.data.pull_words}` : when;
  }

  save() {
    savePicture(this);
  }
}

function say(words) {
  const message = document.getElementById("message");
  message.textContent = words;
  message.hidden = false;
}

async function start() {
  try {
    const data = readData();
    const player = new Player(data, await unpack(data.arrays));
    bindControls(player);
    window.player = player; // for the console, and for tests
  } catch (error) {
    say(`The run cannot be shown: ${error.message}`);
    throw error;
  }
}

start();
