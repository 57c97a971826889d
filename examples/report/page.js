// SPDX-License-Identifier: MIT
// Puts the page together from its data (examples/support/report.h).

function rowsOf(values, prefix) {
  const rows = [];
  for (const [key, value] of Object.entries(values)) {
    const name = prefix + key.replace(/_/g, " ");
    if (Array.isArray(value)) {
      const flat = value.every((v) => typeof v === "number" || typeof v === "string");
      if (flat) rows.push([name, value.length ? value.map(valueText).join(key === "grid" ? "\u2009\u00d7\u2009" : ", ") : "\u2013", value.join(", ")]);
      else value.forEach((v, i) => rows.push(...rowsOf(v, `${name} ${i + 1}: `)));
    } else if (value !== null && typeof value === "object") {
      rows.push(...rowsOf(value, `${name}: `));
    } else {
      rows.push([name, valueText(value), value === null ? "" : String(value)]);
    }
  }
  return rows;
}

function valueText(value) {
  if (value === null || value === "") return "\u2013";
  if (typeof value === "boolean") return value ? "yes" : "no";
  // Of paths the last part; all of it stands in the title.
  return typeof value === "number" ? significant(value, 6) : value.replace(/^.*\//, "");
}

function showFact(fact) {
  const number = element("b", {}, fact.value === null ? "\u2013" : fixed(fact.value * fact.scale, fact.digits));
  if (fact.unit) number.append(" ", element("small", {}, fact.unit));
  const box = element("div", {class: "fact", "data-value": fact.value}, number, element("span", {}, fact.label));
  if (fact.key) box.dataset.key = fact.key;
  return box;
}

function showTable(table) {
  const body = element("tbody");
  for (const [name, text, whole] of rowsOf(table.rows, ""))
    body.append(element("tr", {}, element("th", {scope: "row"}, name), element("td", {title: whole}, text)));
  return element("div", {}, element("h2", {}, table.title), element("table", {}, body));
}

function showPage() {
  const data = JSON.parse(find("data").textContent), of = (type) => data.items.filter((item) => item.type === type);
  document.title = `${data.title} \u2013 ${data.program}`;
  for (const name of ["program", "title", "subtitle", "command"]) find(name).textContent = data[name] || "";
  find("command-line").hidden = !data.command;
  find("facts").append(...of("fact").map(showFact));

  const swimmers = of("swimmer").map((item) => new Swimmer(item));
  swimmers.forEach((s, k) => ownColours.set(s.name, k === 0 && swimmers.length > 1 ? "var(--before)" : k < 2 ? "var(--after)" : `var(--s${k + 1})`));
  let player = null;
  const charts = of("chart").map((item) => item.kind === "radar" ? drawRadar(item) : drawChart(item, (t) => player && (player.pause(), player.setTime(t))));
  find("charts").append(...charts.map((chart) => chart.node));
  find("tables").append(...of("table").map(showTable));

  if (swimmers.length > 0) {
    const cursors = charts.map((chart) => chart.setTime).filter(Boolean);
    player = new Player(swimmers, (t) => cursors.forEach((set) => set(t)));
    const notes = ["Orange: where the noses start; blue: where they are. The floor is ruled in tenths of a metre."];
    if (player.streaks) notes.push("Streaks drift with the current.");
    if (player.view.kind === "canvas") notes.push("Drawn without WebGL or three.js, so more plainly.");
    if (swimmers.some((s) => s.times.length < s.data.frames)) notes.push("Some frames are left out.");
    find("stage-note").textContent = notes.join(" ");
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches && !/\bstill\b/.test(location.hash)) player.play();
  }
  let footer = `Made by ${data.program} with diffaqua ${data.library_version}.`;
  if (player && player.view.kind === "three") footer += ` The swimmers are drawn by three.js r${THREE.REVISION} (MIT licence).`;
  find("footer").textContent = footer;
  window.report = {data, player, swimmers};
}

showPage();
