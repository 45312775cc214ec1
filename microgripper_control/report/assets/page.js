"use strict";
// Draws the figures, of the recording that is chosen, and again where the width changes.

const PRINTED = { width: 690, share: 0.28 }; // of a figure on paper: pixels, height over width
const report = JSON.parse(document.getElementById("report-data").textContent);
let charts = [];

function drawFigure(figure, spec, group) {
  const title = figure.querySelector("h3").textContent;
  figure.hidden = !spec;
  if (!spec) return;
  const box = figure.querySelector(".chart");
  const chart = spec.kind === "map"
    ? new MapChart(box, spec, title)
    : new LineChart(box, spec, spec.linked ? group : new Group(), title, group);
  charts.push(chart);
  figure.dataset.drawn = String(box.querySelector("svg[role=img]") !== null);
}

function drawRecording(index) {
  charts = [];
  const [time, figures] = [new Group(), report.recordings[index] ?? {}];
  for (const figure of document.querySelectorAll("figure[data-figure]")) {
    const name = figure.dataset.figure;
    drawFigure(figure, figures[name] ?? report.figures[name], time);
  }
  document.documentElement.dataset.errors = String(window.reportErrors.length);
}

const chooser = document.getElementById("recording");
chooser?.addEventListener("change", () => drawRecording(Number(chooser.value)));
let width = window.innerWidth;
window.addEventListener("resize", () => {
  if (window.innerWidth === width) return; // a phone's address bar comes and goes
  width = window.innerWidth;
  charts.forEach((chart) => chart.draw());
});

// On paper everything is open and has the paper's width.
window.addEventListener("beforeprint", () => {
  document.querySelectorAll("details:not([open])").forEach((details) => {
    details.open = true;
    details.dataset.folded = "";
  });
  const { width: paper, share } = PRINTED;
  charts.forEach((chart) => chart.draw(chart instanceof MapChart ? paper / 2 - 8 : paper, share));
});
window.addEventListener("afterprint", () => {
  document.querySelectorAll("details[data-folded]").forEach((details) => {
    details.open = false;
    delete details.dataset.folded;
  });
  charts.forEach((chart) => chart.draw());
});
drawRecording(0);
