// node chart_page.js PAGE: runs the scripts of PAGE, a chart's index.html, on rows made here, with a document and a
// chart library that only record what they are given. The exit code is 0 if the page does what the tests expect.
"use strict";
const assert = require("assert").strict;
const fs = require("fs");
const vm = require("vm");

class Element {
  constructor() {
    Object.assign(this, {children: [], listeners: {}, textContent: "", selectedIndex: -1, checked: false,
                         disabled: false, hidden: false, style: {setProperty() {}}, classList: {toggle() {}}});
  }
  append(child) { child.parentNode = this; this.children.push(child); return child; }
  appendChild(child) { return this.append(child); }
  replaceChildren(...children) { this.children = children; }
  add(option) {
    this.children.push(option);
    if (option.isSelected) this.selectedIndex = this.children.length - 1;
  }
  insertRow() { return this.append(new Element()); }
  insertCell() { return this.append(new Element()); }
  get rows() { return this.children; }
  get cells() { return this.children; }
  get tBodies() { return [this.children[1]]; }
  addEventListener(type, listener) { (this.listeners[type] ||= []).push(listener); }
  fire(type) { for (const listener of this.listeners[type] || []) listener({target: this}); }
}

const html = fs.readFileSync(process.argv[2], "utf8");
// The first script is Chart.js.
const scripts = [...html.matchAll(/<script>\n([^]*?)<\/script>/g)].map(match => match[1]).slice(1);
const ids = new Set([...html.matchAll(/ id="([^"]+)"/g)].map(match => match[1]));

// The page of `data`: `at` finds an element, `charts` holds what the library was last given for each canvas.
function open(data) {
  const elements = new Map(), charts = new Map();
  const at = id => {
    assert(ids.has(id), `the page has no element ${id}`);
    if (!elements.has(id)) elements.set(id, new Element());
    return elements.get(id);
  };
  at("data").textContent = JSON.stringify(data);
  const document = {title: "", getElementById: at, createElement: () => new Element()};
  class Chart {
    constructor(canvas, config) {
      for (const [id, element] of elements) if (element === canvas) this.id = id;
      assert(!charts.has(this.id), `${this.id} is drawn upon a chart that is still there`);
      charts.set(this.id, config);
    }
    update() {}
    destroy() { charts.delete(this.id); }
  }
  class Option {
    constructor(text, value, isDefault, isSelected) { Object.assign(this, {text, isSelected}); }
  }
  const context = vm.createContext({document, Chart, Option});
  for (const script of scripts) vm.runInContext(script, context);
  const choose = (list, text) => {
    at(list).selectedIndex = at(list).children.findIndex(option => option.text === text);
    at("axes").fire("change");
  };
  const check = (box, isChecked) => {  // as a browser does: the change of a box reaches the form around it
    at(box).checked = isChecked;
    at(box).fire("change");
    at("axes").fire("change");
  };
  return {at, document, charts, choose, check, choices: vm.runInContext("choices", context)};
}

// One row for each time, unless `more` says otherwise of row i.
function dataOf(times, more = () => ({})) {
  const rows = times.map((time, i) => ({
    stages_ms: {load: 5, gbuffer: time / 4, trace: 3 * time / 4, total_frame: time},
    p25: {total_frame: time}, p75: {total_frame: time},
    rays: {total: 1000}, error: {flip: 0.1}, config: {}, device: {}, pixels: {}, repeats: 1, pareto: i === 0,
    ...more(i),
  }));
  return {
    results: {scene: "/models/glass.v2/Cup And Water.glb", reference: {light_samples: 4}, rows},
    points: times.map((_, i) => ({label: `point ${i}`, command: "", picture: "data:,"})),
    metric: "flip", larger_is_better: ["psnr"], command: "", program: "", machine: {}, reference: "data:,",
    scale: {width: 1, height: 1, of: [1, 1], is_exact: true},
  };
}

const scales = page => page.charts.get("pareto").options.scales;
const plotted = page => page.charts.get("pareto").data.datasets.flatMap(set => set.data);
const bars = page => page.charts.get("stages").data.labels;
const labels = axis => {
  const built = {ticks: []};
  axis.afterBuildTicks(built);
  return [...built.ticks].map(tick => axis.ticks.callback(tick.value));
};
const others = Array.from({length: 43}, (_, i) => 300 + 10 * i);

const tests = {
  "the title is the name of the file"() {
    const page = open(dataOf([1]));
    assert.equal(page.document.title, "Cup And Water.glb: speed against accuracy");
    assert.equal(page.at("title").textContent, page.document.title);
    assert.equal(page.choices.sceneName("forest?count=20"), "forest?count=20");
    assert.equal(page.choices.sceneName("a/b.gltf"), "b.gltf");
  },

  "one row of 13 s makes the axis of times logarithmic and leaves the stages"() {
    const page = open(dataOf([...others, 13000]));
    assert.equal(scales(page).x.type, "logarithmic");
    assert.equal(scales(page).y.type, "linear");
    assert(page.at("cost-log").checked && !page.at("error-log").checked);
    assert.equal(plotted(page).length, 44);
    assert.deepEqual(labels(scales(page).x), ["200", "500", "1,000", "2,000", "5,000", "10,000", "20,000"]);
    assert.equal(bars(page).length, 43);
    assert(!bars(page).includes("43: point 43"));
    assert.equal(page.at("outliers").hidden, false);
    assert.match(page.at("outlier-names").textContent, /left out.*: 43: point 43 \(13,000 ms\)\.$/);
  },

  "one click brings the row back, another leaves it out"() {
    const page = open(dataOf([13000, ...others]));
    const chart = () => page.charts.get("stages");
    chart().options.onClick({}, [{index: 0}]);
    assert.equal(page.at("chosen").textContent, "1: point 1", "a bar selects its own row");
    assert.equal(page.at("outlier-switch").textContent, "Show them");
    page.at("outlier-switch").fire("click");
    assert.equal(bars(page)[0], "0: point 0");
    assert.equal(bars(page).length, 44);
    assert.equal(chart().data.datasets[0].data.length, 44);
    assert.equal(page.at("outlier-switch").textContent, "Leave them out");
    page.at("outlier-switch").fire("click");
    assert.equal(bars(page).length, 43);
  },

  "a narrow span stays linear and whole"() {
    for (const times of [[7], [10, 200], [0.5, 1, 10]]) {
      const page = open(dataOf(times));
      assert.equal(scales(page).x.type, "linear", times);
      assert.equal(scales(page).x.beginAtZero, true);
      assert.equal(page.at("cost-log").checked, false);
      assert.equal(bars(page).length, times.length);
      assert.equal(page.at("outliers").hidden, true);
    }
    assert.equal(scales(open(dataOf([10, 201]))).x.type, "logarithmic");
  },

  "a box overrules the choice for its measure alone"() {
    const page = open(dataOf([...others, 13000], i => ({rays: {total: 10 ** (i % 4)}})));
    page.check("cost-log", false);
    assert.equal(scales(page).x.type, "linear");
    page.choose("cost", "rays");
    assert.equal(scales(page).x.type, "logarithmic");
    page.choose("cost", "time of a frame, ms");
    assert.equal(scales(page).x.type, "linear", "the reader's choice is kept");
    page.check("error-log", true);
    assert.equal(scales(page).y.type, "logarithmic");
    assert.equal(scales(page).x.type, "linear");
  },

  "a logarithmic axis shows 0 at its end"() {
    const page = open(dataOf([1, 2, 3], i => ({rays: {total: [0, 1500, 1e7][i]}})));
    page.choose("cost", "rays");
    const {x} = scales(page);
    assert.equal(x.type, "logarithmic");
    assert.deepEqual(labels(x), ["0", "1,000", "10,000", "100,000", "1M", "10M"]);
    const points = plotted(page);
    assert.equal(points.length, 3);
    assert.equal(points.find(point => point.i === 0).x, x.min);
    assert(points.every(point => point.x > 0));
    assert.equal(page.at("unplotted").textContent, "");
  },

  "values below 0 keep an axis linear, and a logarithmic one names them"() {
    const page = open(dataOf([1, 2, 3], i => ({error: {flip: [-0.001, 0.01, 1][i]}})));
    assert.equal(scales(page).y.type, "linear");
    page.check("error-log", true);
    assert.equal(plotted(page).length, 2);
    assert.match(page.at("unplotted").textContent, /^Not drawn: 1 /);
  },

  "where nothing is above 0 there is no logarithmic axis"() {
    const page = open(dataOf([1, 2], () => ({rays: {total: 0}})));
    page.choose("cost", "rays");
    assert.equal(scales(page).x.type, "linear");
    assert.equal(page.at("cost-log").disabled, true);
  },

  "a row without the error has no part in the choice"() {
    const page = open(dataOf([1, 2, 100], i => ({error: i < 2 ? {flip: 0.1} : {}})));
    assert.equal(scales(page).x.type, "linear");
    assert.equal(plotted(page).length, 2);
  },

  "ticks are 1, 2, 5 and 10 times powers of ten"() {
    const {choices} = open(dataOf([1]));
    const texts = values => [...choices.logarithmicAxis(values).ticks].map(tick => choices.tickText(tick.value));
    assert.deepEqual(texts([0.00021, 0.0045]), ["0.0002", "0.0005", "0.001", "0.002", "0.005"]);
    assert.deepEqual(texts([12, 45]), ["10", "20", "30", "40", "50"]);
    assert.deepEqual(texts([3e-7, 9e-6]), ["2e-7", "5e-7", "1e-6", "2e-6", "5e-6", "1e-5"]);
    assert.deepEqual(texts([1.5, 9e5]), ["1", "10", "100", "1,000", "10,000", "100,000", "1M"]);
    for (const values of [[1], [1, 1e9], [9.9, 10.1], [1e-12, 1e-11], [1e-300, 1e300]]) {
      const {min, max, ticks} = choices.logarithmicAxis(values);
      assert(min <= Math.min(...values) && max >= Math.max(...values), values);
      assert(ticks.length >= 2, values);
    }
  },

  "outliers are few, and only where lengths span much"() {
    const {choices} = open(dataOf([1]));
    assert.deepEqual([...choices.outliers([1, 1, 1, 100])], [3]);
    assert.deepEqual([...choices.outliers([100, 1, 200, 1, 1])], [0, 2]);
    assert.deepEqual([...choices.outliers([1, 1, 1, 19])], [], "all can be told apart");
    assert.deepEqual([...choices.outliers([1, 30, 30, 30])], [], "one that is fast is no outlier");
    assert.deepEqual([...choices.outliers([1, 1, 40, 40])], [], "half of the rows are no outliers");
    assert.deepEqual([...choices.outliers([0, 0, 0])], []);
    assert.deepEqual([...choices.outliers([])], []);
  },
};

let failures = 0;
for (const [name, test] of Object.entries(tests)) {
  try {
    test();
  } catch (error) {
    ++failures;
    console.error(`${name}: ${error.stack}`);
  }
}
process.exit(failures ? 1 : 0);
