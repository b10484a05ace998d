/* Work and precision over several scenes: methods by scenes, and the cheapest for every accuracy. */

const writeAcross = (() => {
  const askedWords = scene => `${scene.asked.metric.name} ≤\u00a0${scientific(scene.asked.error)}`;
  const sceneLink = scene => element("a", {href: "#" + scene.id}, scene.name);

  /* The name is told before the content where a narrow window has no room for headings. */
  const cell = ({name}, className, ...content) => {
    const made = element("td", {className}, ...content);
    made.dataset.head = name;
    return made;
  };

  const headOf = (first, scenes, more, last) => element("thead", {}, element("tr", {},
    element("th", {scope: "col"}, first),
    scenes.map(scene => element("th", {scope: "col"}, sceneLink(scene), more(scene))),
    last ? element("th", {scope: "col", className: "number"}, last) : null));

  const ratioText = ratio =>
    ratio === null ? "" : ` · ${ratio < 10 ? ratio.toFixed(1) : ratio.toFixed(0)}×`;

  const reachedCell = (scene, reached) => {
    if (!reached) return cell(scene, "none", "not reached");
    const one = results.cases[reached.case];
    return cell(scene, reached.rank === 1 ? "first" : "", strong(`${reached.rank}. `),
                `${one.label} · ${seconds(one.cpu_seconds)}${ratioText(reached.ratio)}`);
  };

  const writeMethods = (scenes, section) => {
    const rows = results.across.map(row => element("tr", {},
      element("td", {}, row.method),
      row.cells.map((reached, i) => reachedCell(scenes[i], reached)),
      row.reached === scenes.length
        ? cell({name: "largest ratio"}, "number worst", `${row.worst.toPrecision(3)}×`)
        : cell({name: "reached on"}, "number worst", `${row.reached} of ${scenes.length}`)));
    section.append(longTable(
      "Methods by scenes", rows.length,
      element("p", {className: "quiet"}, "For what was asked of each scene: the method's rank by CPU "
        + "time, its cheapest case that reaches it, and how many times the cheapest's time that is. "
        + "Last its largest such ratio, or how many scenes it reaches it on."),
      element("div", {className: "scroll"}, element("table", {className: "cases across"},
        headOf("method", scenes, scene => element("span", {className: "unit"}, askedWords(scene)),
               "largest ratio"),
        element("tbody", {}, rows))),
      tableSaver("methods by scenes", () => [
        ["method", ...scenes.flatMap(({name}) => ["rank", "options", "CPU time [s]", "ratio"]
          .map(what => `${name}: ${what}`)), "scenes reached", "largest ratio"],
        ...results.across.map(row => [row.method, ...row.cells.flatMap(reached => {
          const one = reached && results.cases[reached.case];
          return one ? [reached.rank, one.options, one.cpu_seconds, reached.ratio]
                     : ["", "", "", ""];
        }), row.reached, row.worst])])));
  };

  /* The scene's row for that error, in what was asked of it. */
  const rowFor = (scene, error) =>
    scene.tradeoff[scene.asked.in].accuracies.find(row => row.error === error);

  const writeAccuracies = (scenes, section) => {
    const errors = [...new Set(scenes.flatMap(scene =>
      scene.tradeoff[scene.asked.in].accuracies.map(row => row.error)))].sort((a, b) => b - a);
    if (!errors.length) return;
    const cheapest = (scene, error) => {
      const row = rowFor(scene, error);
      return row && row.cpu !== null ? results.cases[row.cpu] : null;
    };
    const cellFor = (scene, error) => {
      const one = cheapest(scene, error);
      return one ? cell(scene, "", one.line.name, one.label ? ` (${one.label})` : "", " · ",
                        seconds(one.cpu_seconds)) : cell(scene, "none", "–");
    };
    section.append(longTable(
      "The cheapest for each accuracy", errors.length,
      element("div", {className: "scroll"}, element("table", {className: "cases across"},
        headOf("error at most", scenes, scene =>
          element("span", {className: "unit"}, scene.asked.metric.name), ""),
        element("tbody", {}, errors.map(error => element("tr", {},
          element("td", {}, scientific(error)), scenes.map(scene => cellFor(scene, error))))))),
      tableSaver("cheapest for each accuracy", () => [
        ["error at most", ...scenes.flatMap(({name}) => ["method", "options", "CPU time [s]"]
          .map(what => `${name}: ${what}`))],
        ...errors.map(error => [error, ...scenes.flatMap(scene => {
          const one = cheapest(scene, error);
          return one ? [one.method, one.options, one.cpu_seconds] : ["", "", ""];
        })])])));
  };

  return scenes => {
    const section = element("section", {id: "overview"}, element("h2", {}, "All scenes"));
    page.append(section);
    writeMethods(scenes, section);
    writeAccuracies(scenes, section);
  };
})();
