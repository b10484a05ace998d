/* Charts: looks of the lines, logarithmic axes, marks, legends. */

Chart.defaults.font.family = "system-ui, 'Liberation Sans', Arial, sans-serif";

/* Okabe and Ito's colours (https://jfly.uni-koeln.de/color/), which colour-blind readers tell
 * apart, with a wine red in place of the yellow that white paper swallows. */
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000",
                 "#882255"];
const SHAPES = ["circle", "rect", "triangle", "rectRot", "crossRot", "star", "cross"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

/* 8 colours and 7 shapes repeat together after 56 lines only; each round of colours has another
 * dash, and every second round hollow points. */
const lookOf = index => {
  const round = Math.floor(index / COLOURS.length);
  const colour = COLOURS[index % COLOURS.length];
  return {
    colour,
    dash: DASHES[round % DASHES.length],
    shape: SHAPES[index % SHAPES.length],
    fill: round % 2 ? "#ffffff" : colour,
  };
};

const NEAR_ONE = 1e-9; /* rounding of log10 */
const tenTo = exponent => Number("1e" + exponent); /* 10 ** -5 is not 1e-5 everywhere */

/* {min, max}: the nearest 1, 2 or 5 times a power of ten on either side of the values. */
const logBounds = values => {
  const low = Math.min(...values), high = Math.max(...values);
  const steps = [];
  for (let e = Math.floor(Math.log10(low)) - 1; e <= Math.ceil(Math.log10(high)) + 1; e++)
    for (const factor of [1, 2, 5]) steps.push(Number(factor + "e" + e));
  return {min: steps.filter(step => step <= low * 0.95).pop(),
          max: steps.find(step => step >= high * 1.05)};
};

/* Powers of ten, thinned to what `room` labels can show; 1-2-5 where there are too few. */
const logTicks = (min, max, room) => {
  const first = Math.ceil(Math.log10(min) - NEAR_ONE);
  const last = Math.floor(Math.log10(max) + NEAR_ONE);
  const ticks = [];
  if (last - first >= 2) {
    const stride = Math.max(1, Math.ceil((last - first + 1) / room));
    for (let e = first; e <= last; e++)
      if (e % stride === 0) ticks.push({value: tenTo(e)});
    return ticks;
  }
  for (let e = first - 1; e <= last; e++)
    for (const factor of room > 4 ? [1, 2, 5] : [1, 3]) {
      const value = Number(factor + "e" + e);
      if (value >= min * (1 - NEAR_ONE) && value <= max * (1 + NEAR_ONE)) ticks.push({value});
    }
  return ticks;
};

/* 20, 50, 100 where the ticks are no whole decades, powers elsewhere. */
const tickText = (value, index, ticks) => {
  const decades = ticks.every(tick => /^1e/.test(tick.value.toExponential()));
  return !decades && value >= 0.01 && value < 1e4 ? String(value) : scientific(value);
};

const logAxis = (title, values, roomOf) => ({
  type: "logarithmic",
  title: {display: true, text: title, color: "#222"},
  ...logBounds(values),
  grid: {color: "#e2e2e2", tickColor: "#888"},
  ticks: {callback: tickText, autoSkip: false, maxRotation: 0, color: "#222"},
  afterBuildTicks: axis => {
    axis.ticks = logTicks(axis.min, axis.max, Math.max(2, roomOf(axis.chart)));
  },
});

const logX = (title, values) => logAxis(title, values, chart => Math.floor(chart.width / 60));
const logY = (title, values) => logAxis(title, values, chart => Math.floor(chart.height / 32));

const linearX = title => ({
  type: "linear",
  title: {display: true, text: title, color: "#222"},
  grid: {color: "#e2e2e2", tickColor: "#888"},
  ticks: {maxRotation: 0, autoSkipPadding: 12, color: "#222"},
});

const ASKED = {colour: "#a00000", width: 1.5, dash: [6, 4]};
const HORIZON = {colour: "#444444", width: 1.5, dash: [2, 2]};
const FLOOR_COLOUR = "rgba(90, 90, 90, 0.16)";
const FRONT = {colour: "rgba(240, 200, 60, 0.55)", width: 7, dash: []};

/* Stairs along a Pareto front: what a cost buys until the next case costs more. */
const stairs = (front, {x, y}, right) => {
  const steps = [];
  front.forEach((corner, i) => {
    const at = y.getPixelForValue(corner.y);
    steps.push({x: x.getPixelForValue(corner.x), y: at});
    steps.push({x: i + 1 < front.length ? x.getPixelForValue(front[i + 1].x) : right, y: at});
  });
  return steps;
};

const strokeStairs = (context, look, steps) => {
  context.strokeStyle = look.colour;
  context.lineWidth = look.width;
  context.lineJoin = "round";
  context.beginPath();
  steps.forEach((corner, i) => (i ? context.lineTo(corner.x, corner.y)
                                  : context.moveTo(corner.x, corner.y)));
  context.stroke();
};

/* The asked error (a line), what is too small for the reference to tell (shaded), the horizon (an
 * upright line) and the Pareto front (stairs). Their names stand in the key beneath, where they cover no point. */
const marks = {
  id: "marks",
  beforeDatasetsDraw(chart, args, {asked, floor, horizon, front}) {
    const {ctx, chartArea: area, scales: {x, y}} = chart;
    ctx.save();
    if (floor > y.min) {
      const top = Math.max(area.top, y.getPixelForValue(floor));
      ctx.fillStyle = FLOOR_COLOUR;
      ctx.fillRect(area.left, top, area.right - area.left, area.bottom - top);
    }
    if (asked) {
      const height = y.getPixelForValue(asked);
      strokeLine(ctx, ASKED, area.left, area.right, height);
    }
    if (front && front.length) strokeStairs(ctx, FRONT, stairs(front, chart.scales, area.right));
    if (horizon && horizon <= x.max) {
      const at = x.getPixelForValue(horizon);
      strokeUpright(ctx, HORIZON, at, area.top, area.bottom);
    }
    ctx.restore();
  },
};

const strokeFrom = (context, look, from, to) => {
  context.strokeStyle = look.colour;
  context.lineWidth = look.width;
  context.setLineDash(look.dash);
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
  context.setLineDash([]);
};

const strokeLine = (context, look, left, right, height) =>
  strokeFrom(context, look, [left, height], [right, height]);
const strokeUpright = (context, look, at, top, bottom) =>
  strokeFrom(context, look, [at, top], [at, bottom]);

/* The strokes, [from, to], of a point's interval of confidence; none where it has none. Its low end
 * may have no place on a logarithmic axis. */
const whisker = ({chartArea, scales: {y}}, {x}, {low, high}) => {
  if (typeof low !== "number" || typeof high !== "number" || low === high) return [];
  const placed = value => (y.type === "logarithmic" && value <= 0 ? chartArea.bottom + 9
    : y.getPixelForValue(value));
  const ends = [low, high].map(placed);
  return [[[x, ends[0]], [x, ends[1]]], ...ends.map(end => [[x - 4, end], [x + 4, end]])];
};

/* Intervals of confidence of points that have one. */
const whiskers = {
  id: "whiskers",
  beforeDatasetsDraw(chart) {
    const {ctx, chartArea: area} = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
    ctx.clip();
    for (const meta of chart.getSortedVisibleDatasetMetas()) {
      const set = chart.data.datasets[meta.index];
      ctx.strokeStyle = set.borderColor;
      meta.data.forEach((point, i) => {
        ctx.beginPath();
        for (const [from, to] of whisker(chart, point, set.data[i])) {
          ctx.moveTo(...from);
          ctx.lineTo(...to);
        }
        ctx.stroke();
      });
    }
    ctx.restore();
  },
};

/* How many points are on the screen: written where a test can read it. */
const countPoints = chart => {
  let drawn = 0;
  for (const meta of chart.getSortedVisibleDatasetMetas())
    for (const point of meta.data) {
      const {x, y} = point.getProps(["x", "y"], true);
      const {left, right, top, bottom} = chart.chartArea;
      if (!point.skip && x >= left - 1 && x <= right + 1 && y >= top - 1 && y <= bottom + 1)
        drawn++;
    }
  chart.canvas.dataset.points = drawn;
};

const MOST_TOLD = 3;

/* What is told of a point stands over the page, not within a canvas that may be lower than it: beside
 * the point, within the window. */
const tellPoint = ({chart, tooltip}) => {
  const {canvas} = chart, holder = canvas.parentNode;
  let box = holder.querySelector(".told-of");
  if (!box) {
    box = element("div", {className: "told-of"});
    holder.append(box);
  }
  box.hidden = tooltip.opacity === 0;
  if (box.hidden) return;
  box.replaceChildren(...tooltip.body.flatMap(({lines}, i) => [
    element("strong", {}, tooltip.title[i] || ""), ...lines.map(line => element("div", {}, line))]));
  box.style.left = box.style.top = "0";
  const {left, top} = holder.getBoundingClientRect(), {width, height} = box.getBoundingClientRect();
  const apart = 12, edge = 4, {caretX: x, caretY: y} = tooltip;
  const fits = left + x + apart + width + edge <= innerWidth;
  const wanted = left + (fits ? x + apart : x - apart - width);
  const above = top + y + apart + height > innerHeight && top + y - apart - height > 0;
  box.style.left = Math.max(edge, Math.min(wanted, innerWidth - width - edge)) - left + "px";
  box.style.top = (above ? y - apart - height : y + apart) + "px";
};

const FADED = "#dcdcdc";

const paint = (set, faded) => {
  set.borderColor = set.pointBorderColor = faded ? FADED : set.look.colour;
  set.pointBackgroundColor = faded ? "#ffffff" : set.look.fill;
  return set;
};

const dataset = (line, hidden, radius) => paint({
  label: line.name,
  look: line.look,
  data: line.points,
  hidden: hidden.has(line.name),
  order: line.above ? -1 : 0,
  showLine: !line.bare,
  spanGaps: false,
  borderDash: line.look.dash,
  borderWidth: 1.8,
  pointStyle: line.look.shape,
  pointBorderWidth: 1.5,
  pointRadius: radius,
  pointHoverRadius: radius + 3,
  pointHitRadius: 8,
  clip: 8, /* points on the frame stay whole */
}, false);

/* `plan`: {lines: [{name, look, bare (points alone), above (all others), points: [{x, y, low, high,
 * ...}]}], x, y (axes), marks, tooltip(point), hidden (names), radius, label (for screen readers),
 * csv: {heads, row(point, name of the line)} or undefined}. */
const makeChart = (canvas, plan) => {
  canvas.setAttribute("aria-label", plan.label);
  const chart = new Chart(canvas, {
    type: "scatter",
    data: {datasets: plan.lines.map(line => dataset(line, plan.hidden, plan.radius))},
    plugins: [marks, whiskers],
    options: {
      animation: false,
      maintainAspectRatio: false,
      devicePixelRatio: Math.max(2, window.devicePixelRatio || 1), /* legible when printed */
      scales: {x: plan.x, y: plan.y},
      interaction: {mode: "nearest", intersect: true},
      layout: {padding: {top: 6, right: 10}},
      plugins: {
        legend: {display: false},
        marks: plan.marks,
        tooltip: {
          enabled: false,
          external: tellPoint,
          filter: (item, index) => index < MOST_TOLD, /* of points that lie on one another */
          callbacks: {
            title: items => items.map(item => item.dataset.label),
            label: item => plan.tooltip(item.raw),
          },
        },
      },
    },
  });
  chart.csv = plan.csv;
  countPoints(chart);
  return chart;
};

/* A little picture for a key, 34 x 14. */
const picture = (...drawn) =>
  svgElement("svg", {class: "swatch", viewBox: "0 0 34 14", "aria-hidden": "true"}, ...drawn);
const across = look => svgLine([{x: 1, y: 7}, {x: 33, y: 7}], look);

const linePicture = ({look, bare}) =>
  picture(...(bare ? [] : [across(look)]), svgMarker(look, 17, 7));

const MARK_TEXTS = {
  asked: value => "asked: " + scientific(value),
  front: () => "Pareto front: no other case is as good and as cheap",
  floor: value => `below ${scientific(value)}, a hundred times the reference's own error: refused`,
  horizon: value => `horizon, t = ${Number(value.toPrecision(4))}: errors after it mean nothing`,
};

const markKey = ({asked, floor, horizon, front}) => {
  const key = (image, text) => element("span", {className: "mark"}, image, text);
  const keys = [];
  if (asked) keys.push(key(picture(across(ASKED)), MARK_TEXTS.asked(asked)));
  if (front && front.length) keys.push(key(picture(across(FRONT)), MARK_TEXTS.front()));
  if (floor)
    keys.push(key(picture(svgElement("rect", {x: 1, y: 1, width: 32, height: 12,
                                              fill: FLOOR_COLOUR})), MARK_TEXTS.floor(floor)));
  if (horizon)
    keys.push(key(picture(svgLine([{x: 17, y: 1}, {x: 17, y: 13}], HORIZON)),
                  MARK_TEXTS.horizon(horizon)));
  return keys;
};

const toggleLine = (charts, name, hidden) => {
  for (const chart of charts) {
    chart.data.datasets.forEach((set, index) => {
      if (set.label === name) chart.setDatasetVisibility(index, !hidden);
    });
    chart.update("none");
    countPoints(chart);
  }
};

/* Fades every line but that one; no name: none is faded. */
const pickOut = (charts, name) => {
  for (const chart of charts) {
    for (const set of chart.data.datasets) paint(set, name && set.label !== name);
    chart.update("none");
  }
};

/* Buttons that hide and show a line in every one of the charts, and pick it out under a mouse. */
const makeLegend = (lines, hidden, charts, marked) => {
  const legend = element("div", {className: "legend"});
  for (const line of lines) {
    const button = element("button", {type: "button", className: "line"}, linePicture(line),
                           element("span", {}, line.name));
    button.setAttribute("aria-pressed", String(!hidden.has(line.name)));
    button.addEventListener("click", () => {
      if (!hidden.delete(line.name)) hidden.add(line.name);
      button.setAttribute("aria-pressed", String(!hidden.has(line.name)));
      toggleLine(charts, line.name, hidden.has(line.name));
    });
    button.addEventListener("pointerenter", event => {
      if (event.pointerType === "mouse") pickOut(charts, line.name);
    });
    button.addEventListener("pointerleave", () => pickOut(charts, null));
    legend.append(button);
  }
  legend.append(...markKey(marked));
  return legend;
};
