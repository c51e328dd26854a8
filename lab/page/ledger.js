"use strict";
// Shows the error of one picture split over its shortcuts: bars, a table, and a signed map of the chosen part.
(() => {
  const ledger = JSON.parse(document.getElementById("data").textContent).ledger;
  if (!ledger) return;
  const at = id => document.getElementById(id);
  const hues = {effect: "#d9480f", interaction: "#7b5ea7", residual: "#8a94a3", total: "#1d2430"};
  const percent = value => (value === undefined ? "" : `${(100 * value).toFixed(1)}`);
  const short = value => (value === undefined ? "" : String(Number(value.toPrecision(3))));
  const nameOf = term => (term.kind === "residual" ? "residual." : "") + term.name;
  const parts = ledger.terms;
  const lines = [...parts, {...ledger.total, kind: "total", what: "the picture minus the reference", error: ledger.error}];
  let chosen = parts.length;

  function drawBars() {
    at("ledger-plot").style.height = `${70 + 34 * parts.length}px`;
    const bars = (name, of) => ({label: name, data: parts.map(of)});
    const colours = parts.map(term => hues[term.kind]);
    new Chart(at("ledger-bars"), {
      type: "bar",
      data: {
        labels: parts.map(nameOf),
        datasets: [
          bars("share of the squared error", term => 100 * (term.share || 0)),
          bars("share of the relmse", term => (ledger.total.relmse > 0 ? 100 * term.relmse / ledger.total.relmse : 0)),
        ].map((set, k) => ({...set, backgroundColor: colours.map(c => c + (k ? "66" : "")), borderColor: colours, borderWidth: 1})),
      },
      options: {
        animation: false,
        maintainAspectRatio: false,
        indexAxis: "y",
        interaction: {mode: "nearest", axis: "y", intersect: false},
        onClick: (event, hits) => { if (hits.length) choose(hits[0].index); },
        scales: {x: {title: {display: true, text: "% of the error; all bars add up to 100"}}, y: {ticks: {autoSkip: false}}},
        plugins: {tooltip: {callbacks: {
          label: item => `${item.dataset.label}: ${item.raw.toFixed(2)} %`,
          afterLabel: item => parts[item.dataIndex].what.match(/.{1,60}(\s|$)/g) || "",
        }}},
      },
    });
  }

  function drawTable() {
    const head = document.createElement("thead").appendChild(document.createElement("tr"));
    for (const title of ["part", "what it is", "share %", "of relmse %", "relmse", "mean |e|", "mean", "FLIP left", "options"])
      head.appendChild(document.createElement("th")).textContent = title;
    const body = document.createElement("tbody");
    lines.forEach((term, i) => {
      const line = body.insertRow();
      const button = line.insertCell().appendChild(document.createElement("button"));
      button.textContent = nameOf(term);
      button.addEventListener("click", () => choose(i));
      const ofRelmse = ledger.total.relmse > 0 ? term.relmse / ledger.total.relmse : undefined;
      const options = Object.entries(term.options || {}).map(([name, value]) => `--${name} ${value}`).join(" ");
      const cells = [term.what, percent(term.share), percent(ofRelmse), short(term.relmse), short(term.mean_absolute),
                     short(term.mean), short(term.error && term.error.flip),
                     options + (term.pictures ? ` (mean of ${term.pictures} seeds)` : "")];
      for (const cell of cells) line.insertCell().textContent = cell;
      line.cells[1].className = "wrapped";
      line.cells[cells.length].className = "wrapped";
    });
    at("ledger-table").replaceChildren(head.parentNode, body);
  }

  function choose(i) {
    chosen = i;
    at("ledger-map").src = lines[i].map;
    at("ledger-chosen").textContent = nameOf(lines[i]);
    [...at("ledger-table").tBodies[0].rows].forEach((line, k) => line.classList.toggle("chosen", k === chosen));
  }

  function describe() {
    const {reference, error} = ledger;
    const noise = reference.noise_relmse === undefined ? ""
      : `, of which the reference's own noise is about ${short(reference.noise_relmse)}`;
    at("ledger-summary").textContent =
      `The picture is ${ledger.image}, its FLIP ${short(error.flip)}, its relmse ${short(error.relmse)}${noise}. ` +
      `In ${ledger.differing_pixels} pixels the reference sees another opaque triangle.`;
    at("ledger-largest").textContent = `±${short(ledger.largest)}`;
    const list = (id, entries) => at(id).replaceChildren(...entries.map(({name, reason}) => {
      const item = document.createElement("li");
      item.textContent = `${name}: ${reason}`;
      return item;
    }));
    list("ledger-inseparable", ledger.inseparable);
    list("ledger-absent", ledger.absent);
  }

  at("ledger").hidden = false;
  describe();
  drawBars();
  drawTable();
  choose(chosen);
})();
