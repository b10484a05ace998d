#!/bin/bash
# Pages of what studies found, in a real browser: charts hold as many points as the results, hover
# tells the whole case, the legend hides lines, figures are saved as SVG and CSV, nothing is wider
# than the window, the console stays silent.
#
#     test_findings_browser.sh DRIFTLAB
set -euo pipefail

# shellcheck source=tests/fixture_browser.sh
. "$(dirname "$0")/fixture_browser.sh"

cat > "$work/hexagon.yaml" <<'SCENE'
name: hexagon
dimension: 2
seed: 7
let: {attraction: 6}
particles:
  - {lattice: {kind: hexagonal, spacing: 1, radius: 1}, temperature: 0.02, drift: false}
pair_law:
  - {terms: [{coefficient: -1, power: $attraction}, {coefficient: 1, power: 12}]}
time: {step: 0.02, end: 10}
SCENE
cat > "$work/box.yaml" <<'SCENE'
name: box
dimension: 2
seed: 3
particles:
  - {lattice: {kind: hexagonal, spacing: 1, radius: 1}, temperature: 0.3, drift: false}
pair_law:
  - {terms: [{coefficient: -1, power: 6}, {coefficient: 1, power: 12}]}
gravity: [0, -0.1]
walls: {x: [-3, 3], y: [-3, 3], damping: 0.1, rule: mirror}
time: {step: 0.01, end: 40}
SCENE
cat > "$work/drift.yaml" <<'STUDY'
name: drift
question: Does the hexagon's energy stay?
kind: drift
scene: hexagon.yaml
samples: 200
limits: {seconds: 20}
cases:
  - {method: leapfrog, step: [0.02, 0.01, 0.5]}
  - {method: composition-4-suzuki, step: 0.02}
  - {method: gsl-rk4, step: [0.02, 0.01, 0.008, 0.005, 0.004, 0.0025]}
STUDY
cat > "$work/stability.yaml" <<'STUDY'
name: stability
question: Up to which step is the hexagon stable?
kind: stability
scene: hexagon.yaml
let: {attraction: [4, 6, 8]}
with: {unit: time, smallest: 0.01, largest: 1, points: 6, width: 0.05, spectra: 5, least: 30}
limits: {seconds: 20}
cases:
  - {method: leapfrog}
  - {method: composition-4-suzuki}
STUDY
cat > "$work/extreme.yaml" <<'STUDY'
name: extreme
question: How does a method end as its step grows?
kind: extreme
scenes: [hexagon.yaml, box.yaml]
with: {unit: frequency, smallest: 0.1, largest: 100, points: 2, least: 50, most: 500}
limits: {seconds: 20}
cases:
  - {method: leapfrog}
  - {method: composition-4-suzuki}
  - {method: composition-10-sofroniou-spaletta}
  - {method: arkode-dirk}
STUDY
cat > "$work/equilibrium.yaml" <<'STUDY'
name: equilibrium
question: What does the kinetic energy become as the step becomes smaller?
kind: equilibrium
scene: box.yaml
samples: 500
limits: {seconds: 20}
cases:
  - {method: leapfrog, step: [0.04, 0.02, 0.01]}
  - {method: composition-4-suzuki, step: [0.04, 0.02]}
STUDY

# Of each kind of chart the first is used as a reader would.
cat > "$work/probe.js" <<'PROBE'
addEventListener("load", async () => {
  const seen = {};
  const results = JSON.parse(document.getElementById("results").textContent);
  const chartOf = canvas => Chart.getChart(canvas);
  const blockOf = canvas => canvas.closest("figure");
  const count = canvas => Number(canvas.dataset.points);
  const canvasOf = name => document.querySelector(`canvas[data-chart=${name}]`);
  const legendOf = canvas => [...blockOf(canvas).nextElementSibling.querySelectorAll("button")];
  const buttonOf = (canvas, words) =>
    [...blockOf(canvas).querySelectorAll(".save button")].find(one => one.textContent === words);
  const dataRows = text => text.trim().split("\r\n").length - 1;
  const cellsAlike = text => {
    const cells = line => line.replace(/"(""|[^"])*"/g, "").split(",").length;
    return new Set(text.trim().split("\r\n").map(cells)).size === 1;
  };
  /* Under the pointer, where the point is drawn. */
  const hover = async (canvas, set, index) => {
    const chart = chartOf(canvas), point = chart.getDatasetMeta(set).data[index];
    const {left, top} = canvas.getBoundingClientRect();
    canvas.dispatchEvent(new MouseEvent("mousemove", {
      clientX: left + point.x, clientY: top + point.y, bubbles: true}));
    for (let frame = 0; frame < 3; frame++)
      await new Promise(done => requestAnimationFrame(done));
    const box = canvas.parentNode.querySelector(".told-of:not([hidden])");
    if (!box) return "";
    const {left: from, right: to, width} = box.getBoundingClientRect();
    if (width < 50 || from < 0 || to > innerWidth) return "";
    return [...box.children].map(line => line.textContent).join("|");
  };
  const leave = async canvas => {
    canvas.dispatchEvent(new MouseEvent("mouseout", {bubbles: true}));
    for (let frame = 0; frame < 3; frame++)
      await new Promise(done => requestAnimationFrame(done));
    return canvas.parentNode.querySelector(".told-of:not([hidden])") === null;
  };
  const saveBoth = async canvas => {
    for (const words of ["SVG", "CSV"]) buttonOf(canvas, words).click();
    const [svg, csv] = await Promise.all([...saved.values()]);
    saved.clear();
    return {svg, csv};
  };
  const use = async name => {
    const canvas = canvasOf(name);
    if (!canvas) return;
    const chart = chartOf(canvas), [line] = legendOf(canvas), before = count(canvas);
    const size = chart.data.datasets[0].data.length;
    const {method} = chart.data.datasets[0].data[0].one;
    seen[name] = before;
    const text = await hover(canvas, 0, 0);
    const told = text.includes(method) && /step|time/.test(text) && await leave(canvas);
    seen[name + "Told"] = told ? text.split("|").length : 0;
    line.click();
    seen[name + "Hidden"] = before - count(canvas) === size ? 1 : 0;
    line.click();
    seen[name + "Shown"] = count(canvas);
    const {svg, csv} = await saveBoth(canvas);
    const drawing = new DOMParser().parseFromString(svg, "image/svg+xml");
    const texts = [...drawing.querySelectorAll("text")].map(one => one.textContent);
    seen[name + "Svg"] = !drawing.querySelector("parsererror")
      && drawing.documentElement.tagName === "svg"
      && chart.data.datasets.every(({label}) => texts.includes(label))
      && texts.includes(chart.options.scales.x.title.text) ? 1 : 0;
    const inside = chart.data.datasets.flatMap(({data}) => data).length;
    seen[name + "Csv"] = dataRows(csv);
    seen[name + "Alike"] = cellsAlike(csv) && dataRows(csv) === inside ? 1 : 0;
  };
  try {
    const rows = document.querySelectorAll("table.findings tbody tr");
    seen.findings = rows.length;
    seen.keys = new Set([...rows].map(row => row.dataset.key)).size;
    seen.scenes = all("section.scene").length;
    seen.failures = all(".missing tr").length;
    seen.plotsFirst = all("section.scene").filter(scene => {
      const [plot, table] = ["canvas", "table.findings"].map(what => scene.querySelector(what));
      return plot.compareDocumentPosition(table) & Node.DOCUMENT_POSITION_FOLLOWING;
    }).length;
    seen.matrix = all("table.matrix tbody tr").length;
    seen.wide = document.documentElement.scrollWidth > innerWidth ? 1 : 0;
    /* In two sentences, of the only scene or of all; each of several has its own besides. */
    const told = all("#answer p, section.scene > .of-scene");
    const sentences = text => text.split(/[.](?= [A-Z0-9]|$)/).filter(Boolean).length;
    seen.answers = all("#answer p").length;
    seen.own = told.length - seen.answers;
    seen.long = told.filter(({textContent: text}) =>
      !/^[A-Z0-9].*[.]$/.test(text) || sentences(text) > 2).length;
    seen.named = told.filter(one => /arkode-dirk|leapfrog/.test(one.textContent)).length;
    seen.more = /and [0-9]+ more/.test(document.getElementById("answer").textContent) ? 1 : 0;
    seen.repeat = document.body.textContent.includes("Repeat it") ? 1 : 0;
    const expected = ["predicted limit", "2/omega along the run", "r0/|v|"];
    const named = all("canvas[data-chart=strips]").map(canvas => chartOf(canvas).scales.y);
    seen.cut = named.flatMap(axis => axis.ticks.flatMap(({label}) => label).filter(line => {
      axis.ctx.font = Chart.helpers.toFont(axis.options.ticks.font).string;
      return axis.ctx.measureText(line).width > axis.width;
    })).length;
    seen.limits = 0;
    for (const canvas of all("canvas[data-chart=strips]")) {
      const marks = legendOf(canvas).filter(line => expected.includes(line.textContent));
      const before = count(canvas);
      for (const line of marks) line.click();
      seen.runs = (seen.runs || 0) + count(canvas);
      seen.limits += before - count(canvas);
      for (const line of marks) line.click();
    }
    seen.rows = results.findings.flatMap(one => one.rows).filter(({values}) => values[0] > 0).length;
    seen.ends = new Set(all("canvas[data-chart=strips]").flatMap(canvas =>
      legendOf(canvas).map(line => line.textContent))).size;
    const cells = ({columns, rows}, k) => rows.filter(({values}) =>
      values[k] !== null && !(values[k] === 0 && columns[k].name.includes("error"))).length;
    const [first] = results.findings;
    seen.errors = first.columns.slice(1).reduce((sum, one, k) => sum + cells(first, k + 1), 0);
    seen.energies = results.findings.reduce((sum, one) => sum + cells(one, 1), 0);
    for (const name of ["strips", "map", "trend", "series"]) await use(name);
    const quantity = all(".controls select")
      .find(list => /energy fluctuation|pair energy/.test(list.textContent));
    if (quantity) {
      const before = canvasOf("trend");
      choose(quantity, "energy scale") || choose(quantity, "pair energy per particle");
      seen.redrawn = canvasOf("trend") !== before && count(canvasOf("trend"));
    }
    seen.width = innerWidth;
  } catch (failure) {
    document.body.dataset.errors = failure.stack.replace(/\s+/g, " ");
  }
  tell(seen);
});
PROBE

printed() { # KIND PATTERN: how many lines the study printed that match
    grep -c -E "$2" "$work/$1.txt" || true
}

for kind in drift stability extreme equilibrium; do
    "$program" study "$work/$kind.yaml" --out "$work/$kind.h5" --report "$work/$kind.html" \
        > "$work/$kind.txt" 2> "$work/log" || fail "$kind: no study: $(tail -3 "$work/log")"
    for width in 1280 400; do
        look $kind $width
        expect width=$width wide=0 cut=0 repeat=1 answers=1 long=0 findings="$(value "$found" keys)"
        same $kind plotsFirst "$(value "$found" scenes)"
        same $kind findings "$(printed $kind '^  [^ ]')"
        case $kind in
        drift)
            for chart in trend trendShown trendCsv redrawn; do
                same $kind $chart "$(printed $kind '^    energy fluctuation:')"
            done
            expect scenes=1 failures=1 matrix=0 own=0 named=1 more=1 trendHidden=1 trendSvg=1 \
                trendAlike=1 seriesHidden=1 seriesSvg=1 seriesAlike=1
            for chart in series seriesShown seriesCsv; do
                same $kind $chart "$(value "$found" errors)"
            done ;;
        stability)
            expect scenes=3 matrix=2 own=3 stripsHidden=1 stripsSvg=1 stripsAlike=1 \
                mapHidden=1 mapSvg=1 mapAlike=1
            same $kind runs "$(value "$found" rows)"
            [ "$(value "$found" limits)" -ge 12 ] || fail "$kind: what theory lets expect is missing" ;;
        extreme)
            expect scenes=2 matrix=4 own=2 named=3 ends=3 stripsHidden=1 stripsSvg=1 stripsAlike=1
            same $kind runs 42 # seven of each method of fixed steps on each scene
            same $kind runs "$(value "$found" rows)" ;;
        equilibrium)
            same $kind trend "$(printed $kind '^    kinetic energy per particle')"
            expect scenes=1 own=0 redrawn=5 trendCsv=5 trendHidden=1 trendSvg=1 trendAlike=1 \
                seriesHidden=1 seriesSvg=1 seriesAlike=1
            for chart in series seriesShown seriesCsv; do
                same $kind $chart "$(value "$found" energies)"
            done ;;
        esac
        for chart in strips map trend series; do
            [[ $found != *" $chart="* ]] || [ "$(value "$found" ${chart}Told)" -ge 3 ] ||
                fail "$kind: a point of $chart does not tell its case"
        done
    done
done
echo "ok"
