// SPDX-License-Identifier: MIT
// The stage: all swimmers side by side, played together, and the controls below them.

const find = (id) => document.getElementById(id);

function makeView(...about) {
  if (!/\bcanvas\b/.test(location.hash) && window.THREE && THREE.OrbitControls) {
    try {
      return createThreeView(...about);
    } catch (error) {
      for (const canvas of about[0].querySelectorAll("canvas")) canvas.remove(); // no WebGL here
    }
  }
  return createCanvasView(...about);
}

function rgb(text) {
  return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
}

class Player {
  // `onTime` is told the time whenever it changes.
  constructor(swimmers, onTime) {
    this.swimmers = swimmers;
    this.onTime = onTime;
    this.time = 0;
    this.drawn = 0;
    this.playing = false;
    this.rate = 1;
    this.mode = "body";
    this.duration = Math.max(...swimmers.map((s) => s.duration()));
    this.fastest = Math.max(...swimmers.map((s) => s.fastest)) || 1;
    this.box = layOut(swimmers);
    const line = (segments, colour, width) => ({segments, colour, width});
    this.starts = line(new Float32Array(6 * swimmers.length), "--start", 2.5);
    this.noses = line(new Float32Array(6 * swimmers.length), "--after", 3);
    this.streaks = hasCurrent(swimmers[0]) ? line(new Float32Array(6 * STREAKS), "--s6", 1.5) : null;
    this.floor = line(floorLines(this.box), "--floor", 1);
    const lines = [this.floor, this.starts, this.noses];
    if (this.streaks) lines.push(this.streaks);
    find("stage").hidden = false;
    this.host = find("view");
    this.view = makeView(this.host, swimmers, lines, this.box, () => this.refresh());
    this.labels = swimmers.map((s) => find("labels").appendChild(element("span")));
    this.direction = "ahead";
    this.connect();
    this.resize();
  }

  connect() {
    find("time").max = this.duration;
    find("time").addEventListener("input", (event) => this.pause(this.setTime(Number(event.target.value))));
    find("play").addEventListener("click", () => this.playing ? this.pause() : this.play());
    find("rate").addEventListener("change", (event) => (this.rate = Number(event.target.value)));
    find("colour").addEventListener("change", (event) => this.setMode(event.target.value));
    this.swimmers.forEach((s) => find("show").append(element("option", {value: s.name}, s.name)));
    find("show-label").hidden = this.swimmers.length < 2;
    find("show").addEventListener("change", (event) => this.show(event.target.value));
    find("from").addEventListener("change", (event) => this.look(event.target.value));
    find("save").addEventListener("click", () => {
      this.draw();
      this.view.canvas.toBlob((blob) => save(blob, "swimmers.png"));
    });
    document.addEventListener("keydown", (event) => {
      if (event.target.closest("button, select, input, summary") || event.ctrlKey || event.metaKey || event.altKey) return;
      const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
      if (event.key === " ") this.playing ? this.pause() : this.play();
      else if (step) this.pause(this.setTime(this.swimmers[0].times[this.frame() + step] ?? this.time));
      else return;
      event.preventDefault();
    });
    new ResizeObserver(() => this.resize()).observe(this.host);
    for (const media of ["(prefers-color-scheme: dark)", "print"])
      matchMedia(media).addEventListener("change", () => this.draw());
    window.addEventListener("beforeprint", () => this.draw());
  }

  // The frame nearest to the present time.
  frame() {
    const {times} = this.swimmers[0], k = this.swimmers[0].frameAt(this.time);
    return this.time - times[k] > times[k + 1] - this.time ? k + 1 : k;
  }

  setTime(t) {
    this.time = Math.min(Math.max(t, 0), this.duration);
    this.refresh();
  }

  setMode(mode) {
    this.mode = mode;
    const scale = SCALES[mode], bar = find("scale-bar");
    find("scale").hidden = !scale;
    find("colour").value = mode;
    if (scale) {
      bar.style.background = `linear-gradient(to right, ${scale.map(([p, ...c]) => `rgb(${c}) ${100 * p}%`).join(", ")})`;
      find("scale-low").textContent = mode === "speed" ? "0" : "lengthens";
      find("scale-high").textContent = mode === "speed" ? `${significant(this.fastest, 2)} m/s` : "contracts";
    }
    this.refresh();
  }

  look(direction) {
    this.direction = direction;
    this.view.look(direction);
    this.refresh();
  }

  // Shows one swimmer by its name, or "all".
  show(name) {
    for (const s of this.swimmers) s.hidden = name !== "all" && name !== s.name;
    find("show").value = name;
    this.floor.segments.fill(0);
    this.floor.segments.set(floorLines(shownBox(this.swimmers, this.box)));
    this.look(this.direction);
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.host;
    const size = `${width} ${height} ${devicePixelRatio}`;
    if (width < 1 || height < 1 || size === this.size) return;
    this.width = width, this.height = height, this.size = size;
    this.view.resize(width, height);
    this.view.look(this.direction);
    this.draw();
  }

  play() {
    if (this.playing) return;
    if (this.time >= this.duration) this.time = 0;
    this.playing = true;
    this.showPlaying();
    let before = null;
    const tick = (now) => {
      if (!this.playing) return;
      // A page that slept in the background does not leap.
      if (before !== null) this.time += this.rate * Math.min(0.1, (now - before) / 1000);
      before = now;
      if (this.time > this.duration) this.time = 0;
      this.draw();
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.showPlaying();
  }

  showPlaying() {
    find("play").textContent = this.playing ? "Pause" : "Play";
    find("play").setAttribute("aria-pressed", this.playing);
  }

  // Draws soon, once for all changes until then.
  refresh() {
    if (this.playing || this.pending) return;
    this.pending = requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.pending = 0;
    this.swimmers.forEach((s, k) => {
      s.move(Math.min(this.time, s.duration()));
      s.paint(this.mode, rgb(theme(k === 0 && this.swimmers.length > 1 ? "--before" : "--after")), this.fastest);
    });
    startLines(this.swimmers, this.box, this.starts.segments);
    noseLines(this.swimmers, this.box, this.noses.segments);
    if (this.streaks) streakLines(this.swimmers[0], this.box, this.time, this.streaks.segments);
    this.view.draw();
    ++this.drawn;
    this.label();
    find("time").value = this.time;
    find("clock").textContent = `t = ${fixed(this.time, 2)} s, frame ${this.frame()}/${this.swimmers[0].times.length - 1}`;
    this.onTime(this.time);
  }

  // Names and ways, above the tails.
  label() {
    this.swimmers.forEach((s, k) => {
      const node = this.labels[k], [x, y] = this.view.project([s.tail(), s.lateral, s.top]);
      node.hidden = s.hidden;
      node.replaceChildren(element("b", {}, s.name), ` ${fixed(1e3 * s.way(), 1)} mm`);
      node.style.transform = `translate(${Math.max(4, Math.min(x, this.width - node.offsetWidth - 4)).toFixed(1)}px, ` +
                             `${Math.max(2, Math.min(y - 20, this.height - 26)).toFixed(1)}px)`;
    });
  }
}
