"use strict";
// Decides what the page shows before its reader has chosen anything: scales of axes, rows of the stages, the title.
// Nothing here touches the document, so that tests can call each function.
const choices = (() => {
  const widest = 20;  // the largest value over the least that a linear axis still shows
  const outlying = 5;  // a row is an outlier if its bar is longer than this many medians

  const positive = values => values.filter(value => Number.isFinite(value) && value > 0);
  const isWide = values => Math.max(...positive(values)) > widest * Math.min(...positive(values));

  // A scene that is a file is named without its folders.
  const sceneName = scene => scene.slice(scene.lastIndexOf("/") + 1) || scene;

  const canBeLogarithmic = values => positive(values).length > 0;
  // Values below 0 keep an axis linear, since a logarithmic one would leave them out. A 0 does not (logarithmicAxis).
  const prefersLogarithmic = values => isWide(values) && !values.some(value => value < 0);

  // Powers of ten are written as text and parsed, because 10 ** -5 is not the number nearest to 0.00001.
  const decimal = (digit, power) => Number(`${digit}e${power}`);
  const powerOf = value => Number(value.toExponential().split("e")[1]);

  // The range of a logarithmic axis and its ticks. The range ends at numbers of one digit, a little beyond the values.
  // A 0 among the values has a tick of its own at the low end, at the coordinate `zero`, a tenth of the axis below the
  // rest.
  function logarithmicAxis(values) {
    const beyond = 1.04;
    const least = Math.min(...positive(values)) / beyond, greatest = Math.max(...positive(values)) * beyond;
    const low = decimal(Math.floor(least / decimal(1, powerOf(least))), powerOf(least));
    const high = decimal(Math.ceil(greatest / decimal(1, powerOf(greatest))), powerOf(greatest));
    const decades = Math.log10(high / low);
    const digits = decades <= 1 ? [1, 2, 3, 4, 5, 6, 7, 8, 9] : decades <= 4 ? [1, 2, 5] : [1];
    const ticks = [];
    for (let power = powerOf(low); power <= powerOf(high); ++power)
      for (const digit of digits) {
        const value = decimal(digit, power);
        if (value >= low && value <= high) ticks.push({value, major: digit === 1});
      }
    if (!values.includes(0)) return {min: low, max: high, ticks};
    const zero = low / 10 ** (decades / 9);
    return {min: zero, max: high, ticks: [{value: zero, major: true}, ...ticks], zero};
  }

  // The text of a tick: "50", "2,000", "10M", "0.005", "1e-7".
  const tickText = value =>
    value >= 1e15 || value < 1e-4 ? value.toExponential()
    : value >= 1e6 ? value.toLocaleString("en", {notation: "compact"})
    : value >= 1 ? value.toLocaleString("en")
    : String(value);

  function median(values) {
    const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
    return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
  }

  // Indices of the bars beside which the others could not be told apart: none where the lengths do not span much.
  function outliers(lengths) {
    if (!isWide(lengths)) return [];
    const bound = outlying * median(positive(lengths));
    return [...lengths.keys()].filter(i => lengths[i] > bound);
  }

  return {widest, outlying, sceneName, canBeLogarithmic, prefersLogarithmic, logarithmicAxis, tickText, outliers};
})();
