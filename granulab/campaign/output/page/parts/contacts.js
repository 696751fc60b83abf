// Contacts of a page: forces between bodies at its moments, the frames that have them.

/**
 * Contacts of all moments, one after the other.
 *
 * first, second   bodies; the second of a contact with a wall is the number of particles + the wall
 * force           size of the force between both [N]; pulls: whether it does
 * branch          from the centre of the first body to the wall [m], of contacts with walls in turn
 */
export class Contacts {
  constructor(arrays, frameCount, particleCount) {
    const { first, second, force, pulls, branch, moment_frame: frames, moment_length: lengths } =
      arrays;
    Object.assign(this, { first, second, force, pulls, branch });
    this.particleCount = particleCount;
    this.frames = Array.from(frames.integers);
    this.start = [0];
    for (const length of lengths.integers) this.start.push(this.start.at(-1) + length);
    this.wallsBefore = this.countWalls();
    this.momentOf = new Int32Array(frameCount).fill(-1);
    for (let frame = 0, moment = -1; frame < frameCount; frame++) {
      if (this.frames[moment + 1] === frame) moment++;
      this.momentOf[frame] = moment;
    }
    this.summed = new Map();
  }

  /** Contacts with walls before each moment, which branches are counted by. */
  countWalls() {
    const counts = [0];
    for (let moment = 0, count = 0; moment + 1 < this.start.length; moment++) {
      for (let k = this.start[moment]; k < this.start[moment + 1]; k++) count += this.isWall(k);
      counts.push(count);
    }
    return counts;
  }

  isWall(k) {
    return this.second.integers[k] >= this.particleCount;
  }

  size(k) {
    return this.force.value(this.force.integers[k]);
  }

  /** Calls each(k, branch number or -1) for the contacts of a moment. */
  forEach(moment, each) {
    let wall = this.wallsBefore[moment];
    for (let k = this.start[moment]; k < this.start[moment + 1]; k++) {
      each(k, this.isWall(k) ? wall++ : -1);
    }
  }

  /** Sum of the sizes of the forces on each particle, as integers of the array of forces. */
  sums(moment) {
    if (!this.summed.has(moment)) {
      const total = new Float64Array(this.particleCount);
      this.forEach(moment, (k, wall) => {
        total[this.first.integers[k]] += this.size(k);
        if (wall < 0) total[this.second.integers[k]] += this.size(k);
      });
      const { low, step } = this.force;
      this.summed.clear(); // one moment is shown at a time
      this.summed.set(moment, Uint16Array.from(total, (value) =>
        value > 0 ? 1 + Math.max(0, Math.round(Math.log(value / low) / step)) : 0));
    }
    return this.summed.get(moment);
  }
}
