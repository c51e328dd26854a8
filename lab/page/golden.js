"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const at = id => document.getElementById(id);
  at("title").textContent = data.title + ": pictures against their references";
  at("summary").textContent = data.summary;
  document.title = data.title + ": " + data.summary;

  // Pictures that differ come first, in the order of the jobs.
  const pictures = [...data.pictures.filter(p => !p.holds), ...data.pictures.filter(p => p.holds)];
  for (const picture of pictures) {
    const row = at("list").insertRow();
    const name = row.insertCell();
    if (picture.holds) {
      name.textContent = picture.name;
    } else {
      const link = name.appendChild(document.createElement("a"));
      link.href = "#" + encodeURIComponent(picture.name);
      link.textContent = picture.name;
    }
    const text = row.insertCell();
    text.className = "wrapped " + (picture.holds ? "pass" : "fail");
    text.textContent = picture.text;
  }

  for (const picture of pictures.filter(p => !p.holds)) {
    const card = at("picture").content.cloneNode(true);
    const part = selector => card.querySelector(selector);
    part("section").id = encodeURIComponent(picture.name);
    part("h2").textContent = picture.name;
    for (const change of picture.changes || []) {
      const line = part(".changes").appendChild(document.createElement("li"));
      line.textContent = change;
    }
    part(".now").src = picture.now;
    part(".left-picture").src = picture.reference;
    if (picture.map) part(".map").src = picture.map;
    else part(".map").remove();
    part(".flip").textContent = picture.flip === undefined ? "(some pixels are not finite)" : "(mean " + picture.flip.toPrecision(2) + ")";
    const compare = part(".compare"), slider = part(".slider");
    slider.addEventListener("input", () => compare.style.setProperty("--at", slider.value / 10 + "%"));
    at("pictures").appendChild(card);
  }
})();
