// SPDX-License-Identifier: MIT
// A swimmer's motion: decoding, positions between frames, and colours. The format is told in
// examples/support/report_motion.h. Lengths in metres, x ahead, z up.

function decodePositions(data) {
  const bytes = bytesOf(data.positions), frames = data.times.length, n = 3 * data.vertices;
  const levels = new Int32Array(frames * n);
  let at = 0;
  for (let k = 0; k < frames; ++k) {
    for (let i = 0, here = k * n; i < n; ++i, ++here) {
      let rest = 0, shift = 0, byte;
      do {
        byte = bytes[at++];
        rest |= (byte & 0x7f) << shift;
        shift += 7;
      } while (byte & 0x80);
      let guess = 0;
      if (k === 0 && i >= 3) guess = levels[here - 3];
      if (k === 1) guess = levels[here - n];
      if (k >= 2) guess = 2 * levels[here - n] - levels[here - 2 * n];
      levels[here] = guess + (rest & 1 ? -(rest + 1) / 2 : rest / 2);
    }
  }
  if (at !== bytes.length) throw new Error("the positions of a swimmer are damaged");
  const positions = new Float32Array(levels.length);
  for (let i = 0; i < levels.length; ++i) positions[i] = data.origin[i % 3] + data.quantum * levels[i];
  return positions;
}

// Piecewise straight colour scales: [place, red, green, blue].
const SCALES = {
  // muted blue, light grey, brick red: lengthening, at rest, contracting (after ColorBrewer's RdBu)
  actuation: [[0, 33, 102, 172], [0.25, 103, 169, 207], [0.5, 238, 238, 236], [0.75, 239, 138, 98], [1, 178, 24, 43]],
  // after viridis
  speed: [[0, 68, 1, 84], [0.25, 59, 82, 139], [0.5, 33, 145, 140], [0.75, 94, 201, 98], [1, 253, 231, 37]],
};

function scaleColour(scale, place, out, at) {
  const p = Math.min(1, Math.max(0, place));
  let k = 1;
  while (k < scale.length - 1 && scale[k][0] < p) ++k;
  const a = scale[k - 1], b = scale[k], s = (p - a[0]) / (b[0] - a[0]);
  for (let c = 0; c < 3; ++c) out[at + c] = (a[c + 1] + s * (b[c + 1] - a[c + 1])) / 255;
}

function vertexNormals(index, x, normals) {
  normals.fill(0);
  for (let t = 0; t < index.length; t += 3) {
    const a = 3 * index[t], b = 3 * index[t + 1], c = 3 * index[t + 2];
    const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) normals[i] += nx, normals[i + 1] += ny, normals[i + 2] += nz;
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    normals[i] /= length, normals[i + 1] /= length, normals[i + 2] /= length;
  }
}

class Swimmer {
  constructor(data) {
    this.data = data;
    this.name = data.name;
    this.times = data.times;
    this.n = data.vertices;
    this.index = new Uint32Array(bytesOf(data.triangles).buffer);
    this.frames = decodePositions(data);
    this.lateral = 0;
    this.hidden = false;
    this.positions = new Float32Array(3 * this.n);
    this.normals = new Float32Array(3 * this.n);
    this.colours = new Float32Array(3 * this.n);
    this.velocity = new Float32Array(3 * this.n);
    vertexNormals(this.index, this.frames.subarray(0, 3 * this.n), this.normals);
    this.upward = Float32Array.from({length: this.n}, (_, i) => this.normals[3 * i + 2]);
    this.fastest = this.largestSpeed();
    this.top = -Infinity; // m: highest point of all frames
    for (let i = 2; i < this.frames.length; i += 3) this.top = Math.max(this.top, this.frames[i]);
  }

  duration() {
    return this.times[this.times.length - 1];
  }

  // The frame at or before time t, not the last.
  frameAt(t) {
    let k = Math.round(t / this.duration() * (this.times.length - 1));
    k = Math.min(Math.max(k, 0), this.times.length - 2);
    while (k > 0 && this.times[k] > t) --k;
    while (k < this.times.length - 2 && this.times[k + 1] <= t) ++k;
    return k;
  }

  largestSpeed() {
    let most = 0;
    for (let k = 1; k < this.times.length; ++k) {
      const a = (k - 1) * 3 * this.n, b = k * 3 * this.n, h = this.times[k] - this.times[k - 1];
      for (let i = 0; i < 3 * this.n; i += 3)
        most = Math.max(most, Math.hypot(this.frames[b + i] - this.frames[a + i], this.frames[b + i + 1] - this.frames[a + i + 1],
                                         this.frames[b + i + 2] - this.frames[a + i + 2]) / h);
    }
    return most;
  }

  // Positions and velocities at time t: a cubic through the frames around it (Catmull and Rom), exact at the frames.
  move(t) {
    const k = this.frameAt(t), n = 3 * this.n, last = this.times.length - 1, f = this.frames;
    const h = this.times[k + 1] - this.times[k], s = Math.min(1, Math.max(0, (t - this.times[k]) / h));
    const before = Math.max(0, k - 1), after = Math.min(last, k + 2);
    const a = h / (this.times[k + 1] - this.times[before]), b = h / (this.times[after] - this.times[k]);
    const s2 = s * s, s3 = s2 * s, p0 = 2 * s3 - 3 * s2 + 1, p1 = 1 - p0, m0 = (s3 - 2 * s2 + s) * a, m1 = (s3 - s2) * b;
    for (let i = 0; i < n; ++i) {
      const x0 = f[k * n + i], x1 = f[(k + 1) * n + i];
      this.positions[i] = p0 * x0 + p1 * x1 + m0 * (x1 - f[before * n + i]) + m1 * (f[after * n + i] - x0);
      this.velocity[i] = (x1 - x0) / h;
    }
    if (this.lateral !== 0) for (let i = 1; i < n; i += 3) this.positions[i] += this.lateral;
    vertexNormals(this.index, this.positions, this.normals);
    this.step = k;
  }

  // Mean way along x since the start, m.
  way() {
    let sum = 0;
    for (let i = 0; i < 3 * this.n; i += 3) sum += this.positions[i] - this.frames[i];
    return sum / this.n;
  }

  nose() {
    let most = -Infinity;
    for (let i = 0; i < 3 * this.n; i += 3) most = Math.max(most, this.positions[i]);
    return most;
  }

  tail() {
    let least = Infinity;
    for (let i = 0; i < 3 * this.n; i += 3) least = Math.min(least, this.positions[i]);
    return least;
  }

  // Colours by mode; `back` [r, g, b] is the upper side of the mode "body", whose lower side is light.
  paint(mode, back, fastest) {
    const d = this.data, out = this.colours, belly = [0.93, 0.94, 0.92];
    for (let i = 0; i < this.n; ++i) {
      if (mode === "body") {
        const u = Math.min(1, Math.max(0, 0.5 + 1.1 * this.upward[i])), side = u * u * (3 - 2 * u);
        for (let c = 0; c < 3; ++c) out[3 * i + c] = side * back[c] + (1 - side) * belly[c];
      } else if (mode === "speed") {
        const v = Math.hypot(this.velocity[3 * i], this.velocity[3 * i + 1], this.velocity[3 * i + 2]);
        scaleColour(SCALES.speed, v / fastest, out, 3 * i);
      } else {
        let pull = 0;
        for (let e = d.first_pull[i]; e < d.first_pull[i + 1]; ++e) pull += d.pull[e] * d.signals[d.pull_signal[e]][this.step];
        scaleColour(SCALES.actuation, 0.5 + 0.5 * pull, out, 3 * i);
      }
    }
  }
}
