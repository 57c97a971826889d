// SPDX-License-Identifier: MIT
// The view without WebGL or three.js: triangles on a plain canvas, painted from the farthest to the nearest. The same
// interface as in view_three.js.

function createCanvasView(host, swimmers, lines, box, changed) {
  const canvas = element("canvas", {tabindex: "0", "aria-label": "Swimmers; drag to turn, scroll to zoom"});
  const pen = canvas.getContext("2d");
  host.append(canvas);
  let centre = [0, 0, 0], turn = 0, up = 0, distance = 1, width = 1, height = 1, matrix = [];

  const aim = () => (matrix = viewAxes(turn, up));
  const scale = () => height / (2 * Math.tan(FIELD * Math.PI / 360));
  // [x, y in pixels, distance from the eye]
  const project = (x, y, z) => {
    const p = [x - centre[0], y - centre[1], z - centre[2]];
    const [a, b, c] = matrix.map((row) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
    const depth = Math.max(distance - c, 1e-3);
    return [width / 2 + scale() * a / depth, height / 2 - scale() * b / depth, depth];
  };

  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    turn -= event.movementX * 0.008;
    up = Math.min(1.57, Math.max(-1.57, up + event.movementY * 0.008));
    aim();
    changed();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    distance *= Math.exp(0.001 * event.deltaY);
    changed();
  }, {passive: false});

  const drawLines = (line) => {
    pen.strokeStyle = theme(line.colour);
    pen.lineWidth = line.width;
    pen.beginPath();
    for (let i = 0; i < line.segments.length; i += 6) {
      const a = project(...line.segments.subarray(i, i + 3)), b = project(...line.segments.subarray(i + 3, i + 6));
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
    }
    pen.stroke();
  };

  const sun = [-0.25, -0.45, 0.857];
  // The triangles that face the eye, as [depth, colour, x0, y0, x1, y1, x2, y2].
  const faces = (s, out, shadows) => {
    const x = s.positions, places = new Float64Array(s.positions.length), floor = new Float64Array(s.positions.length);
    for (let i = 0; i < x.length; i += 3) {
      places.set(project(x[i], x[i + 1], x[i + 2]), i);
      floor.set(project(x[i], x[i + 1], box.floor), i);
    }
    for (let t = 0; t < s.index.length; t += 3) {
      const [a, b, c] = [3 * s.index[t], 3 * s.index[t + 1], 3 * s.index[t + 2]];
      shadows.push(floor[a], floor[a + 1], floor[b], floor[b + 1], floor[c], floor[c + 1]);
      const area = (places[b] - places[a]) * (places[c + 1] - places[a + 1]) - (places[c] - places[a]) * (places[b + 1] - places[a + 1]);
      if (area >= 0) continue; // its back
      let light = 0;
      for (const v of [a, b, c]) light += (s.normals[v] * sun[0] + s.normals[v + 1] * sun[1] + s.normals[v + 2] * sun[2]) / 3;
      const bright = 255 * (0.5 + 0.5 * Math.max(0, 0.3 + 0.7 * light));
      const colour = [0, 1, 2].map((k) => Math.round(bright * (s.colours[a + k] + s.colours[b + k] + s.colours[c + k]) / 3));
      out.push([places[a + 2] + places[b + 2] + places[c + 2], `rgb(${colour})`, places[a], places[a + 1], places[b], places[b + 1], places[c], places[c + 1]]);
    }
  };

  return {
    kind: "canvas",
    canvas,
    resize(w, h) {
      const ratio = Math.min(window.devicePixelRatio || 1, 3);
      width = w, height = h;
      canvas.width = Math.round(w * ratio), canvas.height = Math.round(h * ratio);
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    },
    look(direction) {
      ({target: centre, distance, turn, up} = lookAt(shownBox(swimmers, box), direction, width / height));
      aim();
    },
    draw() {
      const all = [], shadows = [];
      pen.fillStyle = theme("--water");
      pen.fillRect(0, 0, width, height);
      for (const s of swimmers) if (!s.hidden) faces(s, all, shadows);
      pen.fillStyle = theme("--shadow");
      pen.beginPath();
      for (let i = 0; i < shadows.length; i += 6) {
        // All one way round: triangles that overlap must not cut holes into each other.
        const turned = (shadows[i + 2] - shadows[i]) * (shadows[i + 5] - shadows[i + 1]) > (shadows[i + 4] - shadows[i]) * (shadows[i + 3] - shadows[i + 1]);
        const [b, c] = turned ? [i + 2, i + 4] : [i + 4, i + 2];
        pen.moveTo(shadows[i], shadows[i + 1]);
        pen.lineTo(shadows[b], shadows[b + 1]);
        pen.lineTo(shadows[c], shadows[c + 1]);
        pen.closePath();
      }
      pen.fill("nonzero");
      lines.forEach(drawLines);
      all.sort((a, b) => b[0] - a[0]);
      pen.lineWidth = 0.7;
      pen.lineJoin = "round";
      for (const [, colour, x0, y0, x1, y1, x2, y2] of all) {
        pen.fillStyle = pen.strokeStyle = colour;
        pen.beginPath();
        pen.moveTo(x0, y0);
        pen.lineTo(x1, y1);
        pen.lineTo(x2, y2);
        pen.closePath();
        pen.fill();
        pen.stroke(); // no seams between neighbours
      }
    },
    project: (point) => project(...point).slice(0, 2),
  };
}
