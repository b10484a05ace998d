#!/bin/bash
# The report in a real browser: every chart holds the points that the results have, the table every
# case, nothing throws, nothing overlaps or is wider than the window, and the controls work.
#
#     test_report_browser.sh DRIFTLAB      (test_report, built beside it, fabricates the studies)
set -euo pipefail

# shellcheck source=tests/fixture_browser.sh
. "$(dirname "$0")/fixture_browser.sh"

fabricate=$(dirname "$program")/test_report
"$fabricate" "$work"

# Looks at the page after it is drawn, uses its controls and tells the frame around it what it saw.
cat > "$work/probe.js" <<'PROBE'
addEventListener("load", async () => {
  const seen = {};
  const points = name => all(`canvas[data-chart=${name}]`).map(canvas => canvas.dataset.points);
  const first = name => Number(points(name)[0] || 0);
  const inked = canvas => {
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let ink = 0;
    for (let i = 0; i < data.length; i += 4)
      if (data[i + 3] > 200 && Math.min(data[i], data[i + 1], data[i + 2]) < 100) ink++;
    return ink;
  };
  const overlapping = axis => {
    const {ctx} = axis.chart;
    ctx.font = Chart.helpers.toFont(axis.options.ticks.font).string;
    const size = tick => (axis.isHorizontal() ? ctx.measureText(tick.label).width : 12);
    const order = axis.ticks.map((tick, i) => [axis.getPixelForTick(i), size(tick)])
      .sort((a, b) => a[0] - b[0]);
    return order.some(([at, room], i) => i && at - order[i - 1][0] < (room + order[i - 1][1]) / 2);
  };
  seen.cases = all("section.scene table.cases tbody tr").length;
  seen.keys = new Set(all("section.scene table.cases tbody tr").map(row => row.dataset.key)).size;
  seen.scenes = all("section.scene").length;
  seen.cpu = first("cpu");
  seen.force = first("force");
  seen.steps = first("steps");
  seen.time = first("time");
  seen.wide = document.documentElement.scrollWidth > innerWidth ? 1 : 0;
  seen.missing = all("#scene-1 .missing tr").length;
  seen.answers = all("#answer p").length;
  seen.own = all("section.scene > .of-scene").length;
  seen.across = all("table.across").map(one => one.querySelectorAll("tbody tr").length).join("/");
  seen.blank = all("canvas[data-chart]").filter(
    canvas => Number(canvas.dataset.points) > 0 && inked(canvas) < 200).length;
  seen.overlaps = all("canvas[data-chart]").map(canvas => Chart.getChart(canvas)).filter(Boolean)
    .filter(chart => overlapping(chart.scales.x) || overlapping(chart.scales.y)).length;
  const saver = document.querySelector("#scene-1 figure .save button");
  if (saver) saver.click();
  for (const metric of ["position", "energy"]) {
    const choice = document.querySelector(`#scene-1 input[value=${metric}]`);
    if (choice) choice.click();
    seen[metric] = first("cpu");
    const drawn = Chart.getChart(document.querySelector("canvas[data-chart=cpu]") || "none");
    seen.front = drawn ? drawn.options.plugins.marks.front.length : 0;
    seen.accuracies = all("#scene-1 table.accuracies tbody tr").length;
  }
  const line = document.querySelector("#scene-1 .legend button");
  if (line) line.click();
  seen.hidden = seen.energy - first("cpu");
  if (line) line.click();
  seen.shown = first("cpu");
  const heading = all("#scene-1 .cases th").find(cell => cell.textContent.startsWith("CPU time"));
  if (heading) heading.querySelector("button").click();
  const column = heading ? [...heading.parentNode.children].indexOf(heading) : 0;
  const sorted = all("#scene-1 .cases tbody tr").map(row => Number(row.children[column].title));
  seen.unsorted = sorted.filter((value, i) => i && value < sorted[i - 1]).length;
  const pick = (list, index) => choose(list, list.options[index].value);
  const [error, lines] = all("#scene-1 .controls select");
  const picker = document.querySelector("#scene-1 .pickers select");
  if (lines) {
    pick(picker, 0);
    seen.without = first("time");
    pick(error, 0);
    seen.over = first("time");
    seen.momenta = [...error.options].filter(one => /momentum/.test(one.value)).length;
    choose(error, "momentum");
    seen.momentum = first("time");
    pick(error, 1);
    pick(lines, 1);
    seen.every = first("time");
  }
  const chart = Chart.getChart(document.querySelector("canvas[data-chart=cpu]") || "none");
  if (chart && chart.data.datasets.length) {
    chart.tooltip.setActiveElements([{datasetIndex: 0, index: 0}], {x: 0, y: 0});
    chart.update("none");
    seen.tooltip = chart.tooltip.title.concat(chart.tooltip.body.flatMap(part => part.lines)).length;
  }
  for (const text of saved.values()) {
    const drawing = new DOMParser().parseFromString(await text, "image/svg+xml");
    const texts = [...drawing.querySelectorAll("text")].map(one => one.textContent);
    seen.saved = texts.filter(one => /^(leapfrog|asked: |below )/.test(one)).length;
  }
  /* On paper every chart is lines, and no table is folded; afterwards all is as it was. */
  const folded = () => all("details.table:not([open])").length;
  seen.folded = folded();
  const charts = all("canvas[data-chart]").filter(one => Number(one.dataset.points) > 0).length;
  dispatchEvent(new Event("beforeprint"));
  const vectors = all("svg.vector");
  seen.vectors = vectors.length === charts && folded() === 0
    && vectors.every(one => one.querySelectorAll("polyline, circle, path").length > 0) ? 1 : 0;
  dispatchEvent(new Event("afterprint"));
  seen.restored = all("svg.vector").length === 0 && folded() === seen.folded ? 1 : 0;
  seen.painted = all(".legend .swatch").length - all(".legend svg.swatch").length;
  seen.width = innerWidth;
  tell(seen);
});
PROBE

for study in study one failed many empty; do
    expected=$(cat "$work/$study.expect")
    position=$(value "$expected" position)
    energy=$(value "$expected" energy)
    for width in 1280 400; do
        look $study $width
        same $study width $width
        same $study cases "$(value "$expected" cases)"
        same $study keys "$(value "$expected" cases)"
        same $study scenes "$(value "$expected" scenes)"
        same $study position "$position"
        same $study energy "$energy"
        same $study shown "$energy"
        same $study steps "$(value "$found" force)"
        # its least error may be exactly 0, which has no place on the axis
        corners=$(value "$expected" front)
        front=$(value "$found" front)
        [ "$front" = "$corners" ] || [ "$front" = $((corners - 1)) ] ||
            fail "$study: a front of $front corners, not $corners"
        [ "$corners" = 0 ] || [ "$(value "$found" accuracies)" -gt 0 ] ||
            fail "$study: no accuracies"
        same $study cpu "$(value "$found" force)"
        same $study vectors 1
        same $study restored 1
        same $study painted 0
        [ $width = 400 ] || same $study folded 0
        for never in wide blank overlaps unsorted; do same $study $never 0; done
        case $study in
        study)
            [ $width = 1280 ] || same study folded 3 # methods by scenes, accuracies, cases
            same study answers 1 # over both scenes; each has its own besides
            same study own 2
            [[ $(value "$found" across) == 10/* ]] || fail "study: methods by scenes are missing"
            same study hidden 4 # leap-frog: five cases, one of which failed
            same study cpu "$position"
            same study time 500 # ten methods, 51 samples each, an error of 0 at the start
            same study without 450 # one method fewer
            same study over 500    # its position errors, and the reference's own in their midst
            same study momenta 1   # the angular one is not conserved
            same study momentum 450
            same study every 250   # all five cases of leap-frog
            same study tooltip 7   # method, options, error, CPU, forces, steps, status
            same study saved 3     # a line, and the asked and the smallest error, in the SVG
            same study missing $((50 - position)) ;;
        many)
            same many hidden 12
            same many cpu "$energy" # asked in energy
            same many time 1250 ;;
        failed) same failed missing 10 ;;
        esac
    done
done
browse "$work/study.html" --screenshot="$work/study.png" > /dev/null ||
    fail "no picture: $(tail -3 "$work/log")"
[ "$(head -c 4 "$work/study.png" | tail -c 3)" = PNG ] || fail "the picture is no PNG"
echo "ok"
