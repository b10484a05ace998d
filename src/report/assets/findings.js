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

  /* --- the table of verdicts --- */

  const verdictMark = one => {
    const word = verdictOf(one);
    const good = /^(pass|stable|holds$|settled)/.test(word), bad = /^(fail|unstable|never)/.test(word);
    const kind = !measured(one) || bad ? "failed" : good ? "ok" : "refused";
    return element("span", {className: "status " + kind}, verdictOf(one));
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
      return element("td", {className: "number", title: quantity ? String(quantity.value) : ""},
                     quantity ? interval(quantity) : "–");
    });
    const rows = scene.findings.map(one => {
      const row = element("tr", {}, element("td", {}, one.line.name), element("td", {}, one.label),
                          element("td", {}, verdictMark(one)),
                          element("td", {className: "reason"}, one.reason || one.message),
                          ...cells(one));
      row.dataset.key = one.key;
      return row;
    });
    const heads = ["method", "options", "verdict", "in words"].map(text =>
      element("th", {scope: "col"}, text)).concat(quantities.map(({name, unit}) =>
      element("th", {scope: "col", className: "number"}, name,
              unit ? element("span", {className: "unit"}, ` [${unit}]`) : null)));
    section.append(
      element("h3", {}, `Every method (${scene.findings.length})`),
      element("div", {className: "scroll"}, element("table", {className: "cases findings"},
        element("thead", {}, element("tr", {}, heads)), element("tbody", {}, rows))),
      tableSaver(`${scene.name} findings`, () => [
        ["method", "options", "verdict", "in words",
         ...quantities.flatMap(each => [titleOf(each), each.name + " low", each.name + " high"])],
        ...scene.findings.map(one => [
          one.method, one.options, verdictOf(one), one.reason || one.message,
          ...quantities.flatMap(({name}) => {
            const {value, low, high} = quantityOf(one, name) || {};
            return [value, low, high];
          })])]));
  };

  /* --- runs by step: a strip a method, a mark a run, its look the run's end --- */

  /* "stable" and "held" are the good ends and come first, so that they look the same everywhere. */
  const wordLooks = words => {
    const good = words.filter(word => /^(stable|held|holds)/.test(word));
    const ordered = good.concat(words.filter(word => !good.includes(word)).sort());
    const looks = new Map();
    ordered.forEach((word, i) =>
      looks.set(word, lookOf(good.length ? i : i + 1)));
    return looks;
  };

  const withSteps = findings => findings.filter(one => column(one, "step") === 0 && one.rows.length);

  const namesAxis = (title, names) => ({
    type: "linear", min: -0.6, max: names.length - 0.4, reverse: true,
    title: {display: Boolean(title), text: title, color: "#222"},
    grid: {color: "#e2e2e2", tickColor: "#888"},
    ticks: {autoSkip: false, color: "#222", callback: (value, i, ticks) => ticks[i].label},
    afterBuildTicks: axis => {
      axis.ticks = names.map((label, value) => ({value, label}));
    },
  });

  /* `strips`: [{name, one}]. */
  const stripPlan = (scene, strips, yTitle, hidden) => {
    const runs = strips.flatMap(({one}, y) => one.rows.filter(row => row.values[0] > 0).map(row =>
      ({x: row.values[0], y, word: row.word, row, one})));
    if (!runs.length) return null;
    const looks = wordLooks(unique(runs.map(run => run.word)));
    return {
      lines: [...looks].map(([word, look]) => ({
        name: word || "run", look: {...look, dash: []}, bare: true,
        points: runs.filter(run => run.word === word)})),
      hidden, radius: 4.5, marks: {},
      x: logX(titleOf(strips[0].one.columns[0]), runs.map(run => run.x)),
      y: namesAxis(yTitle, strips.map(({name}) => name)),
      tooltip: run => run.one.columns.map((each, i) => `${titleOf(each)}: ${shown(run.row.values[i])}`)
        .concat(nameOf(run.one)),
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

  const heightOf = strips => `${Math.max(9, 5 + 1.6 * strips.length)}rem`;

  const writeStrips = (scene, section) => {
    const strips = withSteps(scene.findings).map(one => ({name: nameOf(one), one}));
    if (!strips.length) return () => {};
    return chartOf(section, "strips", `${scene.name} runs by step`, "How runs end, by their step",
                   heightOf(strips), hidden => stripPlan(scene, strips, "", hidden));
  };

  /* --- maps: the same over scenes that differ in a number of theirs --- */

  const letsOf = findings => unique(findings.flatMap(one =>
    one.quantities.filter(isLet).map(({name}) => name))).filter(name =>
    unique(findings.map(one => (quantityOf(one, name) || {}).value)).length > 1);

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
      `${Math.max(9, 5 + 1.6 * most)}rem`,
      hidden => stripPlan({name: "map"}, strips(
        lines.find(line => line.name === lists.line.value), lists.name.value),
        lists.name.value, hidden));
    for (const list of Object.values(lists)) list.addEventListener("change", () => draw());
    draw();
  };

  /* --- series over time --- */

  const withTimes = findings => findings.filter(one => column(one, "time") === 0 && one.rows.length);

  const seriesPlan = (scene, one, hidden) => {
    const errors = one.columns.slice(1).every(({name}) => /error/.test(name));
    const lines = one.columns.slice(1).map((each, k) => ({
      name: titleOf(each), look: lookOf(k),
      points: one.rows.map(row => ({x: row.values[0], y: row.values[k + 1]}))
        .filter(({y}) => y !== null && (!errors || y !== 0))
        .map(({x, y}) => ({x, y: errors ? Math.abs(y) : y}))})).filter(({points}) => points.length);
    if (!lines.length) return null;
    const heights = lines.flatMap(({points}) => points.map(({y}) => y));
    const title = errors ? "|energy error| / energy scale [1]"
      : unique(lines.map(({name}) => name)).length === 1 ? lines[0].name : "";
    return {
      lines, hidden, radius: 1.5, marks: {},
      x: linearX(titleOf(one.columns[0])), y: errors ? logY(title, heights) : linearX(title),
      tooltip: point => [`time: ${shown(point.x)}`, shown(point.y)],
      label: `Over time: ${nameOf(one)}, scene ${scene.name}`,
    };
  };

  const writeSeries = (scene, section) => {
    const members = withTimes(scene.findings);
    if (!members.length) return () => {};
    const list = element("select", {}, optionList(
      members.map(one => [one.key, `${nameOf(one)}: ${verdictOf(one)}`]), members[0].key));
    section.append(element("div", {className: "controls"},
                           element("label", {}, element("span", {}, "Method"), list)));
    const draw = chartOf(section, "series", `${scene.name} over time`, "Over time", "22rem",
                         hidden => seriesPlan(scene, members.find(one => one.key === list.value),
                                              hidden));
    list.addEventListener("change", () => draw());
    return draw;
  };

  /* --- a quantity by step, a line a method, whiskers for what is known of it --- */

  const stepOf = one => Number((one.option || new Map()).get("step")) || 0;

  const writeTrend = (scene, section) => {
    const members = scene.findings.filter(one => measured(one) && stepOf(one) > 0);
    const names = verdictColumns(members).filter(quantity => !isLet(quantity));
    const steps = line => unique(members.filter(one => one.line === line).map(stepOf)).length;
    if (!names.length || !scene.lines.some(line => steps(line) > 1)) return () => {};
    const list = element("select", {}, optionList(names.map(each => [each.name, titleOf(each)]),
                                                  names[0].name));
    section.append(element("div", {className: "controls"},
                           element("label", {}, element("span", {}, "Quantity"), list)));
    const draw = chartOf(section, "trend", `${scene.name} by step`, "By step", "22rem", hidden => {
      const quantity = names.find(({name}) => name === list.value);
      const lines = scene.lines.map(line => ({
        name: line.name, look: lookOf(line.index),
        points: members.filter(one => one.line === line && quantityOf(one, quantity.name))
          .sort((a, b) => stepOf(a) - stepOf(b))
          .map(one => {
            const {value, low, high} = quantityOf(one, quantity.name);
            return {x: stepOf(one), y: value, low, high, one};
          }).filter(({y}) => y !== null)})).filter(({points}) => points.length);
      const points = lines.flatMap(each => each.points);
      if (!points.length) return null;
      return {
        lines, hidden, radius: 4.5, marks: {},
        x: logX("step [time]", points.map(({x}) => x)), y: linearX(titleOf(quantity)),
        tooltip: point => [point.one.label, interval({value: point.y, ...point}),
                           verdictOf(point.one)],
        label: `${titleOf(quantity)} by step, scene ${scene.name}`,
      };
    });
    list.addEventListener("change", () => draw());
    return draw;
  };

  /* --- the page's share --- */

  /* Methods by scenes, where there are several of both. */
  const writeMatrix = (findings, section) => {
    const sceneNames = unique(findings.map(one => one.scene)), names = unique(findings.map(nameOf));
    if (sceneNames.length < 2) return;
    const cell = (name, scene) => {
      const one = findings.find(each => nameOf(each) === name && each.scene === scene);
      return element("td", {title: one ? one.reason || one.message : ""}, one ? verdictMark(one) : "");
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
    writeMatrix(findings, section);
    writeMaps(findings, section);
    if (section.childElementCount) section.prepend(element("h2", {}, "All scenes"));
    else section.remove();
  };

  const ofScene = (scene, section) => {
    writeVerdicts(scene, section);
    const draws = [writeStrips, writeTrend, writeSeries].map(write => write(scene, section));
    for (const draw of draws) draw(); /* charts take their size from a page that is laid out */
  };

  return {overview, ofScene};
})();
