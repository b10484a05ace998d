/* The page: sections in reading order, made from the results. Text goes in as text only. */

const results = JSON.parse(document.getElementById("results").textContent);
const page = document.getElementById("page");

const strong = text => element("strong", {}, text);
const folded = (summary, ...children) =>
  element("details", {}, element("summary", {}, summary), ...children);
const pre = text => element("pre", {}, text);

/* Kinds of error; those with `time` are known at every sample. */
const METRICS = {
  position: {
    name: "position error",
    axis: "RMS position error at the end [length]",
    time: "RMS position error [length]",
    value: one => one.position_error,
  },
  "position-worst": {
    name: "worst particle's position error",
    axis: "largest particle's position error at the end [length]",
    value: one => one.position_error_max,
  },
  "position-ever": {
    name: "largest position error over time",
    axis: "largest RMS position error at any sample [length]",
    value: one => one.position_error_ever,
  },
  energy: {
    name: "energy error",
    axis: "largest |energy error| / energy scale [1]",
    time: "|energy error| / energy scale [1]",
    value: one => one.energy_error,
  },
  momentum: {
    name: "momentum error",
    axis: "largest |momentum error| / momentum scale [1]",
    time: "|momentum error| / momentum scale [1]",
    value: one => one.momentum_error,
  },
  "angular-momentum": {
    name: "angular momentum error",
    axis: "largest |angular momentum error| / its scale [1]",
    time: "|angular momentum error| / its scale [1]",
    value: one => one.angular_momentum_error,
  },
};

const COSTS = {
  cpu: {title: "Error against CPU time", axis: "CPU time [s]", value: one => one.cpu_seconds,
        spent: one => seconds(one.cpu_seconds), by: "CPU time"},
  force: {title: "Error against force evaluations", axis: "force evaluations [1]",
          value: one => one.force_evaluations, spent: one => count(one.force_evaluations),
          by: "force evaluations"},
  steps: {title: "Error against accepted steps", axis: "accepted steps [1]",
          value: one => one.steps, spent: one => count(one.steps), by: "accepted steps"},
};

/* What a scene's study asks: {error, metric, in}, or null. */
const askedOf = scene => (scene.asked_error > 0 && METRICS[scene.asked_in]
  ? {error: scene.asked_error, metric: METRICS[scene.asked_in], in: scene.asked_in} : null);

const isDrawn = (one, metric) => one.not_drawn[metric] === "";
const shownStatus = one =>
  (one.status !== "ok" ? one.status : one.invalid ? "refused" :
    one.refused ? "position refused" : "ok");
const byCost = (a, b) => a.cpu_seconds - b.cpu_seconds;
const byError = metric => (a, b) => METRICS[metric].value(a) - METRICS[metric].value(b);

/* --- title and answer --- */

const countText = (number, word) => `${number} ${word}${number === 1 ? "" : "s"}`;

const writeQuestion = () => {
  const {studies} = results, alone = studies.length === 1;
  const questions = studies.map(({question}) => question).filter(Boolean);
  const [asked] = scenes.map(scene => scene.asked);
  const facts = [alone ? studies[0].study && "study " + studies[0].study
                       : `${studies.length} studies`, results.kind,
                 scenes.length > 1 && countText(scenes.length, "scene"),
                 countText(results.cases.length + results.findings.length, "case"),
                 alone && asked && `asked: ${asked.metric.name} at most ${scientific(asked.error)}`];
  page.append(...(questions.length > 1
    ? [element("ul", {className: "question"}, questions.map(text => element("li", {}, text)))]
    : questions.map(text => element("p", {className: "question"}, text))),
    element("p", {className: "quiet"}, facts.filter(Boolean).join(" · ")));
};

const caseName = one => [strong(one.line.name), one.label ? ` (${one.label})` : ""];

/* An error too small for the reference to tell is at most its sum with the reference's own. */
const boundOf = (scene, one) => {
  const {asked} = scene;
  const value = asked.metric.value(one);
  if (one.status !== "ok" || one.invalid || value === null) return Infinity;
  if (asked.in === "energy" || !one.refused) return value;
  const {reference} = scene;
  const past = reference && reference.horizon !== null && reference.horizon <= one.t_end_reached;
  return reference && !past ? value + reference.error : Infinity;
};

const errorReached = (scene, one) => {
  const {asked} = scene;
  return isDrawn(one, asked.in)
    ? `${asked.metric.name} ${scientific(asked.metric.value(one))}`
    : `${asked.metric.name} at most ${scientific(boundOf(scene, one))}, less than the reference `
      + "can tell";
};

const reachedSentence = (scene, best) => {
  const next = scene.cases
    .filter(one => one.line !== best.line && boundOf(scene, one) <= scene.asked.error).sort(byCost)[0];
  const sentence = [
    "Cheapest: ", caseName(best), `: ${errorReached(scene, best)}, `,
    `${seconds(best.cpu_seconds)} of CPU time, `,
    `${count(best.force_evaluations)} force evaluations.`];
  if (next)
    sentence.push(" Next: ", caseName(next), ` with ${seconds(next.cpu_seconds)}, `,
                  timesAsMuch(next.cpu_seconds / best.cpu_seconds) + ".");
  else
    sentence.push(" No other method reached it.");
  return sentence.flat();
};

const missedSentence = scene => {
  const {asked} = scene;
  const closest = scene.cases.filter(one => isDrawn(one, asked.in)).sort(byError(asked.in))[0];
  if (!closest)
    return [`Nothing reached ${scientific(asked.error)}: none of the ${scene.cases.length} cases `
            + `gave a ${asked.metric.name} that can be shown.`];
  return [`Nothing reached ${scientific(asked.error)}; the closest was `, caseName(closest),
          ` with ${scientific(asked.metric.value(closest))}.`].flat();
};

const sentence = text =>
  text.charAt(0).toUpperCase() + text.slice(1) + (/[.?!]$/.test(text) ? "" : ".");

/* Of one scene: the cheapest case, or what the program says of findings. */
const answerOf = scene => {
  if (scene.findings.length || !scene.asked) return [sentence(scene.answer)];
  const best = scene.cheapest === null ? null : results.cases[scene.cheapest];
  return best ? reachedSentence(scene, best) : missedSentence(scene);
};

/* In two sentences: of the only scene, or of all of them; each scene's own then begins its part. */
const writeAnswer = () => {
  if (!scenes.length || !results.cases.length && !results.findings.length) return;
  const [scene] = scenes, alone = scenes.length === 1;
  const words = alone && scene.asked && !scene.findings.length
    ? `The answer: ${scene.asked.metric.name} ≤\u00a0${scientific(scene.asked.error)}` : "The answer";
  page.append(element("section", {id: "answer", className: "answer"}, element("h2", {}, words),
                      element("p", {}, ...(alone ? answerOf(scene) : [sentence(results.answer)]))));
};

/* --- error against cost --- */

const pointTooltip = metric => point => [
  point.one.label || "default options",
  `${METRICS[metric].name}: ${scientific(METRICS[metric].value(point.one), 3)}`,
  `CPU time: ${seconds(point.one.cpu_seconds)}`,
  `force evaluations: ${count(point.one.force_evaluations)}`,
  `steps: ${count(point.one.steps)}`,
  `status: ${shownStatus(point.one)}`,
];

const costLines = (scene, metric, cost) =>
  scene.lines.map(line => ({
    name: line.name,
    look: lookOf(line.index),
    points: scene.cases
      .filter(one => one.line === line && isDrawn(one, metric) && COSTS[cost].value(one) > 0)
      .sort((a, b) => a.force_evaluations - b.force_evaluations)
      .map(one => ({x: COSTS[cost].value(one), y: METRICS[metric].value(one), one})),
  })).filter(line => line.points.length);

/* Corners of the Pareto front: those of its cases that are drawn, from the cheapest on. */
const frontOf = (scene, metric, cost) =>
  scene.tradeoff[metric].front[cost].map(index => results.cases[index])
    .filter(one => isDrawn(one, metric) && COSTS[cost].value(one) > 0)
    .map(one => ({x: COSTS[cost].value(one), y: METRICS[metric].value(one)}));

const floorOf = (scene, metric) =>
  metric === "position" && scene.reference && scene.reference.error > 0
    ? scene.reference.margin * scene.reference.error : null;

const costPlan = (scene, metric, cost, hidden) => {
  const lines = costLines(scene, metric, cost);
  const points = lines.flatMap(line => line.points);
  if (!points.length) return null;
  const marked = marksOf(scene, metric);
  const heights = points.map(point => point.y).concat(marked.asked || []);
  /* A reference far better than every point would squeeze the points into the top. */
  if (marked.floor > Math.min(...heights) / 1e4) heights.push(marked.floor / 4);
  marked.front = frontOf(scene, metric, cost);
  return {
    lines, hidden, radius: 4.5,
    x: logX(COSTS[cost].axis, points.map(point => point.x)),
    y: logY(METRICS[metric].axis, heights),
    marks: marked,
    tooltip: pointTooltip(metric),
    label: `${COSTS[cost].title}, scene ${scene.name}, ${METRICS[metric].name}; `
           + "the table of cases holds the same figures",
  };
};

/* A frame, titled or not, for one chart; draw(plan) fills it anew and returns the chart or null.
 * `saved`: how the names of its files begin. */
const makeFrame = (name, title, empty, saved) => {
  const holder = element("div", {className: "canvas"});
  let chart = null;
  const draw = plan => {
    if (chart) chart.destroy();
    const canvas = element("canvas", {});
    Object.assign(canvas.dataset, {chart: name, points: 0});
    canvas.setAttribute("role", "img");
    holder.replaceChildren(canvas);
    holder.classList.toggle("nothing", !plan);
    chart = plan ? makeChart(canvas, plan) : null;
    if (!plan) holder.append(element("p", {className: "empty"}, empty));
    return chart;
  };
  const figure = element("figure", {}, title ? element("figcaption", {}, title) : null, holder,
                         chartSaver(saved, () => chart));
  return {figure, draw};
};

const notDrawnList = (scene, metric) => {
  const missing = scene.cases.filter(one => !isDrawn(one, metric));
  if (!missing.length) return [];
  const rows = missing.map(one => element("tr", {},
    element("td", {}, one.line.name), element("td", {}, one.label),
    element("td", {}, statusMark(one)), element("td", {}, one.not_drawn[metric])));
  return [element("h4", {}, `Not drawn: ${missing.length} of ${scene.cases.length}`),
          element("div", {className: "scroll tall"},
                  element("table", {className: "plain missing"}, element("tbody", {}, rows)))];
};

/* Positions and energy always: that there is no error of these is worth telling. */
const offered = scene => Object.keys(METRICS).filter(metric =>
  metric === "position" || metric === "energy"
  || scene.cases.some(one => isDrawn(one, metric)));

const metricChoice = (scene, start, change) => {
  const choice = element("fieldset", {className: "choice"}, element("legend", {}, "Error shown"));
  for (const metric of offered(scene)) {
    const input = element("input", {type: "radio", name: "metric-" + scene.id, value: metric,
                                    checked: metric === start});
    input.addEventListener("change", () => change(metric));
    choice.append(element("label", {}, input, METRICS[metric].name));
  }
  return choice;
};

const firstMetric = scene => {
  const wanted = scene.asked ? scene.asked.in : "position";
  const has = metric => scene.cases.some(one => isDrawn(one, metric));
  return has(wanted) ? wanted : Object.keys(METRICS).find(has) || wanted;
};

const floorNote = (scene, metric) => {
  if (metric !== "position" || !scene.reference) return "";
  if (scene.reference.error === 0) return "The errors are against an exact solution.";
  return scene.reference.error > 0 ? "" : "The reference's own error was not measured.";
};

/* --- the cheapest for every accuracy --- */

const ACCURACY_COSTS = ["cpu", "force"];

const cheapestCells = (row, cost) => {
  const one = row[cost] === null ? null : results.cases[row[cost]];
  return one ? [element("td", {}, one.line.name, one.label ? ` (${one.label})` : ""),
                element("td", {className: "number"}, COSTS[cost].spent(one))]
             : [element("td", {}, "–"), element("td", {})];
};

/* Neighbouring decades with the same cases share a row. */
const sharedDecades = accuracies => {
  const shared = [];
  for (const row of accuracies) {
    const last = shared[shared.length - 1];
    if (last && ACCURACY_COSTS.every(cost => last[cost] === row[cost])) last.error = row.error;
    else shared.push({...row, from: row.error});
  }
  return shared;
};

const decadesText = ({from, error}) =>
  (from === error ? "" : scientific(from) + " to ") + scientific(error);

const accuracyRows = (scene, metric) => sharedDecades(scene.tradeoff[metric].accuracies).map(row =>
  element("tr", {}, element("td", {className: "number"}, decadesText(row)),
          ...ACCURACY_COSTS.flatMap(cost => cheapestCells(row, cost))));

const accuracyTable = (scene, metric) => {
  const rows = accuracyRows(scene, metric);
  if (!rows.length) return [];
  const head = element("thead", {}, element("tr", {},
    element("th", {scope: "col", className: "number"}, "error at most"),
    ...ACCURACY_COSTS.flatMap(cost => [
      element("th", {scope: "col"}, "cheapest by " + COSTS[cost].by),
      element("th", {scope: "col", className: "number"}, COSTS[cost].by)])));
  const cells = (row, cost) => {
    const one = row[cost] === null ? null : results.cases[row[cost]];
    return one ? [one.method, one.options, COSTS[cost].value(one)] : ["", "", ""];
  };
  return [
    element("h4", {}, `The cheapest for each ${METRICS[metric].name}`),
    element("div", {className: "scroll"}, element("table", {className: "plain accuracies"}, head,
                                                  element("tbody", {}, rows))),
    tableSaver(`${scene.name} cheapest ${metric}`, () => [
      ["error at most", ...ACCURACY_COSTS.flatMap(cost =>
        ["method by " + COSTS[cost].by, "options", COSTS[cost].axis])],
      ...scene.tradeoff[metric].accuracies.map(row =>
        [row.error, ...ACCURACY_COSTS.flatMap(cost => cells(row, cost))])])];
};

/* What a cost chart is marked with. */
const marksOf = (scene, metric) => ({
  asked: scene.asked && scene.asked.in === metric ? scene.asked.error : null,
  floor: floorOf(scene, metric),
  front: frontOf(scene, metric, "force"),
});

const writeCostCharts = (scene, section) => {
  const charts = [], hidden = new Set();
  const empty = "No case has an error that can be drawn here.";
  const frames = Object.entries(COSTS).map(
    ([cost, {title}]) => [cost, makeFrame(cost, title, empty, `${scene.name} ${title}`)]);
  const note = element("p", {className: "quiet"});
  const cheapest = element("div", {});
  const missing = element("div", {className: "not-drawn"});
  const legend = element("div", {});
  const draw = metric => {
    charts.length = 0;
    for (const [cost, frame] of frames) {
      const chart = frame.draw(costPlan(scene, metric, cost, hidden));
      if (chart) charts.push(chart);
    }
    legend.replaceChildren(makeLegend(costLines(scene, metric, "force"), hidden, charts,
                                      charts.length ? marksOf(scene, metric) : {}));
    note.textContent = floorNote(scene, metric);
    cheapest.replaceChildren(...accuracyTable(scene, metric));
    missing.replaceChildren(...notDrawnList(scene, metric));
  };
  const start = firstMetric(scene);
  section.append(metricChoice(scene, start, draw),
                 element("div", {className: "charts"}, frames.map(([, frame]) => frame.figure)),
                 legend, note, cheapest, missing);
  return () => draw(start);
};

/* --- error over time --- */

/* A case has no series of what its scene does not conserve. */
const samplesOf = (one, metric) => one.samples[metric] || [];
const hasSamples = (one, metric) => samplesOf(one, metric).some(value => value > 0 || value < 0);

/* Positions and energy always; momenta where a case has an error of them, be it 0. */
const timedMetrics = scene => Object.keys(METRICS).filter(metric => METRICS[metric].time
  && (metric === "position" || metric === "energy"
      || scene.cases.some(one => samplesOf(one, metric).some(value => value !== null))));

/* The cheapest case that reaches the asked error, else the most accurate one. */
const chosenCase = (scene, members, metric) => {
  const {asked} = scene;
  const key = asked ? asked.in : metric;
  const reached = asked ? members.filter(one => boundOf(scene, one) <= asked.error) : [];
  const drawn = members.filter(one => isDrawn(one, key));
  return reached.sort(byCost)[0] || drawn.sort(byError(key))[0] || null;
};

const timeLine = (one, metric, name, look) => ({
  name, look,
  points: samplesOf(one, metric)
    .map((value, i) => ({x: one.samples.time[i], y: Math.abs(value), one}))
    .filter(point => point.y > 0),
});

const REFERENCE_LOOK = {colour: "#777777", dash: [1, 3], shape: "circle", fill: "#ffffff"};

const referenceLine = (scene, metric) => {
  const reference = scene.reference;
  if (metric !== "position" || !reference) return [];
  const points = reference.time.map((x, i) => ({x, y: reference.sample_error[i]}))
    .filter(point => point.y > 0);
  return points.length ? [{name: "reference's own error", look: REFERENCE_LOOK, points}] : [];
};

const timeTooltip = metric => point => [
  point.one ? point.one.label : "",
  `time: ${Number(point.x.toPrecision(6))}`,
  `${METRICS[metric].name}: ${scientific(point.y, 3)}`,
  point.one ? `status: ${shownStatus(point.one)}` : "",
].filter(Boolean);

const timeMarksOf = (scene, metric) =>
  metric === "position" && scene.reference ? {horizon: scene.reference.horizon} : {};

const timePlan = (scene, metric, lines, hidden) => {
  const drawn = lines.filter(line => line.points.length);
  const heights = drawn.flatMap(line => line.points.map(point => point.y));
  if (!heights.length) return null;
  return {
    lines: drawn, hidden, radius: 2,
    x: linearX("time [time]"), y: logY(METRICS[metric].time, heights),
    marks: timeMarksOf(scene, metric),
    tooltip: timeTooltip(metric),
    label: `${METRICS[metric].name} over time, scene ${scene.name}`,
  };
};

/* For each line the case that is shown, as a list to choose from. */
const casePickers = (scene, picked, change) => {
  const grid = element("div", {className: "pickers"});
  for (const line of scene.lines) {
    const members = scene.cases.filter(one => one.line === line);
    const choices = [["", "none"]].concat(members.map(one => [
      one.key, one.label + (shownStatus(one) === "ok" ? "" : ` (${shownStatus(one)})`)]));
    const chosen = picked.get(line);
    const list = element("select", {}, optionList(choices, chosen ? chosen.key : ""));
    list.addEventListener("change", () => {
      picked.set(line, members.find(one => one.key === list.value) || null);
      change();
    });
    grid.append(element("label", {}, element("span", {}, line.name), list));
  }
  return grid;
};

const timeLines = (scene, metric, mode, picked) => {
  if (mode === "one")
    return scene.lines.filter(line => picked.get(line)).map(line =>
      timeLine(picked.get(line), metric, line.name, lookOf(line.index)));
  return scene.cases.filter(one => one.line.name === mode)
    .map((one, i) => timeLine(one, metric, one.label, lookOf(i)));
};

const strideNote = scene => {
  const stride = Math.max(...scene.cases.map(one => one.samples.stride));
  return stride > 1 ? ` Of up to ${stride} neighbouring samples the one with the largest energy`
                      + " error is drawn." : "";
};

const timeNote = scene =>
  (scene.asked ? "One case a method: the cheapest that reaches the asked error, or else the most"
           + " accurate. " : "One case a method: the most accurate. ")
  + "Samples whose error is exactly 0 have no place on a logarithmic axis." + strideNote(scene);

const writeTimeChart = (scene, section) => {
  if (!scene.cases.some(one => hasSamples(one, "energy") || hasSamples(one, "position"))) {
    section.append(element("p", {className: "quiet"}, "No case has samples over time."));
    return () => {};
  }
  const state = {metric: "energy", mode: "one", picked: new Map(), hidden: new Set()};
  for (const line of scene.lines)
    state.picked.set(line, chosenCase(scene, scene.cases.filter(one => one.line === line),
                                          "energy"));
  const frame = makeFrame("time", "", "None of the chosen cases has samples here.",
                          `${scene.name} error over time`);
  const legend = element("div", {});
  const draw = () => {
    const lines = timeLines(scene, state.metric, state.mode, state.picked)
      .concat(referenceLine(scene, state.metric));
    const chart = frame.draw(timePlan(scene, state.metric, lines, state.hidden));
    legend.replaceChildren(makeLegend(lines.filter(line => line.points.length), state.hidden,
                                      chart ? [chart] : [],
                                      chart ? timeMarksOf(scene, state.metric) : {}));
  };
  const set = key => event => {
    state[key] = event.target.value;
    state.hidden.clear();
    draw();
  };
  section.append(timeControls(scene, set), frame.figure, legend,
                 element("p", {className: "quiet"}, timeNote(scene)),
                 folded("Choose the case of each method", casePickers(scene, state.picked, draw)));
  return draw;
};

const timeControls = (scene, set) => {
  const metric = element("select", {}, optionList(
    timedMetrics(scene).map(key => [key, METRICS[key].name]), "energy"));
  metric.addEventListener("change", set("metric"));
  const modes = [["one", "one case a method"]].concat(
    scene.lines.map(line => [line.name, "every case of " + line.name]));
  const mode = element("select", {}, optionList(modes, "one"));
  mode.addEventListener("change", set("mode"));
  return element("div", {className: "controls"},
                 element("label", {}, element("span", {}, "Error"), metric),
                 element("label", {}, element("span", {}, "Lines"), mode));
};

/* --- table of cases --- */

const statusMark = one => {
  const status = shownStatus(one);
  const kind = one.status !== "ok" ? "failed" : one.invalid || one.refused ? "refused" : "ok";
  return element("span", {className: "status " + kind}, status);
};

const real = (title, key, unit) => ({title, key, unit, text: shortReal});
const number = (title, key) => ({title, key, unit: "", text: count});

/* What is asked and what it costs first: a narrow window shows these. */
const COLUMNS = [
  {title: "method", value: one => one.line.name, always: true},
  {title: "options", value: one => one.label, always: true, full: one => one.options,
   sort: one => Number((/=\s*(\S+)/.exec(one.label.replace(/,.*/, "")) || [])[1]) || 0},
  {title: "status", value: shownStatus, always: true, mark: statusMark,
   full: one => one.invalid || one.refused || one.message},
  real("position error, RMS", "position_error", "length"),
  real("energy error, largest", "energy_error", "of scale"),
  {title: "CPU time", key: "cpu_seconds", unit: "s", text: shortSeconds, always: true},
  number("force evaluations", "force_evaluations"),
  number("steps", "steps"),
  real("force error, stated", "force_error_stated", "of moduli"),
  real("force error, measured", "force_error", "of moduli"),
  real("position error, worst particle", "position_error_max", "length"),
  real("position error, largest over time", "position_error_ever", "length"),
  real("energy error, end", "energy_error_final", "of scale"),
  real("momentum error", "momentum_error", "of scale"),
  real("angular momentum error", "angular_momentum_error", "of scale"),
  {title: "CPU time, median", key: "cpu_median", unit: "s", text: shortSeconds},
  number("rejected steps", "rejected_steps"),
  number("Jacobians", "jacobian_evaluations"),
  number("Jacobian–vector products", "jacobian_vector_products"),
  number("nonlinear iterations", "nonlinear_iterations"),
  number("linear iterations", "linear_iterations"),
  number("factorisations", "factorisations"),
  number("neighbour lists built", "neighbour_list_builds"),
  number("wall hits", "wall_hits"),
  number("crossings located", "crossings"),
  {title: "time reached", key: "t_end_reached", unit: "time",
   text: value => (value === null ? "–" : String(Number(value.toPrecision(4))))},
];

/* A column that is empty or zero for every case is left out. */
const columnsOf = cases =>
  COLUMNS.filter(column => column.always || cases.some(one => one[column.key]));

const cellOf = (one, column) => {
  if (!column.key) {
    const cell = element("td", {}, column.mark ? column.mark(one) : column.value(one));
    if (column.full) cell.title = column.full(one);
    return cell;
  }
  const value = one[column.key];
  const cell = element("td", {className: "number"}, column.text(value));
  if (value !== null) cell.title = String(value);
  return cell;
};

const sortKey = (one, column) => (column.sort || column.value || (() => one[column.key]))(one);

/* Missing values last, whatever the direction. */
const compare = (column, sign) => (a, b) => {
  const left = sortKey(a, column), right = sortKey(b, column);
  if (left === null || right === null) return (left === null) - (right === null);
  return sign * (typeof left === "string" ? left.localeCompare(right) : left - right);
};

const caseRow = (one, columns) => {
  const row = element("tr", {}, columns.map(column => cellOf(one, column)));
  row.dataset.key = one.key;
  return row;
};

const headCell = (column, sort) => {
  const cell = element("th", {scope: "col", className: column.key ? "number" : ""});
  const button = element("button", {type: "button"}, column.title,
                         column.unit ? element("span", {className: "unit"}, `[${column.unit}]`)
                                     : null);
  button.addEventListener("click", () => {
    const up = cell.getAttribute("aria-sort") !== "ascending";
    for (const other of cell.parentNode.children) other.removeAttribute("aria-sort");
    cell.setAttribute("aria-sort", up ? "ascending" : "descending");
    sort(column, up ? 1 : -1);
  });
  cell.append(button);
  return cell;
};

const writeTable = (scene, section) => {
  const columns = columnsOf(scene.cases);
  const body = element("tbody", {}, scene.cases.map(one => caseRow(one, columns)));
  const sort = (column, sign) => {
    const sorted = [...scene.cases].sort(compare(column, sign));
    body.replaceChildren(...sorted.map(one => caseRow(one, columns)));
  };
  const head = element("thead", {}, element("tr", {}, columns.map(column =>
    headCell(column, sort))));
  section.append(longTable(
    `Every case (${scene.cases.length})`, scene.cases.length,
    element("div", {className: "scroll"}, element("table", {className: "cases"}, head, body)),
    tableSaver(`${scene.name} cases`, () => [
      columns.map(column => column.title + (column.unit ? ` [${column.unit}]` : "")),
      ...scene.cases.map(one => columns.map(column =>
        (column.key ? one[column.key] : (column.full || column.value)(one))))]),
    element("p", {className: "quiet"}, repeatsNote(scene), " Errors and momenta “of scale” are "
      + "divided by the scene's energy or momentum scale. Click a heading to sort; a figure's full "
      + "digits and a case's options show where the pointer rests.")));
};

const repeatsNote = scene => {
  const repeats = Math.max(...scene.cases.map(one => one.repeats));
  return repeats > 1 ? `CPU time is the smallest of up to ${repeats} repeats.`
                     : "CPU time is of one run.";
};

/* --- reference, scene, provenance --- */

const chaosOf = reference => {
  const digits = value => Number(value.toPrecision(3));
  const end = reference.time[reference.time.length - 1];
  return `Largest Lyapunov exponent: ${digits(reference.lyapunov)} ± `
    + `${Number(reference.lyapunov_error.toPrecision(1))} over the second half; a small displacement `
    + `grew by 10^${(reference.growth / Math.LN10).toFixed(1)} until t = ${digits(end)}`
    + (reference.grows ? ". "
       : "; in the second half no faster than t², as regular motion's can: no sign of chaos. ")
    + (reference.horizon === null ? "Horizon: not before the end."
       : `Horizon: t = ${Number(reference.horizon.toPrecision(4))}, when rounding errors of double `
         + "precision have grown to 1 % of the distance between neighbours; position errors after "
         + "it are not shown.");
};

const writeReference = (scene, section) => {
  const {reference} = scene;
  section.append(element("h3", {}, "Reference"));
  if (!reference) {
    section.append(element("p", {}, "There is no reference for this scene: position errors are "
                                    + "not known."));
    return;
  }
  const own = reference.error === 0 ? "It is exact."
    : reference.error === null ? "Its own error was not measured."
    : `Its own error: ${scientific(reference.error, 3)} (RMS position difference at the end).`;
  const told = reference.description.replace(/[.;\s]*$/, "");
  section.append(element("p", {}, told ? told + ". " : "", own,
                         reference.note ? ` No better: ${reference.note}.` : ""));
  if (reference.lyapunov !== null) section.append(element("p", {}, chaosOf(reference)));
};

const writeSceneText = (scene, section) => {
  section.append(element("h3", {}, "Scene"));
  if (scene.source) section.append(element("p", {}, "Source: " + scene.source));
  if (scene.explain) section.append(pre(scene.explain));
  if (scene.text) section.append(folded("The scene file", pre(scene.text)));
};

const factRow = (name, value) =>
  element("tr", {}, element("th", {scope: "row"}, name), element("td", {}, value));

/* A fact that is the same of all studies stands once. */
const writeProvenance = () => {
  const section = element("section", {}, element("h2", {}, "What made this"));
  const {studies} = results, valueIn = (study, name) =>
    (study.facts.find(fact => fact.name === name) || {value: "–"}).value;
  const names = [...new Set(studies.flatMap(({facts}) => facts.map(({name}) => name)))];
  const rows = names.flatMap(name => {
    const values = studies.map(study => valueIn(study, name));
    return new Set(values).size === 1 ? [factRow(name, values[0])]
      : values.map((value, i) => factRow(`${name}, ${studies[i].study}`, value));
  });
  section.append(element("table", {className: "plain facts"}, element("tbody", {}, rows)));
  page.append(section);
};

const writeCommands = () => {
  const section = element("section", {}, element("h2", {}, "Repeat it"));
  const commands = results.studies.flatMap(({facts}) =>
    facts.filter(({name}) => name === "command").map(({value}) => value));
  if (commands.length)
    section.append(element("p", {}, commands.length > 1 ? "The studies:" : "The study:"),
                   pre(commands.join("\n")));
  for (const scene of scenes) {
    const lines = [...scene.cases, ...scene.findings].map(one => one.command).filter(Boolean);
    const where = scenes.length > 1 ? ` on ${scene.name}` : "";
    if (lines.length)
      section.append(folded(`Each case${where}: ${lines.length} commands`, pre(lines.join("\n"))));
  }
  page.append(section);
};

const writeScene = scene => {
  const section = element("section", {id: scene.id, className: "scene"},
                          element("h2", {}, "Scene " + scene.name));
  page.append(section);
  if (scenes.length > 1 && (scene.findings.length ? scene.answer : scene.cases.length))
    section.append(element("p", {className: "of-scene"}, ...answerOf(scene)));
  if (scene.findings.length) {
    writeFindings.ofScene(scene, section);
  } else if (!scene.cases.length) {
    section.append(element("p", {}, "No case has run on this scene."));
  } else {
    section.append(element("h3", {}, "Error against cost"));
    const drawCosts = writeCostCharts(scene, section);
    section.append(element("h3", {}, "Error over time"));
    const drawTime = writeTimeChart(scene, section);
    drawCosts(); /* charts take their size from a page that is laid out */
    drawTime();
    writeTable(scene, section);
  }
  if (!scene.findings.length) writeReference(scene, section);
  writeSceneText(scene, section);
};

const lines = new Map();
const scenes = results.scenes.map((scene, index) => {
  const cases = results.cases.filter(one => one.scene === scene.name);
  const findings = results.findings.filter(one => one.scene === scene.name);
  findLines(cases, lines);
  findLines(findings, lines);
  const present = new Set([...cases, ...findings].map(one => one.line));
  return {...scene, asked: askedOf(scene), id: "scene-" + (index + 1), cases, findings,
          lines: [...lines.values()].filter(line => present.has(line))};
});

writeQuestion();
writeAnswer();
if (results.findings.length) writeFindings.overview(results.findings);
if (results.across) writeAcross(scenes);
scenes.forEach(writeScene);
writePlayers(page);
writeProvenance();
writeCommands();
document.body.dataset.ready = "true";
