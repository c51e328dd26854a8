"use strict";
// Decides the page's initial state: scales of axes, rows of the stages, the title. It does not use the document, so
// tests can call each function.
const choices = (() => {
  const widest = 20;  // the largest ratio of values that a linear axis shows
  const outlying = 5;  // a bar longer than this many medians is an outlier

  const positive = values => values.filter(value => Number.isFinite(value) && value > 0);
  const isWide = values => Math.max(...positive(values)) > widest * Math.min(...positive(values));

  // Names the scene; a file without its folders.
  const sceneName = scene => scene.slice(scene.lastIndexOf("/") + 1) || scene;

  const canBeLogarithmic = values => positive(values).length > 0;
  // Negative values keep an axis linear, because a logarithmic one would leave them out. Zeros do not (see
  // logarithmicAxis).
  const prefersLogarithmic = values => isWide(values) && !values.some(value => value < 0);

  // Powers of ten are parsed from text, because 10 ** -5 is not the number nearest to 0.00001.
  const decimal = (digit, power) => Number(`${digit}e${power}`);
  const powerOf = value => Number(value.toExponential().split("e")[1]);

  // Returns the range and ticks of a logarithmic axis. The range ends at numbers of one digit, a little beyond the
  // values. A 0 has a tick of its own at the low end, at the coordinate `zero`, a tenth of the axis below the rest.
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

  // Returns the text of a tick: "50", "2,000", "10M", "0.005", "1e-7".
  const tickText = value =>
    value >= 1e15 || value < 1e-4 ? value.toExponential()
    : value >= 1e6 ? value.toLocaleString("en", {notation: "compact"})
    : value >= 1 ? value.toLocaleString("en")
    : String(value);

  function median(values) {
    const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
    return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
  }

  // Returns the indices of bars so long that the others look alike; none if the lengths are similar.
  function outliers(lengths) {
    if (!isWide(lengths)) return [];
    const bound = outlying * median(positive(lengths));
    return [...lengths.keys()].filter(i => lengths[i] > bound);
  }

  return {widest, outlying, sceneName, canBeLogarithmic, prefersLogarithmic, logarithmicAxis, tickText, outliers};
})();
