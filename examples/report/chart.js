// SPDX-License-Identifier: MIT
// Charts of curves or points as inline SVG: ticks at round numbers, axis titles, a legend, the values under the pointer,
// and in charts over time a line at the time of the animation.

const CHART = {width: 560, height: 310, left: 64, right: 14, top: 10, bottom: 48};
const DASHES = ["", "7 3", "2 3", "10 3 2 3", "4 4", "1 2", "12 4", "8 2 2 2 2 2"];
const MOST_MARKERS = 45, MOST_NAMES = 8;

// Colours of the series with the names of the swimmers: "initial" and "optimised" look the same everywhere.
const ownColours = new Map();

function seriesColour(series, index) {
  if (series.style === "faint") return "var(--before)";
  if (series.style === "mark") return "var(--s2)";
  return ownColours.get(series.name) || `var(--s${index % 8 + 1})`;
}

// About `wanted` round numbers that cover [low, high].
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= rough * 0.999);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) all.push(k * step);
  return all;
}

function range(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (v !== null) low = Math.min(low, v), high = Math.max(high, v);
  return low <= high ? [low, high] : [0, 1];
}

function tickText(value, all) {
  const step = all.length > 1 ? Math.abs(all[1] - all[0]) : Math.abs(value) || 1;
  const most = Math.max(...all.map(Math.abs));
  if (most >= 1e5 || (most > 0 && most < 1e-3)) return significant(value, 3);
  return fixed(value, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
}

// Maps numbers to pixels: {to, ticks, text}.
function axis(values, logarithmic, from, until, wanted, whole) {
  if (logarithmic) {
    const positive = values.filter((v) => v > 0), [a, b] = range(positive);
    const low = Math.floor(Math.log10(positive.length ? a : 0.1)), high = Math.max(low + 1, Math.ceil(Math.log10(positive.length ? b : 1)));
    const every = Math.ceil((high - low) / 6), all = [];
    for (let k = low; k <= high; k += every) all.push(10 ** k);
    if (high - low <= 2) for (let k = low; k < high; ++k) all.push(2 * 10 ** k, 5 * 10 ** k);
    const to = (v) => from + (Math.log10(v) - low) / (high - low) * (until - from);
    return {to, all, text: (v) => Math.abs(Math.log10(v)) < 4 ? minus(String(Number(v.toPrecision(1)))) : significant(v, 1).replace(/^1\u00b7/, "")};
  }
  let [low, high] = range(values);
  const room = whole ? 0 : Math.max(0.05 * (high - low), 0.02 * Math.abs(high), 1e-12);
  if (whole && low === high) high = low + 1;
  low -= room, high += room;
  let all = ticks(low, high, wanted);
  if (whole) all = all.filter((v) => Number.isInteger(v) || whole !== "integers");
  return {to: (v) => from + (v - low) / (high - low) * (until - from), all, text: (v) => tickText(v, all), low, high};
}

// The shape of marker k about (0, 0).
function marker(k) {
  const shapes = ["M-3,0a3,3 0 1,0 6,0a3,3 0 1,0-6,0z", "M-2.7-2.7h5.4v5.4h-5.4z", "M0-3.6L3.4,2.5H-3.4z", "M0-3.8L3.4,0L0,3.8L-3.4,0z",
                  "M0,3.6L3.4-2.5H-3.4z", "M-3-1h2v-2h2v2h2v2h-2v2h-2v-2h-2z"];
  return shapes[k % shapes.length];
}

function sample(series, index, points) {
  const picture = svg("svg", {viewBox: "0 0 26 10", "aria-hidden": "true"});
  const colour = seriesColour(series, index);
  if (series.style === "mark") {
    picture.append(svg("circle", {cx: 13, cy: 5, r: 4, fill: "none", stroke: colour, "stroke-width": 2}));
    return picture;
  }
  if (points !== "only")
    picture.append(svg("path", {d: "M0,5H26", stroke: colour, "stroke-width": 2, "stroke-dasharray": points ? "" : DASHES[index % 8]}));
  if (points) picture.append(svg("path", {d: marker(index), fill: colour, transform: "translate(13,5)"}));
  return picture;
}

function legend(chart, hasMarkers) {
  const box = element("div", {class: "legend"}), values = [];
  chart.series.forEach((series, index) => {
    if (chart.series.length > MOST_NAMES && index >= MOST_NAMES) return;
    const value = element("em");
    values.push(value);
    box.append(element("span", {}, sample(series, index, hasMarkers(series)), series.name, value));
  });
  if (chart.series.length > MOST_NAMES) box.append(element("em", {}, `and ${chart.series.length - MOST_NAMES} more`));
  return {box, values};
}

function frame(picture, chart, x, y) {
  const c = CHART, bottom = c.height - c.bottom;
  for (const v of y.all) {
    picture.append(svg("path", {class: "grid", d: `M${c.left},${y.to(v).toFixed(1)}H${c.width - c.right}`}));
    picture.append(svg("text", {x: c.left - 7, y: y.to(v) + 4, "text-anchor": "end"}, y.text(v)));
  }
  for (const v of x.all) {
    picture.append(svg("path", {class: "frame", d: `M${x.to(v).toFixed(1)},${bottom}v4`}));
    picture.append(svg("text", {x: x.to(v), y: bottom + 18, "text-anchor": "middle"}, x.text(v)));
  }
  if (y.low < 0 && y.high > 0) picture.append(svg("path", {class: "zero", d: `M${c.left},${y.to(0)}H${c.width - c.right}`}));
  picture.append(svg("path", {class: "frame", d: `M${c.left},${c.top}V${bottom}H${c.width - c.right}`}));
  picture.append(svg("text", {class: "axis", x: (c.left + c.width - c.right) / 2, y: c.height - 9, "text-anchor": "middle"}, chart.x_title));
  picture.append(svg("text", {class: "axis", transform: `translate(14,${(c.top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle"}, chart.y_title));
}

function curve(picture, chart, series, index, x, y, withMarkers) {
  const colour = seriesColour(series, index), group = svg("g", {class: "series", "data-name": series.name});
  let path = "", pen = "M", points = 0;
  series.y.forEach((v, i) => {
    if (v === null || (chart.kind === "log" && v <= 0)) return void (pen = "M");
    const px = x.to(series.x[i]).toFixed(2), py = y.to(v).toFixed(2);
    path += `${pen}${px},${py}`;
    pen = "L";
    ++points;
    if (series.style === "mark")
      group.append(svg("circle", {cx: px, cy: py, r: 7, fill: "none", stroke: colour, "stroke-width": 2}));
    else if (withMarkers)
      group.append(svg("path", {class: "dot", d: marker(index), fill: colour, transform: `translate(${px},${py})`}));
  });
  group.setAttribute("data-points", points);
  if (series.style !== "mark" && chart.kind !== "points")
    group.prepend(svg("path", {class: "curve", d: path, stroke: colour, "stroke-dasharray": withMarkers ? "" : DASHES[index % 8]}));
  picture.append(group);
}

// The values nearest to the pointer, in the legend.
function probe(picture, chart, x, values, onTime) {
  const line = svg("path", {class: "probe", d: "", visibility: "hidden"}), c = CHART;
  const places = [...new Set(chart.series.flatMap((s) => s.x))].sort((a, b) => a - b);
  picture.append(line);
  const at = (event) => {
    const box = picture.getBoundingClientRect(), px = (event.clientX - box.left) / box.width * c.width;
    let best = 0;
    places.forEach((v, i) => Math.abs(x.to(v) - px) < Math.abs(x.to(places[best]) - px) && (best = i));
    return places[best];
  };
  picture.addEventListener("pointermove", (event) => {
    const place = at(event);
    line.setAttribute("d", `M${x.to(place)},${c.top}V${c.height - c.bottom}`);
    line.setAttribute("visibility", "visible");
    values.forEach((node, k) => {
      const i = chart.series[k].x.indexOf(place);
      node.textContent = i >= 0 ? significant(chart.series[k].y[i], 4) : "";
    });
  });
  picture.addEventListener("pointerleave", () => {
    line.setAttribute("visibility", "hidden");
    for (const node of values) node.textContent = "";
  });
  if (onTime) picture.addEventListener("click", (event) => onTime(at(event)));
}

// Saves the drawing with its colours, which otherwise come from the page's style.
function saveSvg(picture, title) {
  const copy = picture.cloneNode(true), [, , width, height] = picture.getAttribute("viewBox").split(" ");
  const from = picture.querySelectorAll("*"), to = copy.querySelectorAll("*");
  from.forEach((node, i) => {
    const style = getComputedStyle(node);
    for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "font-family", "visibility"])
      to[i].setAttribute(name, style.getPropertyValue(name));
  });
  for (const node of copy.querySelectorAll(".cursor, .probe")) node.remove();
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  save(new Blob([new XMLSerializer().serializeToString(copy)], {type: "image/svg+xml"}), fileName(title, "svg"));
}

// The figure around a drawing.
function figure(chart, picture, below) {
  const button = element("button", {class: "save", type: "button", title: "Save this chart"}, "SVG");
  button.addEventListener("click", () => saveSvg(picture, chart.title));
  const box = element("figure", {class: `chart ${chart.kind}`, "data-title": chart.title}, element("h2", {}, chart.title), button, picture, below);
  if (chart.note) box.append(element("p", {class: "note"}, chart.note));
  return box;
}

// A chart; `onTime`, for one over time, is told the time that was clicked. Returns {node, setTime}.
function drawChart(chart, onTime) {
  const c = CHART, overTime = /^time/.test(chart.x_title);
  for (const series of chart.series) series.x = series.x || series.y.map((_, i) => i + 1);
  const picture = svg("svg", {viewBox: `0 0 ${c.width} ${c.height}`, role: "img", "aria-label": `${chart.title}: ${chart.y_title} over ${chart.x_title}`});
  const whole = chart.kind === "points" ? false : overTime ? "ends" : "integers";
  const x = axis(chart.series.flatMap((s) => s.x), false, c.left, c.width - c.right, 8, whole);
  const y = axis(chart.series.flatMap((s) => s.y), chart.kind === "log", c.height - c.bottom, c.top, 5, false);
  const hasMarkers = (s) => chart.kind === "points" ? "only" : !overTime && s.y.length <= MOST_MARKERS;
  frame(picture, chart, x, y);
  chart.series.forEach((s, i) => curve(picture, chart, s, i, x, y, hasMarkers(s)));
  const names = legend(chart, hasMarkers);
  probe(picture, chart, x, names.values, overTime ? onTime : null);
  const cursor = svg("path", {class: "cursor"});
  if (overTime) picture.append(cursor);
  const setTime = (t) => {
    const place = x.to(Math.min(Math.max(t, x.low), x.high)).toFixed(1);
    cursor.setAttribute("d", `M${place},${c.top}V${c.height - c.bottom}`);
  };
  return {node: figure(chart, picture, chart.series.length > 1 ? names.box : ""), setTime: overTime ? setTime : null};
}
