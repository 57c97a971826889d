// SPDX-License-Identifier: MIT
// A radar chart of shares between 0 and 1.

function drawRadar(chart) {
  const size = 330, centre = size / 2, radius = 105, n = chart.axes.length;
  const picture = svg("svg", {viewBox: `0 0 ${size + 120} ${size}`, role: "img", "aria-label": chart.title});
  const point = (i, share) => {
    const angle = 2 * Math.PI * i / n - Math.PI / 2;
    return [centre + 60 + radius * share * Math.cos(angle), centre + radius * share * Math.sin(angle)];
  };
  const outline = (shares) => "M" + shares.map((v, i) => point(i, v).map((p) => p.toFixed(2)).join(",")).join("L") + "Z";
  // A full circle would be lost on shares of a tenth each: the rim is the next round share above the largest.
  const most = Math.max(...chart.series.flatMap((s) => s.y));
  const rim = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1].find((v) => v >= most - 1e-9) || 1;
  for (const part of [0.25, 0.5, 0.75, 1]) picture.append(svg("path", {class: "grid", d: outline(chart.axes.map(() => part))}));
  chart.axes.forEach((name, i) => {
    const [x, y] = point(i, 1), [tx, ty] = point(i, 1 + 14 / radius), across = tx - centre - 60;
    picture.append(svg("path", {class: "grid", d: `M${centre + 60},${centre}L${x.toFixed(1)},${y.toFixed(1)}`}));
    const text = name.length > 18 ? name.slice(0, 17) + "\u2026" : name;
    picture.append(svg("text", {class: "axis", x: tx, y: ty + 4, "text-anchor": Math.abs(across) < 8 ? "middle" : across > 0 ? "start" : "end"}, text));
  });
  for (const part of [0.5, 1]) {
    const [, y] = point(0, part);
    picture.append(svg("text", {x: centre + 64, y: y + 12}, `${Number((100 * rim * part).toPrecision(3))} %`));
  }
  chart.series.forEach((series, i) => {
    const colour = seriesColour(series, i), group = svg("g", {class: "series", "data-name": series.name, "data-points": series.y.length});
    const shares = series.y.map((v) => Math.max(0, v) / rim);
    group.append(svg("path", {class: "curve", d: outline(shares), stroke: colour, "stroke-dasharray": i === 0 ? "6 3" : "",
                              style: `fill: ${i === 0 ? "none" : `color-mix(in srgb, ${colour} 22%, transparent)`}`}));
    shares.forEach((v, k) => group.append(svg("path", {class: "dot", d: marker(i), fill: colour, transform: `translate(${point(k, v).join(",")})`})));
    picture.append(group);
  });
  const names = element("div", {class: "legend"});
  chart.series.forEach((s, i) => names.append(element("span", {}, sample(s, i, true), s.name)));
  return {node: figure(chart, picture, names), setTime: null};
}
