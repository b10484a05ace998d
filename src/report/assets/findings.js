/* What studies of other kinds than work-precision found: a verdict a method, its quantities, and
 * charts by what the tables hold, whatever the kind: runs by step, errors or observables by time. */

const writeFindings = (() => {
  const titleOf = ({name, unit}) => name + (unit ? ` [${unit}]` : "");
  const isLet = quantity => quantity.name.startsWith("$");
  const measured = one => one.status === "ok";
  const verdictOf = one => (measured(one) ? one.verdict : one.status);
  const quantityOf = (one, name) => one.quantities.find(quantity => quantity.name === name);
  const nameOf = one => one.line.name + (one.label ? ` (${one.label})` : "");
  const unique = values => [...new Set(values)];
  const column = (one, name) => one.columns.findIndex(each => each.name === name);

  const shown = value => (value === null || value === undefined ? "–"
    : Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5 || value === 0
      ? String(Number(value.toPrecision(5))) : shortReal(value));

  const interval = ({value, low, high}) =>
    shown(value) + (low === null || high === null || (low === value && high === value) ? ""
      : ` (${shown(low)} to ${shown(high)})`);

  const methodOf = one => [one.method, one.options].filter(Boolean).join(" ");

  /* The name alone where a scene has no other finding of that line: what it left unsaid is then the
   * scene's own, a step say. */
  const shortNames = findings => {
    const alone = one => findings.every(each =>
      each === one || each.line !== one.line || each.scene !== one.scene);
    return one => (alone(one) ? one.line.name : nameOf(one));
  };

  const said = one => one.reason || one.message;
  const wholeCase = one => [methodOf(one), "verdict: " + verdictOf(one), said(one)].filter(Boolean);

  /* --- the table of verdicts --- */

  /* Neither good nor bad: a limit, and what is open. All other words tell how a run failed. */
  const GOOD = /^(pass|stable|holds$|settled|measured)/;
  const OPEN = /^(limit|no limit|not |holds in part|several)/;

  const failed = one => !measured(one) || !(GOOD.test(one.verdict) || OPEN.test(one.verdict));

  const verdictMark = one => {
    const kind = failed(one) ? "failed" : GOOD.test(one.verdict) ? "ok" : "refused";
    return element("span", {className: "status " + kind}, verdictOf(one));
  };

  const writeFailures = (scene, section) => {
    const missing = scene.findings.filter(failed);
    if (!missing.length) return;
    section.append(longTable(
      `Failures: ${missing.length} of ${scene.findings.length}`, missing.length,
      element("div", {className: "scroll tall"}, element("table", {className: "plain missing"},
        element("tbody", {}, missing.map(one => element("tr", {},
          element("td", {}, one.line.name), element("td", {}, one.label),
          element("td", {}, verdictMark(one)), element("td", {}, said(one)))))))));
  };

  const verdictColumns = findings => {
    const quantities = [];
    for (const quantity of findings.flatMap(one => one.quantities))
      if (!quantities.some(known => known.name === quantity.name)) quantities.push(quantity);
    return quantities.filter(({name}) =>
      findings.some(one => (quantityOf(one, name) || {value: null}).value !== null));
  };

  const writeVerdicts = (scene, section) => {
    const quantities = verdictColumns(scene.findings);
    const cells = one => quantities.map(({name}) => {
      const quantity = quantityOf(one, name);
      const known = quantity && quantity.value !== null;
      const cell = element("td", {className: "number" + (known ? "" : " none"),
                                  title: known ? String(quantity.value) : ""},
                           known ? interval(quantity) : "–");
      cell.dataset.head = name; /* where the headings have no room */
      return cell;
    });
    const rows = scene.findings.map(one => {
      const row = element("tr", {}, element("td", {}, one.line.name), element("td", {}, one.label),
                          element("td", {}, verdictMark(one)),
                          element("td", {className: "reason"}, said(one)),
                          ...cells(one));
      row.dataset.key = one.key;
      return row;
    });
    const heads = ["method", "options", "verdict", "in words"].map(text =>
      element("th", {scope: "col"}, text)).concat(quantities.map(({name, unit}) =>
      element("th", {scope: "col", className: "number"}, name,
              unit ? element("span", {className: "unit"}, ` [${unit}]`) : null)));
    section.append(longTable(
      `Every method (${scene.findings.length})`, scene.findings.length,
      element("div", {className: "scroll"}, element("table", {className: "cases findings"},
        element("thead", {}, element("tr", {}, heads)), element("tbody", {}, rows))),
      tableSaver(`${scene.name} findings`, () => [
        ["method", "options", "verdict", "in words",
         ...quantities.flatMap(each => [titleOf(each), each.name + " low", each.name + " high"])],
        ...scene.findings.map(one => [
          one.method, one.options, verdictOf(one), said(one),
          ...quantities.flatMap(({name}) => {
            const {value, low, high} = quantityOf(one, name) || {};
            return [value, low, high];
          })])])));
  };

  /* --- runs by step: a strip a method, a mark a run, its look the run's end --- */

  /* "blow-up: the energy error at t = 3 is ..." ends in "blow-up". */
  const endOf = word => word.replace(/:.*/s, "") || "run";

  /* "stable" and "held" are the good ends and come first, so that they look the same everywhere. */
  const wordLooks = words => {
    const good = words.filter(word => /^(stable|held|holds)/.test(word));
    const ordered = good.concat(words.filter(word => !good.includes(word)).sort());
    const looks = new Map();
    ordered.forEach((word, i) =>
      looks.set(word, {...lookOf(good.length ? i : i + 1), dash: []}));
    return looks;
  };

  const scanned = row => row.values[0] > 0; /* a method that chooses its steps has none */
  const withSteps = findings =>
    findings.filter(one => column(one, "step") === 0 && one.rows.some(scanned));

  /* Lines of at most `most` letters, broken at spaces and hyphens. */
  const wrapped = (text, most) => {
    const lines = [""];
    for (const part of text.split(/(?<=[-\s])/)) {
      if (lines[lines.length - 1].length + part.trim().length > most) lines.push("");
      lines[lines.length - 1] += part;
    }
    return lines.map(line => line.trim()).filter(Boolean);
  };

  const namesAxis = (title, names) => ({
    type: "linear", min: -0.6, max: names.length - 0.4, reverse: true,
    title: {display: Boolean(title), text: title, color: "#222"},
    grid: {color: "#e2e2e2", tickColor: "#888"},
    ticks: {autoSkip: false, color: "#222", callback: (value, i, ticks) => ticks[i].label},
    afterBuildTicks: axis => {
      const room = Math.max(12, axis.chart.width / 14); /* letters, in less than half of the width */
      axis.ticks = names.map((label, value) => ({value, label: wrapped(label, room)}));
    },
  });

  const runsOf = strips => strips.flatMap(({one}, y) => one.rows.filter(scanned).map(row =>
    ({x: row.values[0], y, end: endOf(row.word), row, one})));

  const runColumns = run => run.one.columns.map((each, i) => [titleOf(each), run.row.values[i]]);

  /* What lets expect where a method's steps end to be stable, beside where they do. */
  const EXPECTED = [
    {name: "predicted limit", look: {colour: "#000000", fill: "#ffffff", dash: [], shape: "cross"}},
    {name: "2/omega along the run",
     look: {colour: "#5a5a5a", fill: "#ffffff", dash: [], shape: "crossRot"}},
    {name: "r0/|v|", look: {colour: "#5a5a5a", fill: "#ffffff", dash: [], shape: "triangle"}},
  ];

  /* Those no farther from the steps that were run than would squeeze these together. */
  const expectedLines = (strips, steps) => {
    const low = Math.min(...steps) / 3, high = Math.max(...steps) * 3;
    return EXPECTED.map(({name, look}) => ({
      name, look, bare: true, above: true,
      points: strips.flatMap(({one}, y) => {
        const {value} = quantityOf(one, name) || {value: null};
        return value !== null && value > low && value < high
          ? [{x: value, y, end: name, one, row: {word: name, values: [value]}}] : [];
      }),
    })).filter(({points}) => points.length);
  };

  /* `strips`: [{name, one}]. */
  const stripPlan = (scene, strips, yTitle, hidden) => {
    const runs = runsOf(strips);
    if (!runs.length) return null;
    const expected = expectedLines(strips, runs.map(run => run.x));
    return {
      lines: [...wordLooks(unique(runs.map(run => run.end)))].map(([end, look]) => ({
        name: end, look, bare: true, points: runs.filter(run => run.end === end)}))
        .concat(expected),
      hidden, radius: 4.5, marks: {},
      x: logX(titleOf(strips[0].one.columns[0]),
              runs.concat(expected.flatMap(({points}) => points)).map(run => run.x)),
      y: namesAxis(yTitle, strips.map(({name}) => name)),
      tooltip: run => [methodOf(run.one),
                       ...runColumns(run).filter(([, value]) => value !== undefined)
                         .map(([title, value]) => `${title}: ${shown(value)}`),
                       ...(run.end === run.row.word ? [] : [run.row.word])],
      csv: {heads: ["end", "scene", "method", "options",
                    ...runColumns(runs[0]).map(([title]) => title), "in words"],
            row: run => [run.end, run.one.scene, run.one.method, run.one.options,
                         ...runColumns(run).map(([, value]) => value), run.row.word]},
      label: `Runs by their step, scene ${scene.name}; the table of methods tells the limits`,
    };
  };

  const chartOf = (section, name, saved, title, height, plan) => {
    const frame = makeFrame(name, title, "No run can be drawn here.", saved);
    const legend = element("div", {}), hidden = new Set();
    frame.figure.querySelector(".canvas").style.height = height;
    section.append(frame.figure, legend);
    return what => {
      const made = plan(hidden, what);
      const chart = frame.draw(made);
      legend.replaceChildren(made ? makeLegend(made.lines, hidden, chart ? [chart] : [], {}) : "");
    };
  };

  const heightOf = strips => `${Math.max(9, 5 + 1.75 * strips)}rem`;

  const unscannedNote = findings => {
    const rest = findings.filter(one => measured(one) && column(one, "step") === 0
                                        && !one.rows.some(scanned));
    return rest.length === 0 ? null : element("p", {className: "quiet"},
      "They choose their own steps and stand in the table alone: "
      + unique(rest.map(one => one.line.name)).join(", ") + ".");
  };

  const writeStrips = (scene, section) => {
    const named = shortNames(scene.findings);
    const strips = withSteps(scene.findings).map(one => ({name: named(one), one}));
    if (!strips.length) return () => {};
    section.append(element("h3", {}, "How runs end, by their step"));
    const draw = chartOf(section, "strips", `${scene.name} runs by step`, "",
                         heightOf(strips.length), hidden => stripPlan(scene, strips, "", hidden));
    section.append(unscannedNote(scene.findings) || "");
    return draw;
  };

  /* --- maps: the same over scenes that differ in a number of theirs --- */

  const letsOf = findings => unique(findings.flatMap(one =>
    one.quantities.filter(isLet).map(({name}) => name))).filter(name =>
    unique(findings.map(one => quantityOf(one, name)).filter(Boolean).map(({value}) => value))
      .length > 1);

  const writeMaps = (findings, section) => {
    const members = withSteps(findings), lets = letsOf(members);
    if (!lets.length) return;
    const lines = unique(members.map(one => one.line));
    const strips = (line, name) => members.filter(one => one.line === line && quantityOf(one, name))
      .sort((a, b) => quantityOf(a, name).value - quantityOf(b, name).value)
      .map(one => ({name: lets.map(each => (lets.length > 1 ? each + " = " : "")
        + shown(quantityOf(one, each).value)).join(", "), one}));
    const most = Math.max(...lines.map(line => strips(line, lets[0]).length));
    const lists = {};
    const choice = (words, key, choices, start) => {
      lists[key] = element("select", {}, optionList(choices.map(one => [one, one]), start));
      return element("label", {}, element("span", {}, words), lists[key]);
    };
    section.append(element("h3", {}, "Map over " + lets.join(" and ")),
                   element("div", {className: "controls"},
                           choice("Method", "line", lines.map(line => line.name), lines[0].name),
                           choice("Rows by", "name", lets, lets[0])));
    const draw = chartOf(
      section, "map", "map over " + lets.join(" "), "How runs end, by step and " + lets.join(", "),
      heightOf(most),
      hidden => stripPlan({name: "map"}, strips(
        lines.find(line => line.name === lists.line.value), lists.name.value),
        lists.name.value, hidden));
    for (const list of Object.values(lists)) list.addEventListener("change", () => draw());
    draw();
  };

  /* --- series over time --- */

  const withTimes = findings => findings.filter(one => column(one, "time") === 0 && one.rows.length);
  const isError = ({name}) => /error/.test(name);
  const shownAs = (value, errors) => (value === null || errors && value === 0 ? []
    : [errors ? Math.abs(value) : value]);

  /* The points of column k; an error of 0 has no place on a logarithmic axis. */
  const seriesPoints = (one, k) => one.rows.flatMap(({values}) =>
    shownAs(values[k], isError(one.columns[k])).map(y => ({x: values[0], y, one})));

  /* `lines`: [{name, one, k}]. */
  const seriesPlan = (scene, title, lines, hidden) => {
    const drawn = lines.map(({name, one, k}, i) =>
      ({name, look: lookOf(i), points: seriesPoints(one, k)})).filter(({points}) => points.length);
    if (!drawn.length) return null;
    const [{one, k}] = lines, unit = titleOf(one.columns[k]);
    return {
      lines: drawn, hidden, radius: drawn.some(({points}) => points.length > 150) ? 0 : 1.5,
      marks: {},
      x: linearX(titleOf(one.columns[0])),
      y: isError(one.columns[k]) ? logY(title, drawn.flatMap(each => each.points.map(({y}) => y)))
                                 : linearX(title),
      tooltip: point => [`time: ${shown(point.x)}`, `${title}: ${shown(point.y)}`,
                         methodOf(point.one), "verdict: " + verdictOf(point.one)],
      csv: {heads: ["line", "scene", "method", "options", titleOf(one.columns[0]), title],
            row: (point, line) => [line, point.one.scene, point.one.method, point.one.options,
                                   point.x, point.y]},
      label: `${unit} over time, scene ${scene.name}`,
    };
  };

  /* Errors of one method, a line a level; of observables one, a line a method. */
  const seriesChoices = (scene, members) => {
    const named = shortNames(members);
    if (members[0].columns.slice(1).every(isError))
      return {words: "Method", title: () => "|energy error| / energy scale [1]",
              choices: members.map(one => [one.key, `${nameOf(one)}: ${verdictOf(one)}`]),
              lines: key => {
                const one = members.find(each => each.key === key);
                return one.columns.slice(1).map(({name}, k) => ({name, one, k: k + 1}));
              }};
    return {words: "Quantity", title: name => name,
            choices: members[0].columns.slice(1).map(each => [titleOf(each), titleOf(each)]),
            lines: title => members.map(one =>
              ({name: named(one), one, k: one.columns.findIndex(each => titleOf(each) === title)}))
              .filter(({k}) => k > 0)};
  };

  /* A list beside its words, and a chart beneath that is drawn anew by what it says. */
  const chosenChart = (section, {heading, words, choices, start, name, saved, plan}) => {
    const list = element("select", {}, optionList(choices, start || choices[0][0]));
    section.append(element("h3", {}, heading), element("div", {className: "controls"},
      element("label", {}, element("span", {}, words), list)));
    const draw = chartOf(section, name, saved, "", "22rem", hidden => plan(list.value, hidden));
    list.addEventListener("change", () => draw());
    return draw;
  };

  const writeSeries = (scene, section) => {
    const members = withTimes(scene.findings);
    if (!members.length) return () => {};
    const {words, title, choices, lines} = seriesChoices(scene, members);
    return chosenChart(section, {
      heading: "Over time", words, choices, name: "series", saved: `${scene.name} over time`,
      plan: (chosen, hidden) => seriesPlan(scene, title(chosen), lines(chosen), hidden)});
  };

  /* --- a quantity by step, a line a method, whiskers for what is known of it --- */

  const stepOf = one => Number((one.option || new Map()).get("step")) || 0;
  const TOLD_FIRST = ["energy fluctuation"]; /* what a kind is about, where that is not its first */

  const trendLines = (scene, members, name) => scene.lines.map(line => ({
    name: line.name, look: lookOf(line.index),
    points: members.filter(one => one.line === line && quantityOf(one, name))
      .sort((a, b) => stepOf(a) - stepOf(b))
      .map(one => {
        const {value, low, high} = quantityOf(one, name);
        return {x: stepOf(one), y: value, low, high, one};
      }).filter(({y}) => y !== null)})).filter(({points}) => points.length);

  /* Logarithmic where the values are all above 0 and far apart. */
  const trendAxis = (title, points) => {
    const values = points.map(({y}) => y), low = Math.min(...values), high = Math.max(...values);
    if (low > 0 && high > 20 * low) return logY(title, values);
    const ends = points.flatMap(point => [point.low, point.high]).filter(Number.isFinite);
    return {...linearX(title), suggestedMin: Math.min(low, ...ends),
            suggestedMax: Math.max(high, ...ends)};
  };

  const trendPlan = (scene, members, quantity, hidden) => {
    const lines = trendLines(scene, members, quantity.name);
    const points = lines.flatMap(each => each.points);
    if (!points.length) return null;
    const title = titleOf(quantity);
    return {
      lines, hidden, radius: 4.5, marks: {},
      x: logX("step [time]", points.map(({x}) => x)), y: trendAxis(title, points),
      tooltip: point => [`step: ${shown(point.x)}`,
                         `${title}: ${interval({...point, value: point.y})}`,
                         ...wholeCase(point.one)],
      csv: {heads: ["line", "scene", "method", "options", "step [time]", title, "low", "high",
                    "verdict"],
            row: (point, line) => [line, point.one.scene, point.one.method, point.one.options,
                                   point.x, point.y, point.low, point.high, verdictOf(point.one)]},
      label: `${title} by step, scene ${scene.name}`,
    };
  };

  const writeTrend = (scene, section) => {
    const members = scene.findings.filter(one => measured(one) && stepOf(one) > 0);
    const names = verdictColumns(members).filter(quantity => !isLet(quantity));
    const steps = line => unique(members.filter(one => one.line === line).map(stepOf)).length;
    if (!names.length || !scene.lines.some(line => steps(line) > 1)) return () => {};
    return chosenChart(section, {
      heading: "By step", words: "Quantity", name: "trend", saved: `${scene.name} by step`,
      choices: names.map(each => [each.name, titleOf(each)]),
      start: TOLD_FIRST.find(each => names.some(({name}) => name === each)),
      plan: (chosen, hidden) =>
        trendPlan(scene, members, names.find(({name}) => name === chosen), hidden)});
  };

  /* --- a body of several sizes: quantities and costs by the number of particles --- */

  const sizePoints = (one, values) => one.particles.flatMap((x, i) =>
    (values[i] === null ? [] : [{x, y: values[i], i}]));

  /* Between the dashed lines a quantity agrees with that of the largest number. */
  const sizeBounds = (one, {values}) => {
    const limit = values[values.length - 1];
    return limit === null ? [] : [1 - one.tolerance, 1 + one.tolerance].map((factor, k) => ({
      name: (k ? "+" : "−") + shown(100 * one.tolerance) + " %",
      look: {colour: "#5a5a5a", fill: "#ffffff", dash: [4, 4], shape: "line"},
      points: one.particles.map((x, i) => ({x, y: limit * factor, i}))}));
  };

  const sizePlan = (one, chosen, hidden) => {
    const points = sizePoints(one, chosen.values);
    if (!points.length) return null;
    const cost = !chosen.deviations;
    const ys = points.map(({y}) => y);
    return {
      lines: [{name: one.method, look: lookOf(0), points}].concat(
        cost ? [] : sizeBounds(one, chosen)),
      hidden, radius: 4.5, marks: {},
      x: logX("particles", points.map(({x}) => x)),
      y: cost && Math.min(...ys) > 0 ? logY(chosen.name, ys) : linearX(chosen.name),
      tooltip: point => [`particles: ${shown(point.x)}`, `${chosen.name}: ${shown(point.y)}`,
                         ...(cost ? [] : ["difference from the largest: "
                            + shown(100 * chosen.deviations[point.i]) + " %"]),
                         `runs: ${one.repeats[point.i]}`, methodOf(one)],
      csv: {heads: ["line", "particles", "runs", chosen.name, "difference"],
            row: (point, line) => [line, point.x, one.repeats[point.i], point.y,
                                   cost ? null : chosen.deviations[point.i]]},
      label: `${chosen.name} by the number of particles; the table holds the same figures`,
    };
  };

  const sizeTable = one => {
    const number = text => element("td", {className: "number"}, text);
    const rows = one.quantities.map(({name, values, deviations, from}) => element("tr", {},
      element("td", {}, name),
      values.map((value, i) => number(value === null ? "–"
        : `${shown(value)} (${shown(Number((100 * deviations[i]).toPrecision(2)))} %)`)),
      number(from === null ? "–" : shown(from))));
    const power = ({exponent, low, high}) => (exponent === null ? "–"
      : `N^${exponent.toFixed(3)}`
        + (low === null ? "" : ` (${low.toFixed(3)} to ${high.toFixed(3)})`));
    const costs = one.costs.map(cost => element("tr", {}, element("td", {}, cost.name),
      cost.values.map(value => number(shown(value))), number(power(cost))));
    const heads = ["particles (runs)",
                   ...one.particles.map((n, i) => `${n} (${one.repeats[i]})`),
                   `within ${shown(100 * one.tolerance)} % from, or power`];
    return element("div", {className: "scroll"}, element("table", {className: "cases sizes"},
      element("thead", {}, element("tr", {}, heads.map((text, i) =>
        element("th", {scope: "col", className: i ? "number" : ""}, text)))),
      element("tbody", {}, rows, costs)));
  };

  const writeSizes = section => {
    for (const one of results.scalings) {
      const choices = one.quantities.concat(one.costs);
      const draw = chosenChart(section, {
        heading: `By the number of particles: ${one.body} with ${one.method}`, words: "Quantity",
        choices: choices.map(({name}) => [name, name]), name: "sizes",
        saved: `${one.body} by particles`,
        plan: (name, hidden) => sizePlan(one, choices.find(each => each.name === name), hidden)});
      section.append(sizeTable(one));
      draw();
    }
  };

  /* --- the page's share --- */

  /* Methods by scenes, where there are several of both. */
  const writeMatrix = (findings, section) => {
    const named = shortNames(findings);
    const sceneNames = unique(findings.map(one => one.scene)), names = unique(findings.map(named));
    if (sceneNames.length < 2) return;
    const cell = (name, scene) => {
      const one = findings.find(each => named(each) === name && each.scene === scene);
      return element("td", {title: one ? said(one) : ""}, one ? verdictMark(one) : "");
    };
    section.append(
      element("h3", {}, "Methods by scenes"),
      element("div", {className: "scroll"}, element("table", {className: "cases matrix"},
        element("thead", {}, element("tr", {}, element("th", {scope: "col"}, "method"),
                                     sceneNames.map(name => element("th", {scope: "col"}, name)))),
        element("tbody", {}, names.map(name => element("tr", {}, element("td", {}, name),
          sceneNames.map(scene => cell(name, scene))))))));
  };

  const overview = findings => {
    const section = element("section", {id: "overview"});
    page.append(section);
    writeSizes(section);
    writeMaps(findings, section);
    if (!results.scalings.length) writeMatrix(findings, section);
    if (section.childElementCount) section.prepend(element("h2", {}, "All scenes"));
    else section.remove();
  };

  const ofScene = (scene, section) => {
    const draws = [writeStrips, writeTrend, writeSeries].map(write => write(scene, section));
    writeFailures(scene, section);
    writeVerdicts(scene, section);
    for (const draw of draws) draw(); /* charts take their size from a page that is laid out */
  };

  return {overview, ofScene};
})();
