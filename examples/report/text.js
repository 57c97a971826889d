// SPDX-License-Identifier: MIT
// Numbers, elements and saved files.

function element(name, attributes, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

function svg(name, attributes, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  return node;
}

// The value of a CSS variable, e.g. "--ink".
function theme(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

const minus = (text) => text.replace(/-/g, "\u2212");

// Up to `digits` significant digits, with powers of ten where they are shorter.
function significant(x, digits) {
  if (x === null) return "\u2013";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-4) {
    const [front, power] = x.toExponential(digits - 1).split("e");
    return minus(front.replace(/\.?0+$/, "")) + "\u00b710" +
           String(Number(power)).replace(/./g, (c) => ({"-": "\u207b"})[c] || "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[c]);
  }
  return minus(String(Number(x.toPrecision(digits))));
}

function fixed(x, digits) {
  const text = x.toFixed(digits);
  return minus(Number(text) === 0 ? text.replace("-", "") : text);
}

function save(blob, name) {
  const link = element("a", {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// "Share of each base shape" is saved as share-of-each-base-shape.svg.
function fileName(title, extension) {
  return title.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "") + "." + extension;
}

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}
