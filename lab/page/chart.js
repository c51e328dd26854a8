"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const rows = data.results.rows;
  const at = id => document.getElementById(id);
  const scheme = {front: "#d9480f", other: "#5b7fa8", ink: "#1d2430"};
  const shown = value =>
    typeof value !== "number" ? String(value)
    : Number.isInteger(value) ? value.toLocaleString("en")
    : String(Number(value.toPrecision(4)));

  // Values that do not apply are absent from a row: a rasterizer moves no bytes and traces no rays, and has no layers
  // to lose.
  const bytes = row => row.bytes || {};
  const costs = {
    "time of a frame, ms": row => row.stages_ms.total_frame,
    "rays": row => row.rays.total,
    "bytes moved (readback and upload)": row => (bytes(row).readback || 0) + (bytes(row).upload || 0),
    "bytes of the layer cache": row => bytes(row).cache || 0,
  };
  const errors = {};
  for (const row of rows) {
    for (const name of Object.keys(row.error))
      if (name !== "nonfinite") errors[name] = other => other.error[name];
    for (const name of ["missed", "misassigned", "duplicated"])
      if (row.layers && name in row.layers) errors["layers " + name] = other => (other.layers || {})[name];
    if ("dropped_particles" in row) errors["dropped particles"] = other => other.dropped_particles;
  }
  // Explains the temporal measures; docs/cli.md defines them.
  const meanings = {
    flicker: "change from frame to frame, half its mean square, less the reference's own; below 0: it changes less",
    flicker_of_error: "the change from frame to frame of the difference to the reference: right motion does not count, so that blur hides nothing",
    warped_difference: "change along the motion where the frame before shows the same surface, less the reference's own",
    ghost: "what of the motion is left in the last frame: root mean square against the picture once everything rests",
    ghost_half_life: "frames at rest until the ghost is half as strong; 0: there is none above 1/255",
    settle_time: "frames at rest until the ghost stays at or below 1/255",
  };
  const sign = name => (data.larger_is_better.includes(name) ? -1 : 1);

  // Same rule as "pareto" of results.json, for any two axes.
  function front(points, direction) {
    const beats = (a, b) => a.x <= b.x && direction * a.y <= direction * b.y &&
                            (a.x < b.x || direction * a.y < direction * b.y);
    return points.filter(p => !points.some(q => beats(q, p)));
  }

  function fill(select, names, chosen) {
    names.forEach((name, i) => select.add(new Option(name, String(i), name === chosen, name === chosen)));
  }
  const picked = (select, from) => Object.keys(from)[select.selectedIndex];

  function facts(parent, entries) {
    parent.replaceChildren(...entries.map(([name, value]) => {
      const line = document.createElement("div");
      for (const text of [name, shown(value)]) line.appendChild(document.createElement("span")).textContent = text;
      return line;
    }));
  }
  const flat = (object, prefix = "") => Object.entries(object).flatMap(([key, value]) =>
    value !== null && typeof value === "object" ? flat(value, prefix + key + ".") : [[prefix + key, value]]);

  const quartileBars = {
    id: "quartileBars",
    afterDatasetsDraw(chart) {
      if (at("cost").selectedIndex !== 0) return;
      const {ctx, scales: {x, y}, chartArea: area} = chart;
      ctx.save();
      ctx.beginPath();
      ctx.rect(area.left, area.top, area.width, area.height);
      ctx.clip();
      ctx.strokeStyle = "#6b7280";
      for (const {data: points} of chart.data.datasets)
        for (const point of points) {
          const row = rows[point.i], level = y.getPixelForValue(point.y);
          ctx.beginPath();
          ctx.moveTo(x.getPixelForValue(row.p25.total_frame), level);
          ctx.lineTo(x.getPixelForValue(row.p75.total_frame), level);
          ctx.stroke();
        }
      ctx.restore();
    },
  };

  let selected = 0, pareto = null, stages = null;
  let showsOutliers = false;
  const wantsLog = {};  // by measure: the reader's choice of a logarithmic axis

  // Sets the box of an axis. Returns the range and ticks of a logarithmic axis, undefined for a linear one.
  function chooseScale(box, measure, values) {
    box.disabled = !choices.canBeLogarithmic(values);
    box.checked = !box.disabled && (wantsLog[measure] ?? choices.prefersLogarithmic(values));
    return box.checked ? choices.logarithmicAxis(values) : undefined;
  }

  function drawPareto() {
    const cost = picked(at("cost"), costs), error = picked(at("error"), errors);
    const all = rows.map((row, i) => ({i, x: costs[cost](row), y: errors[error](row)}));
    const measured = all.filter(p => p.y !== undefined);
    const log = {
      x: chooseScale(at("cost-log"), cost, measured.map(p => p.x)),
      y: chooseScale(at("error-log"), error, measured.map(p => p.y)),
    };
    const best = front(measured, sign(error)).sort((a, b) => a.x - b.x || sign(error) * (a.y - b.y));
    const isShown = p => (!log.x || p.x >= 0) && (!log.y || p.y >= 0);
    const place = (value, scale) => (scale && value === 0 ? scale.zero : value);
    const plotted = points => points.filter(isShown).map(p => ({i: p.i, x: place(p.x, log.x), y: place(p.y, log.y)}));
    const left = all.length - measured.filter(isShown).length;
    const isMean = data.results.frames && error in rows[0].error;
    at("meaning").textContent = error in meanings ? `${error}: ${meanings[error]}.` : isMean ? `${error}: mean over the frames.` : "";
    at("unplotted").textContent =
      left ? `Not drawn: ${left} without this error, or with a value below 0 that a logarithmic axis cannot show.` : "";
    const isBest = new Set(best.map(p => p.i));
    const style = colour => ({
      borderColor: colour,
      backgroundColor: colour,
      pointBackgroundColor: colour,
      pointBorderColor: c => (c.raw && c.raw.i === selected ? scheme.ink : "#fff"),
      pointBorderWidth: c => (c.raw && c.raw.i === selected ? 3 : 1),
      pointRadius: c => (c.raw && c.raw.i === selected ? 9 : 6),
      pointHoverRadius: 9,
      clip: false,  // draws points at the ends of an axis in full
    });
    const axis = (title, scale, isBetterHigh) => ({
      title: {
        display: true,
        text: title + (isBetterHigh ? " (higher is better)" : "") + (scale ? " (logarithmic)" : ""),
      },
      ...(scale ? {
        type: "logarithmic",
        min: scale.min,
        max: scale.max,
        afterBuildTicks: built => { built.ticks = scale.ticks.map(tick => ({...tick})); },
        ticks: {callback: value => (value === scale.zero ? "0" : choices.tickText(value))},
      } : {type: "linear", beginAtZero: !isBetterHigh, grace: "4%"}),
    });
    const config = {
      type: "scatter",
      plugins: [quartileBars],
      data: {datasets: [
        {label: "on the front", data: plotted(best), showLine: true, stepped: true, borderWidth: 1.5,
         ...style(scheme.front)},
        {label: "beaten", data: plotted(measured.filter(p => !isBest.has(p.i))), ...style(scheme.other)},
      ]},
      options: {
        animation: false,
        maintainAspectRatio: false,
        interaction: {mode: "nearest", intersect: true},
        scales: {x: axis(cost, log.x, false), y: axis(error, log.y, sign(error) < 0)},
        onClick: (event, hits) => { if (hits.length) select(hits[0].element.$context.raw.i); },
        onHover: (event, hits) => { event.native.target.style.cursor = hits.length ? "pointer" : "default"; },
        plugins: {tooltip: {callbacks: {
          title: items => items.map(item => `${item.raw.i}: ${data.points[item.raw.i].label}`),
          label: item => [[error, errors[error]], ...Object.entries(costs)]
            .map(([name, of]) => `${name}: ${shown(of(rows[item.raw.i]))}`),
        }}},
      },
    };
    if (pareto) pareto.destroy();
    pareto = new Chart(at("pareto"), config);
  }

  const timed = Object.keys(rows[0].stages_ms)
    .filter(name => !["load", "build", "total_frame", "kept_frame"].includes(name))
    .filter(name => rows.some(row => row.stages_ms[name] > 0));
  const hues = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22",
                "#17becf", "#393b79", "#ad494a"];

  const lengths = rows.map(row => timed.reduce((sum, name) => sum + (row.stages_ms[name] || 0), 0));
  const outliers = choices.outliers(lengths);

  function describeOutliers() {
    const names = outliers.map(i => `${i}: ${data.points[i].label} (${shown(lengths[i])} ms)`).join("; ");
    at("outliers").hidden = outliers.length === 0;
    at("outlier-names").textContent = `Rows that take more than ${choices.outlying} times the median are ` +
      `${showsOutliers ? "shown" : "left out, so that the others can be told apart"}: ${names}.`;
    at("outlier-switch").textContent = showsOutliers ? "Leave them out" : "Show them";
  }

  function drawStages() {
    const drawn = [...rows.keys()].filter(i => showsOutliers || !outliers.includes(i));
    describeOutliers();
    at("stages-plot").style.height = `${90 + 24 * drawn.length}px`;
    if (stages) stages.destroy();
    stages = new Chart(at("stages"), {
      type: "bar",
      data: {
        labels: drawn.map(i => `${i}: ${data.points[i].label}`),
        datasets: timed.map((name, k) => ({
          label: name, backgroundColor: hues[k % hues.length], data: drawn.map(i => rows[i].stages_ms[name] || 0)})),
      },
      options: {
        animation: false,
        maintainAspectRatio: false,
        indexAxis: "y",
        interaction: {mode: "nearest", axis: "y", intersect: false},
        onClick: (event, hits) => { if (hits.length) select(drawn[hits[0].index]); },
        scales: {x: {stacked: true, title: {display: true, text: "ms"}}, y: {stacked: true}},
      },
    });
  }

  function drawTable() {
    const titles = ["", "configuration", "front", data.metric, "frame", "p25", "p75", ...timed];
    const head = document.createElement("thead").appendChild(document.createElement("tr"));
    for (const title of titles) head.appendChild(document.createElement("th")).textContent = title;
    const body = document.createElement("tbody");
    rows.forEach((row, i) => {
      const line = body.insertRow();
      line.classList.toggle("front", row.pareto);
      line.insertCell().textContent = i;
      const button = line.insertCell().appendChild(document.createElement("button"));
      button.textContent = data.points[i].label;
      button.addEventListener("click", () => select(i));
      const error = row.error[data.metric];
      const cells = [row.pareto ? "★" : "", error === undefined ? "" : shown(error)];
      for (const times of [row.stages_ms, row.p25, row.p75]) cells.push(shown(times.total_frame));
      for (const name of timed) cells.push(shown(row.stages_ms[name] || 0));
      for (const cell of cells) line.insertCell().textContent = cell;
    });
    at("table").replaceChildren(head.parentNode, body);
  }

  // 0 is the reference, 1 + i is point i.
  const pictureOf = value => (value === 0 ? data.reference : data.points[value - 1].picture);

  function drawPictures() {
    const left = at("left").selectedIndex, right = at("right").selectedIndex;
    at("left-picture").src = pictureOf(left);
    at("right-picture").src = pictureOf(right);
    const map = left === 0 ? undefined : data.points[left - 1].map;
    at("map").hidden = map === undefined;
    if (map) at("map").src = map;
    const flip = left === 0 ? undefined : rows[left - 1].error.flip;
    const over = data.results.frames ? "mean over all frames" : "mean";
    at("flip").textContent = flip === undefined ? "" : `(${over} ${shown(flip)})`;
  }

  function select(i) {
    selected = i;
    at("left").selectedIndex = i + 1;
    at("chosen").textContent = `${i}: ${data.points[i].label}`;
    at("chosen-command").textContent = data.points[i].command;
    const {config, error, rays, pixels, layers, bytes: moved, scene} = rows[i];
    facts(at("facts"), flat({...config, ...Object.fromEntries(Object.entries({error, rays, pixels, layers, bytes: moved, scene})
      .filter(([, value]) => value !== undefined))}));
    [...at("table").tBodies[0].rows].forEach((line, k) => line.classList.toggle("chosen", k === i));
    drawPictures();
    pareto.update("none");
  }

  function describe() {
    const {scene, reference, frames} = data.results, {width, height, of, is_exact: isExact} = data.scale;
    document.title = `${choices.sceneName(scene)}: speed against accuracy`;
    at("title").textContent = document.title;
    const noise = "self_error" in reference ? `, relmse between its halves ${shown(reference.self_error)}` : "";
    at("summary").textContent =
      `${rows.length} configurations at ${of[0]} x ${of[1]}${frames ? `, frames ${frames.first} to ${frames.last},` : ""} ` +
      `against a reference of ${reference.light_samples} light samples${noise}; rounds: ${rows[0].repeats}; ${data.program}`;
    at("which").textContent = frames ? `of frame ${frames.last}, the last one; costs are medians over the frames` : "";
    at("scale").textContent = isExact
      ? "Drag over the picture. The pictures are in the page bit for bit as PNG values."
      : `Drag over the picture. The pictures are in the page as JPEG of ${width} x ${height}; images/ has them whole.`;
    const holds = (whole, part) => Object.entries(part).every(([key, value]) => whole[key] === value);
    // Rows without rays do not name the ray tracer; rows of shards may come from several machines.
    const devices = [];
    for (const {device} of [...rows].sort((a, b) => Object.keys(b.device).length - Object.keys(a.device).length))
      if (!devices.some(known => holds(known, device))) devices.push(device);
    facts(at("machine"), [
      ...Object.entries(data.machine),
      ...devices.flatMap((device, k) => flat(device, devices.length > 1 ? `device ${k + 1} ` : "")),
    ]);
    at("command").textContent = data.command;
    at("widest").textContent = choices.widest;
  }

  describe();
  fill(at("cost"), Object.keys(costs), Object.keys(costs)[0]);
  fill(at("error"), Object.keys(errors), data.metric);
  const pictures = ["reference", ...data.points.map((point, i) => `${i}: ${point.label}`)];
  fill(at("left"), pictures, pictures[1]);
  fill(at("right"), pictures, "reference");
  for (const [id, measures] of [["cost", costs], ["error", errors]]) {
    const box = at(id + "-log");
    box.addEventListener("change", () => { wantsLog[picked(at(id), measures)] = box.checked; });
  }
  at("axes").addEventListener("change", drawPareto);
  at("outlier-switch").addEventListener("click", () => {
    showsOutliers = !showsOutliers;
    drawStages();
  });
  at("left").addEventListener("change", () => {
    const i = at("left").selectedIndex - 1;
    if (i < 0) drawPictures(); else select(i);
  });
  at("right").addEventListener("change", drawPictures);
  at("slider").addEventListener("input", () =>
    at("compare").style.setProperty("--at", `${at("slider").valueAsNumber / 10}%`));
  drawTable();
  drawStages();
  drawPareto();
  const firstOnFront = rows.findIndex(row => row.pareto);
  select(Math.max(firstOnFront, 0));
})();
