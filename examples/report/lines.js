// SPDX-License-Identifier: MIT
// What surrounds the swimmers: a floor ruled in tenths of a metre, the start line, the noses, and streaks that drift
// with the water's current. Each is a list of segments [x0, y0, z0, x1, y1, z1, ...].

const SQUARE = 0.1; // m

// The box of all swimmers at all times, in lanes side by side: sets their lateral places.
function layOut(swimmers) {
  const box = {low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity]};
  let half = 0;
  for (const s of swimmers)
    for (let i = 0; i < s.frames.length; i += 3) {
      for (const axis of [0, 2]) {
        box.low[axis] = Math.min(box.low[axis], s.frames[i + axis]);
        box.high[axis] = Math.max(box.high[axis], s.frames[i + axis]);
      }
      half = Math.max(half, Math.abs(s.frames[i + 1]));
    }
  const height = box.high[2] - box.low[2], length = box.high[0] - box.low[0];
  // A tall swimmer must not hide the one behind it.
  const spacing = Math.max(2.3 * half, 1.3 * height, 0.25 * length);
  swimmers.forEach((s, k) => (s.lateral = spacing * ((swimmers.length - 1) / 2 - k)));
  const edge = spacing * (swimmers.length - 1) / 2 + Math.max(1.1 * half, 0.3 * spacing);
  box.low[1] = -edge, box.high[1] = edge;
  for (const axis of [0, 1]) { // whole squares of the floor
    box.low[axis] = Math.floor(box.low[axis] / SQUARE - 0.2) * SQUARE;
    box.high[axis] = Math.ceil(box.high[axis] / SQUARE + 0.2) * SQUARE;
  }
  box.floor = box.low[2] - 0.04 * length;
  return {...box, spacing, length};
}

// The part of the box that holds the swimmers shown.
function shownBox(swimmers, box) {
  const at = swimmers.filter((s) => !s.hidden).map((s) => s.lateral);
  const edge = box.high[1] - Math.max(...swimmers.map((s) => s.lateral));
  const low = Math.floor((Math.min(...at) - edge) / SQUARE + 1e-6) * SQUARE;
  const high = Math.ceil((Math.max(...at) + edge) / SQUARE - 1e-6) * SQUARE;
  return {...box, low: [box.low[0], Math.max(low, box.low[1]), box.low[2]], high: [box.high[0], Math.min(high, box.high[1]), box.high[2]]};
}

function floorLines(box) {
  const out = [], z = box.floor, [x0, y0] = box.low, [x1, y1] = box.high;
  for (let k = 0; x0 + k * SQUARE < x1 + 1e-9; ++k) out.push(x0 + k * SQUARE, y0, z, x0 + k * SQUARE, y1, z);
  for (let k = 0; y0 + k * SQUARE < y1 + 1e-9; ++k) out.push(x0, y0 + k * SQUARE, z, x1, y0 + k * SQUARE, z);
  return new Float32Array(out);
}

function startLines(swimmers, box, out) {
  swimmers.forEach((s, k) => {
    if (s.hidden) return out.fill(0, 6 * k, 6 * k + 6);
    let nose = -Infinity;
    for (let i = 0; i < 3 * s.n; i += 3) nose = Math.max(nose, s.frames[i]);
    out.set([nose, s.lateral - 0.42 * box.spacing, box.floor, nose, s.lateral + 0.42 * box.spacing, box.floor], 6 * k);
  });
}

// Flat ribbons along segments on the floor, two triangles each, for drawings whose lines are hairs.
function ribbons(segments, width, out) {
  for (let i = 0, o = 0; i < segments.length; i += 6) {
    const [x0, y0, z0, x1, y1, z1] = segments.subarray(i, i + 6), length = Math.hypot(x1 - x0, y1 - y0) || 1;
    const nx = -0.5 * width * (y1 - y0) / length, ny = 0.5 * width * (x1 - x0) / length;
    for (const [x, y, z, side] of [[x0, y0, z0, 1], [x0, y0, z0, -1], [x1, y1, z1, 1], [x1, y1, z1, 1], [x0, y0, z0, -1], [x1, y1, z1, -1]]) {
      out[o++] = x + side * nx;
      out[o++] = y + side * ny;
      out[o++] = z;
    }
  }
}

function noseLines(swimmers, box, out) {
  swimmers.forEach((s, k) => {
    if (s.hidden) return out.fill(0, 6 * k, 6 * k + 6);
    const nose = s.nose(), half = 0.25 * box.spacing, z = box.floor + 0.003 * box.length; // above the start line
    out.set([nose, s.lateral - half, z, nose, s.lateral + half, z], 6 * k);
  });
}

// Where a particle of water has drifted to since the start, and the current now; both [3].
function drift(swimmer, t) {
  const way = [0, 0, 0], now = [0, 0, 0], {times, data} = swimmer;
  for (let k = 1; k < times.length && times[k - 1] < t; ++k)
    for (let axis = 0; axis < 3; ++axis) {
      now[axis] = data.current[axis][k - 1];
      way[axis] += now[axis] * (Math.min(t, times[k]) - times[k - 1]);
    }
  return {way, now};
}

const STREAKS = 90;

function hasCurrent(swimmer) {
  return swimmer.data.current.some((row) => row.some((v) => v !== 0));
}

// Streaks as long as the way of a tenth of a second, at places that a fixed sequence scatters evenly (Roberts' R3).
function streakLines(swimmer, box, t, out) {
  const {way, now} = drift(swimmer, t);
  for (let k = 0; k < STREAKS; ++k) {
    for (let axis = 0; axis < 3; ++axis) {
      const low = axis === 2 ? box.floor : box.low[axis], size = box.high[axis] - low;
      const start = ((k + 1) * [0.8191725134, 0.6710436067, 0.5497004779][axis]) % 1 * size + way[axis];
      const place = low + ((start % size) + size) % size;
      out[6 * k + axis] = place;
      out[6 * k + 3 + axis] = place + 0.1 * now[axis];
    }
  }
}
