/* Figures and tables as files: SVG as it is drawn, CSV with every digit. */

const NAMESPACE = "http://www.w3.org/2000/svg";

const svgElement = (tag, attributes, ...children) => {
  const made = document.createElementNS(NAMESPACE, tag);
  for (const [key, value] of Object.entries(attributes))
    made.setAttribute(key, typeof value === "number" ? String(Number(value.toFixed(2))) : value);
  made.append(...children);
  return made;
};

const FONT = "'Liberation Sans', Arial, Helvetica, sans-serif";
const svgText = (text, x, y, anchor, size = 12, more = {}) =>
  svgElement("text", {x, y, "text-anchor": anchor, "font-size": size, fill: "#222", ...more}, text);

/* Shapes of points within 4.5 of the origin; strokes for those without an inside. */
const SHAPE_PATHS = {
  rect: "M-3.6,-3.6H3.6V3.6H-3.6Z",
  triangle: "M0,-4.5L4.1,3.2H-4.1Z",
  rectRot: "M0,-4.8L4.8,0L0,4.8L-4.8,0Z",
  cross: "M-4.5,0H4.5M0,-4.5V4.5",
  crossRot: "M-3.3,-3.3L3.3,3.3M-3.3,3.3L3.3,-3.3",
  star: "M-4.5,0H4.5M0,-4.5V4.5M-3.3,-3.3L3.3,3.3M-3.3,3.3L3.3,-3.3",
};

const svgMarker = (look, x, y, scale = 1) => {
  const paint = {fill: look.fill, stroke: look.colour, "stroke-width": 1.4};
  if (look.shape === "circle") return svgElement("circle", {cx: x, cy: y, r: 4 * scale, ...paint});
  return svgElement("path", {d: SHAPE_PATHS[look.shape] || SHAPE_PATHS.rect, ...paint,
                             transform: `translate(${x.toFixed(2)} ${y.toFixed(2)}) scale(${scale})`});
};

const svgLine = (points, look) =>
  svgElement("polyline", {points: points.map(({x, y}) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" "),
                          fill: "none", stroke: look.colour, "stroke-width": look.width || 1.8,
                          "stroke-dasharray": look.dash.join(" ")});

/* Grid, tick labels, titles of both axes. */
const svgAxes = chart => {
  const {chartArea: area, scales: {x, y}} = chart;
  const group = svgElement("g", {});
  const line = (x1, y1, x2, y2) =>
    group.append(svgElement("line", {x1, y1, x2, y2, stroke: "#ddd"}));
  x.ticks.forEach((tick, i) => {
    const at = x.getPixelForTick(i);
    line(at, area.top, at, area.bottom);
    group.append(svgText(tick.label, at, area.bottom + 16, "middle"));
  });
  y.ticks.forEach((tick, i) => {
    const at = y.getPixelForTick(i);
    line(area.left, at, area.right, at);
    const lines = [tick.label].flat(), first = at + 4 - 7 * (lines.length - 1);
    lines.forEach((text, k) => group.append(svgText(text, area.left - 6, first + 14 * k, "end")));
  });
  const middle = (area.top + area.bottom) / 2;
  group.append(
    svgElement("rect", {x: area.left, y: area.top, width: area.right - area.left,
                        height: area.bottom - area.top, fill: "none", stroke: "#888"}),
    svgText(x.options.title.text, (area.left + area.right) / 2, area.bottom + 36, "middle"),
    svgText(y.options.title.text, 14, middle, "middle", 12, {transform: `rotate(-90 14 ${middle})`}));
  return group;
};

/* What is visible, in the order of the legend. */
const visibleMetas = chart =>
  [...chart.getSortedVisibleDatasetMetas()].sort((a, b) => a.index - b.index);

/* The visible lines with their points, clipped to the frame, one over another as on the screen. */
const svgData = chart => {
  const group = svgElement("g", {"clip-path": `url(#frame-${chart.id})`});
  for (const meta of [...chart.getSortedVisibleDatasetMetas()].reverse()) {
    const set = chart.data.datasets[meta.index];
    const points = meta.data.filter(point => !point.skip)
      .map(point => point.getProps(["x", "y"], true));
    if (set.showLine) group.append(svgLine(points, set.look));
    const plain = {colour: set.look.colour, dash: []};
    meta.data.forEach((point, i) => {
      if (!point.skip)
        group.append(...whisker(chart, point, set.data[i])
          .map(ends => svgLine(ends.map(([x, y]) => ({x, y})), plain)));
    });
    if (set.pointRadius > 0)
      for (const {x, y} of points) group.append(svgMarker(set.look, x, y, set.pointRadius / 4.5));
  }
  return group;
};

/* Names beneath the frame, as many a row as there is room for; the height they take. */
const svgKey = (chart, width, top) => {
  const group = svgElement("g", {});
  let x = 12, y = top;
  for (const meta of visibleMetas(chart)) {
    const set = chart.data.datasets[meta.index], room = 48 + 6.6 * set.label.length;
    if (x > 12 && x + room > width) {
      x = 12;
      y += 18;
    }
    if (set.showLine) group.append(svgLine([{x, y}, {x: x + 30, y}], set.look));
    group.append(svgMarker(set.look, x + 15, y),
                 svgText(set.label, x + 36, y + 4, "start"));
    x += room;
  }
  return {group, bottom: y + 14};
};

/* What `marks` draws on the screen, as far as it is within the frame. */
const MARK_SHAPES = {
  floor: ({chartArea: area, scales: {y}}, value) => {
    const top = Math.max(area.top, y.getPixelForValue(value));
    return svgElement("rect", {x: area.left, y: top, width: area.right - area.left,
                               height: Math.max(0, area.bottom - top), fill: FLOOR_COLOUR});
  },
  asked: ({chartArea: area, scales: {y}}, value) => {
    const at = y.getPixelForValue(value);
    return svgLine([{x: area.left, y: at}, {x: area.right, y: at}], ASKED);
  },
  front: ({chartArea: area, scales}, value) => svgLine(stairs(value, scales, area.right), FRONT),
  horizon: ({chartArea: area, scales: {x}}, value) => {
    const at = x.getPixelForValue(value);
    return svgLine([{x: at, y: area.top}, {x: at, y: area.bottom}], HORIZON);
  },
};

const marksOfChart = chart => {
  const marked = chart.options.plugins.marks || {};
  const isThere = value => (Array.isArray(value) ? value.length > 0 : value);
  return Object.keys(MARK_SHAPES).filter(kind => isThere(marked[kind]))
    .map(kind => [kind, marked[kind]]);
};

/* A line of text a mark; from `top` down. */
const svgMarkKey = (chart, top) => {
  const group = svgElement("g", {});
  marksOfChart(chart).forEach(([kind, value], i) => {
    const y = top + 18 * i, look = {asked: ASKED, front: FRONT, horizon: HORIZON}[kind];
    group.append(look ? svgLine([{x: 12, y}, {x: 42, y}], look)
                      : svgElement("rect", {x: 12, y: y - 6, width: 30, height: 12,
                                            fill: FLOOR_COLOUR}),
                 svgText(MARK_TEXTS[kind](value), 48, y + 4, "start"));
  });
  return {group, bottom: top + 18 * marksOfChart(chart).length};
};

/* The chart as it stands, hidden lines left out. The groups `more` stand beneath, down to `bottom`. */
const svgPicture = (chart, bottom, ...more) => {
  const {chartArea: area, width} = chart;
  const root = svgElement("svg", {
    xmlns: NAMESPACE, width, height: bottom, viewBox: `0 0 ${width} ${bottom}`,
    "font-family": FONT});
  root.append(
    svgElement("defs", {}, svgElement("clipPath", {id: "frame-" + chart.id}, svgElement("rect", {
      x: area.left - 6, y: area.top - 6, width: area.right - area.left + 12,
      height: area.bottom - area.top + 12}))),
    svgElement("rect", {width: "100%", height: "100%", fill: "#fff"}), svgAxes(chart));
  const framed = svgElement("g", {"clip-path": `url(#frame-${chart.id})`});
  framed.append(...marksOfChart(chart).map(([kind, value]) => MARK_SHAPES[kind](chart, value)));
  root.append(framed, svgData(chart), ...more);
  return root;
};

/* With its key, as the text of a file. */
const svgOf = chart => {
  const key = svgKey(chart, chart.width, chart.chartArea.bottom + 56);
  const marks = svgMarkKey(chart, key.bottom + 4);
  return new XMLSerializer().serializeToString(
    svgPicture(chart, marks.bottom, key.group, marks.group));
};

/* --- paper: lines, not pixels, and nothing folded away that a narrow window has folded --- */

const foldedTables = new Set();

addEventListener("beforeprint", () => {
  for (const canvas of document.querySelectorAll("canvas[data-chart]")) {
    const chart = Chart.getChart(canvas);
    if (!chart) continue;
    const drawn = svgPicture(chart, chart.height);
    drawn.classList.add("vector");
    canvas.before(drawn);
  }
  for (const folded of document.querySelectorAll("details.table:not([open])")) {
    foldedTables.add(folded);
    folded.open = true;
  }
});
addEventListener("afterprint", () => {
  for (const drawn of document.querySelectorAll("svg.vector")) drawn.remove();
  for (const folded of foldedTables) folded.open = false;
  foldedTables.clear();
});

/* --- CSV (RFC 4180) --- */

const csvCell = value => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\n\r]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
};

const csvOf = rows => rows.map(row => row.map(csvCell).join(",") + "\r\n").join("");

/* Every visible point of a chart as its plan tells it, or else the line's name, what sets the point
 * apart, and its place. */
const csvOfChart = chart => {
  const {x, y} = chart.scales;
  const {heads, row} = chart.csv || {
    heads: ["line", "case", x.options.title.text, y.options.title.text],
    row: (point, line) => [line, point.one ? point.one.label : "", point.x, point.y],
  };
  const rows = [heads];
  for (const meta of visibleMetas(chart)) {
    const set = chart.data.datasets[meta.index];
    for (const point of set.data) rows.push(row(point, set.label));
  }
  return csvOf(rows);
};

/* --- saving --- */

const fileName = (name, ending) =>
  name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "") + ending;

const save = (name, type, text) => {
  const link = element("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

const saveButton = (words, act) => {
  const button = element("button", {type: "button"}, words);
  button.addEventListener("click", act);
  return button;
};

/* Buttons for the chart that `current()` gives at the time; `name` begins the files' names. */
const chartSaver = (name, current) =>
  element("p", {className: "save"}, "Save: ",
          saveButton("SVG", () => current()
                     && save(fileName(name, ".svg"), "image/svg+xml", svgOf(current()))),
          saveButton("CSV", () => current()
                     && save(fileName(name, ".csv"), "text/csv", csvOfChart(current()))));

const tableSaver = (name, rows) =>
  element("p", {className: "save"}, "Save: ",
          saveButton("CSV", () => save(fileName(name, ".csv"), "text/csv", csvOf(rows()))));
