/* Numbers and options as a reader wants them. */

const superscript = exponent =>
  String(exponent).replace(/[-0-9]/g, c => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);

/* 3.1×10⁻⁷; a bare power where the factor is 1. */
const scientific = (value, digits = 2) => {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const [factor, exponent] = value.toExponential(digits - 1).split("e");
  const shortest = String(Number(factor));
  if (exponent === "+0") return shortest;
  const power = "10" + superscript(Number(exponent));
  return shortest === "1" ? power : shortest + "×" + power;
};

/* For table columns: 3.14e-7. */
const shortReal = value => {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  return value.toExponential(2).replace("e+", "e");
};

const shortSeconds = value => {
  if (value === null || value === undefined) return "–";
  if (value < 1e-3 || value >= 1e5) return shortReal(value);
  return value >= 100 ? value.toFixed(0) : value.toPrecision(3);
};

/* For sentences. */
const seconds = value =>
  (value >= 1e-3 && value < 1e5 ? shortSeconds(value) : scientific(value, 3)) + "\u00a0s";

const count = value =>
  value === null || value === undefined ? "–"
                                        : String(value).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");

const timesAsMuch = ratio =>
  ratio < 1.05 ? "about as much" : `${ratio.toFixed(ratio < 10 ? 1 : 0)} times as much`;

/* "step=0.01 order=4" -> Map; a value may hold spaces. */
const parseOptions = text =>
  new Map(text.split(/\s+(?=[\w.-]+=)/).filter(Boolean).map(part => {
    const at = part.indexOf("=");
    return at < 0 ? [part, ""] : [part.slice(0, at), part.slice(at + 1)];
  }));

const optionText = (key, value) => (key === "step" ? "Δt" : key) + "\u00a0=\u00a0" + value;

/* Options along which a line runs; any other that varies makes another line. */
const STEP_OPTIONS = ["step", "rtol", "atol"];

const isNumber = text => text !== "" && Number.isFinite(Number(text));

/* A method that chooses its steps has step=0. */
const isAdaptive = one => one.option.get("step") === "0";

/* name -> cases; methods that were run both ways are two. */
const groupByMethod = cases => {
  const both = method => new Set(
    cases.filter(one => one.method === method).map(isAdaptive)).size > 1;
  const groups = new Map();
  for (const one of cases) {
    const way = !both(one.method) ? "" : isAdaptive(one) ? " adaptive" : " fixed step";
    const name = one.method + way;
    groups.set(name, (groups.get(name) || []).concat(one));
  }
  return groups;
};

/* Splits the cases of a scene into lines, in order of first appearance, and gives each case its
 * `line` and its short `label`. `known`, name -> line, has those of the scenes before: the same line
 * has the same index, so the same look, in each scene. */
const findLines = (cases, known) => {
  for (const one of cases) one.option = parseOptions(one.options);
  for (const [method, members] of groupByMethod(cases)) {
    const varying = varyingOptions(members);
    let along = varying.filter(key => STEP_OPTIONS.includes(key));
    if (!along.length)
      along = varying.filter(key => members.every(one => isNumber(one.option.get(key) || "")));
    const apart = varying.filter(key => !along.includes(key));
    for (const one of members) {
      const name = [method].concat(apart.map(key => `${key}=${one.option.get(key)}`)).join(" ");
      if (!known.has(name)) known.set(name, {name, index: known.size});
      one.line = known.get(name);
      one.label = caseLabel(one, along);
    }
  }
};

const varyingOptions = members => {
  const keys = [...new Set(members.flatMap(one => [...one.option.keys()]))];
  return keys.filter(key => new Set(members.map(one => one.option.get(key))).size > 1);
};

const caseLabel = (one, along) => {
  const stepping = isAdaptive(one) ? ["rtol"] : STEP_OPTIONS;
  let keys = along.filter(key => one.option.has(key));
  if (!keys.length) keys = stepping.filter(key => one.option.has(key)).slice(0, 1);
  return keys.map(key => optionText(key, one.option.get(key))).join(", ");
};
