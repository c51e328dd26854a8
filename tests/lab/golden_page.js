// node golden_page.js PAGE: runs the script of PAGE, a golden page, on pictures made here, with a document that only records what
// it is given. The exit code is 0 if the page does what the test expects.
"use strict";
const assert = require("assert").strict;
const fs = require("fs");
const vm = require("vm");

const html = fs.readFileSync(process.argv[2], "utf8");
const script = html.match(/<script>\n([^]*?)<\/script>/)[1];
const ids = new Set([...html.matchAll(/ id="([^"]+)"/g)].map(match => match[1]));
const classes = new Set([...html.matchAll(/ class="([^"]+)"/g)].flatMap(match => match[1].split(" ")));

class Element {
  constructor() {
    this.children = [], this.listeners = {}, this.textContent = "", this.parts = new Map();
    this.properties = {};
    this.style = {setProperty: (name, value) => { this.properties[name] = value; }};
  }
  appendChild(child) { this.children.push(child); return child; }
  insertRow() { return this.appendChild(new Element()); }
  insertCell() { return this.appendChild(new Element()); }
  remove() { this.isRemoved = true; }
  addEventListener(type, listener) { this.listeners[type] = listener; }
  cloneNode() { return new Element(); }
  get content() { return this; }
  querySelector(selector) {
    assert(selector[0] !== "." || classes.has(selector.slice(1)), `the page has no ${selector}`);
    if (!this.parts.has(selector)) this.parts.set(selector, new Element());
    return this.parts.get(selector);
  }
}

const elements = new Map();
const at = id => {
  assert(ids.has(id), `the page has no element ${id}`);
  if (!elements.has(id)) elements.set(id, new Element());
  return elements.get(id);
};
const document = {title: "", getElementById: at, createElement: () => new Element()};
at("data").textContent = JSON.stringify({title: "t", summary: "2 of 3", pictures: [
  {name: "same", holds: true, text: "equal"},
  {name: "moved ball", holds: false, text: "differs", changes: ["ball moved", "lamp is gone"], reference: "r", now: "n", map: "m", flip: 0.01234},
  {name: "dark", holds: false, text: "not finite", reference: "r2", now: "n2"}]});
vm.runInNewContext(script, {document, JSON, encodeURIComponent});

assert.equal(document.title, "t: 2 of 3");
const rows = at("list").children.map(row => row.children);
// What differs comes first, and links to its pictures.
assert.deepEqual(rows.map(([name]) => name.textContent || name.children[0].textContent), ["moved ball", "dark", "same"]);
assert.equal(rows[0][0].children[0].href, "#moved%20ball");
assert.equal(rows[2][0].children.length, 0);
assert.deepEqual(rows.map(([, text]) => text.className), ["wrapped fail", "wrapped fail", "wrapped pass"]);

const [moved, dark, ...others] = at("pictures").children;
assert.equal(others.length, 0);
assert.equal(moved.querySelector("section").id, "moved%20ball");
assert.deepEqual(moved.querySelector(".changes").children.map(line => line.textContent), ["ball moved", "lamp is gone"]);
assert.deepEqual([".now", ".left-picture", ".map"].map(part => moved.querySelector(part).src), ["n", "r", "m"]);
assert.equal(moved.querySelector(".flip").textContent, "(mean 0.012)");
assert(dark.querySelector(".map").isRemoved);
assert.equal(dark.querySelector(".flip").textContent, "(some pixels are not finite)");
const slider = moved.querySelector(".slider");
slider.value = 250;
slider.listeners.input();
assert.equal(moved.querySelector(".compare").properties["--at"], "25%");
