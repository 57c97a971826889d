// SPDX-License-Identifier: MIT
// Where to look from so that everything is seen.

const FIELD = 32; // degrees, vertical

// Turned about z from the swimmers' right side, and up, in degrees.
const DIRECTIONS = {ahead: [9, 34], side: [0, 4], top: [0, 89.9], front: [76, 14]};

// The axes of a view as unit vectors: to the right, up, and towards the eye.
function viewAxes(turn, up) {
  const ct = Math.cos(turn), st = Math.sin(turn), cu = Math.cos(up), su = Math.sin(up);
  return [[ct, st, 0], [-st * su, ct * su, cu], [st * cu, -ct * cu, su]];
}

// {eye, target, distance, turn, up} of the nearest eye that sees the whole box from a direction of the list. The target
// moves until what is seen of the box stands in the middle, which takes a few rounds because of the perspective.
function lookAt(box, direction, aspect) {
  const [turn, up] = DIRECTIONS[direction].map((degrees) => degrees * Math.PI / 180), axes = viewAxes(turn, up);
  const tangent = Math.tan(FIELD * Math.PI / 360), low = [box.low[0], box.low[1], box.floor];
  const target = [0, 1, 2].map((a) => 0.5 * (box.high[a] + low[a]));
  let distance = 3 * box.length;
  for (let round = 0; round < 12; ++round) {
    const seen = [[Infinity, -Infinity], [Infinity, -Infinity]];
    for (let corner = 0; corner < 8; ++corner) {
      const p = [0, 1, 2].map((a) => (corner >> a & 1 ? box.high[a] : low[a]) - target[a]);
      const [right, upward, near] = axes.map((v) => p[0] * v[0] + p[1] * v[1] + p[2] * v[2]);
      const depth = Math.max(distance - near, 0.05 * box.length);
      for (const [axis, at] of [[0, right / depth / aspect], [1, upward / depth]])
        seen[axis] = [Math.min(seen[axis][0], at), Math.max(seen[axis][1], at)];
    }
    const half = Math.max(seen[0][1] - seen[0][0], seen[1][1] - seen[1][0]) / 2;
    const move = [0, 1].map((axis) => 0.5 * (seen[axis][0] + seen[axis][1]) * distance * (axis === 0 ? aspect : 1));
    for (let a = 0; a < 3; ++a) target[a] += move[0] * axes[0][a] + move[1] * axes[1][a];
    distance *= 1 + 0.7 * (1.06 * half / tangent - 1);
  }
  return {target, distance, turn, up, eye: target.map((v, a) => v + distance * axes[2][a])};
}
