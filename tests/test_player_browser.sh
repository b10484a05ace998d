#!/bin/bash
# Players in a real browser: every particle is drawn in its place, the film plays, stops, steps and
# is scrubbed, colours change, nothing throws, nothing is wider than the window.
#
#     test_player_browser.sh DRIFTLAB
set -euo pipefail

# shellcheck source=tests/fixture_browser.sh
. "$(dirname "$0")/fixture_browser.sh"

# Three particles of TR299's masses, far apart: they fly straight. One leaves the others behind.
cat > "$work/three.yaml" <<'SCENE'
name: three
dimension: 2
particles:
  - {at: [0, 0], velocity: [0, 5], mass: 2000}
  - {at: [10, 0], velocity: [0, 200], mass: 6000}
  - {at: [0, 10], velocity: [20, 0], mass: 10000}
walls: {x: [-2, 12], y: [-2, none], damping: 0, rule: mirror}
time: {step: 1.0e-3, end: 0.4}
SCENE
# Thirty-six of one mass, which has no states, in three dimensions and without walls.
cat > "$work/cloud.yaml" <<'SCENE'
name: cloud
dimension: 3
seed: 7
particles:
  - {random: {count: 36, in: [[0, 4], [0, 4], [0, 4]], minimum_distance: 0.5}, speed: 1, mass: 1}
pair_law:
  - {terms: [{coefficient: 1.0e-2, power: 4}]}
time: {step: 1.0e-2, end: 0.5}
SCENE
for name in three cloud; do
    "$program" run "$work/$name.yaml" --method leapfrog --sample 0.01 --out "$work/$name.h5" > "$work/log" ||
        fail "no run: $(cat "$work/log")"
    "$program" picture "$work/$name.h5" --out "$work/$name.html" > /dev/null || fail "$name: no page"
done

# Uses the controls as a reader would and tells the frame around it what it saw.
cat > "$work/probe.js" <<'PROBE'
addEventListener("load", () => {
  const seen = {};
  const one = selector => document.querySelector(selector);
  const film = one(".film"), scrub = one(".transport input"), play = one(".play");
  const labelled = name => {
    const label = all(".controls label").find(candidate => candidate.textContent.startsWith(name));
    return label && label.querySelector("select");
  };
  const press = (key, target = document.body) =>
    target.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true, cancelable: true}));
  const frame = () => Number(film.dataset.frame);
  const goTo = number => {
    scrub.value = number;
    scrub.dispatchEvent(new Event("input"));
  };
  /* A clock of our own: whether the film runs must not hang on how fast this machine is. */
  let clock = 1000, due = [];
  window.requestAnimationFrame = draw => due.push(draw);
  const wait = time => {
    for (const end = clock + time; clock < end; clock += 20) {
      const now = due;
      due = [];
      for (const draw of now) draw(clock);
    }
  };
  const pixels = () => film.getContext("2d").getImageData(0, 0, film.width, film.height).data;
  const coloured = () => {
    const data = pixels();
    let found = 0;
    for (let i = 0; i < data.length; i += 4)
      if (Math.max(data[i], data[i + 1], data[i + 2])
          - Math.min(data[i], data[i + 1], data[i + 2]) > 60) found++;
    return found;
  };
  const dark = () => {
    const data = pixels();
    let found = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] + data[i + 1] + data[i + 2] < 200) found++;
    return found;
  };
  try {
    seen.players = document.querySelectorAll(".player").length;
    seen.drawn = film.dataset.drawn;
    seen.start = frame();
    seen.last = Number(scrub.max);
    choose(labelled("Window"), "all");
    goTo(2);
    seen.scrubbed = frame();
    press("ArrowRight");
    seen.right = frame();
    press("ArrowLeft");
    press("ArrowLeft");
    seen.left = frame();
    press("End");
    seen.end = frame();
    seen.drawnAtEnd = film.dataset.drawn;
    press("Home");
    seen.home = frame();
    seen.hasStates = choose(labelled("Colour"), "state");
    choose(labelled("Colour"), "mass");
    seen.grey = coloured() === 0 ? 1 : 0;
    const bare = dark();
    choose(labelled("Colour"), "speed");
    seen.colourful = coloured() > 50 ? 1 : 0;
    choose(labelled("Colour"), "mass");
    const box = one(".controls input[type=checkbox]");
    box.click();
    seen.arrows = dark() !== bare ? 1 : 0;
    box.click();
    choose(labelled("Speed"), "1");
    press(" ");
    seen.playing = play.textContent === "Pause" ? 1 : 0;
    wait(400);
    press(" ");
    seen.advanced = frame() > 0 ? 1 : 0;
    seen.paused = play.textContent === "Play" ? 1 : 0;
    const stopped = frame();
    wait(200);
    seen.stays = frame() === stopped ? 1 : 0;
    play.click();
    wait(9000);
    seen.playedToEnd = frame() === seen.last && play.textContent === "Play" ? 1 : 0;
    for (const [name, part] of [["energy", 0.5], ["parts", 0.25]]) {
      const canvas = one(`canvas[data-chart=player-${name}]`);
      if (!canvas) continue;
      const chart = Chart.getChart(canvas), {x} = chart.scales;
      const {left, top} = canvas.getBoundingClientRect();
      const line = canvas.parentNode.querySelector(".cursor");
      const isAt = time => Math.abs(line.getBoundingClientRect().left + 1 - left
                                    - x.getPixelForValue(time)) < 2;
      const timeOf = number => x.min + (x.max - x.min) * number / seen.last;
      const place = x.getPixelForValue(timeOf(part * seen.last));
      canvas.dispatchEvent(new PointerEvent("pointerdown",
                                            {clientX: left + place, clientY: top + 50}));
      seen[name + "Sought"] = Math.abs(frame() - part * seen.last) <= 1 ? 1 : 0;
      const sought = isAt(timeOf(frame()));
      play.click();
      wait(200);
      play.click();
      seen[name + "Cursor"] = sought && isAt(timeOf(frame())) && frame() > part * seen.last ? 1 : 0;
      seen[name] = canvas.dataset.points;
    }
    const parts = one("canvas[data-chart=player-parts]");
    if (parts) {
      const line = label => Chart.getChart(parts).data.datasets.find(set => set.label === label).data;
      seen.kinetic = line("kinetic")[0].y;
      seen.unequal = line("kinetic + potential").filter(({y}, k) =>
        Math.abs(y - line("kinetic")[k].y - line("potential")[k].y) > 1e-9 * Math.abs(y)).length;
      parts.closest("figure").querySelector(".legend button").click();
      seen.hidden = seen.parts - parts.dataset.points;
    }
    seen.told = one(".told").textContent.includes(`frame ${frame() + 1} of`) ? 1 : 0;
    seen.planes = choose(labelled("Plane"), "yz");
    seen.wide = document.documentElement.scrollWidth > innerWidth ? 1 : 0;
    seen.unnamed = [...document.querySelectorAll("button, .transport input")].filter(
      control => !control.textContent && !control.getAttribute("aria-label")).length;
    seen.width = innerWidth;
  } catch (failure) {
    document.body.dataset.errors = failure.message;
  }
  tell(seen);
});
PROBE

for width in 1280 400; do
    look three $width
    expect players=1 drawn=3 drawnAtEnd=3 start=0 last=40 scrubbed=2 right=3 left=1 end=40 home=0 \
        hasStates=1 planes=0 grey=1 colourful=1 arrows=1 playing=1 advanced=1 paused=1 stays=1 \
        playedToEnd=1 parts=123 partsSought=1 partsCursor=1 kinetic=122025000 unequal=0 hidden=41 \
        told=1 wide=0 unnamed=0 width=$width
    look cloud $width
    expect players=1 drawn=36 drawnAtEnd=36 last=50 scrubbed=2 right=3 left=1 end=50 hasStates=0 \
        planes=1 grey=1 colourful=1 arrows=1 playing=1 advanced=1 paused=1 stays=1 playedToEnd=1 \
        energySought=1 energyCursor=1 parts=153 partsSought=1 partsCursor=1 unequal=0 hidden=51 \
        told=1 wide=0 unnamed=0 width=$width
done

# A light particle in the middle that a heavy one hides from +z and +x, not from -y: of the heavy
# one's shade there is less to be seen in the plane xz. As if the file had more frames than fit.
cat > "$work/hidden.yaml" <<'SCENE'
name: hidden
dimension: 3
particles:
  - {at: [0, 0, 0], mass: 1}
  - {at: [0.01, 0.01, 0.01], velocity: [0, 0, 0.01], mass: 1000}
  - {lattice: {kind: simple-cubic, spacing: 4, count: [2, 2, 2], origin: [-2, -2, -2]}, mass: 30}
time: {step: 1.0e-2, end: 0.1}
SCENE
"$program" run "$work/hidden.yaml" --method leapfrog --sample 0.01 --out "$work/hidden.h5" > "$work/log" ||
    fail "no run: $(cat "$work/log")"
"$program" picture "$work/hidden.h5" --out "$work/whole.html" > /dev/null || fail "hidden: no page"
sed 's/"stride":1,/"stride":7,/' "$work/whole.html" > "$work/hidden.html"
cat > "$work/depth.js" <<'PROBE'
addEventListener("load", () => {
  const heavy = 0x54, film = document.querySelector(".film");
  const list = [...document.querySelectorAll(".controls label")]
    .find(label => label.textContent.startsWith("Plane")).querySelector("select");
  const covered = plane => {
    list.value = plane;
    list.dispatchEvent(new Event("change"));
    const {data} = film.getContext("2d").getImageData(0, 0, film.width, film.height);
    let found = 0;
    for (let i = 0; i < data.length; i += 4)
      if (data[i] === heavy && data[i + 1] === heavy && data[i + 2] === heavy) found++;
    return found;
  };
  const [xy, xz, yz] = ["xy", "xz", "yz"].map(covered);
  const hidden = xy > 50 && Math.abs(xy - yz) < 0.1 * xy && xz < 0.9 * xy && xz > 0.3 * xy;
  const thinned = document.querySelector(".motion .quiet").textContent.includes("1 of every 7 shown");
  parent.postMessage(`players=1 xy=${xy} xz=${xz} yz=${yz} hidden=${hidden ? 1 : 0} `
                     + `thinned=${thinned ? 1 : 0}`, "*");
});
PROBE
look hidden 1280 "$work/depth.js"
expect hidden=1 thinned=1

# The same players within a report.
cat > "$work/study.yaml" <<'STUDY'
name: short
scene: cloud.yaml
end: 0.1
error: 1.0e-3
samples: 5
reference:
  method: composition-8-kahan-li
  set: {step: 0.005}
  check: {method: composition-6-kahan-li, set: {step: 0.005}}
cases:
  - {method: leapfrog, step: [0.01]}
STUDY
if "$program" study "$work/study.yaml" --out "$work/results.h5" > "$work/log" 2>&1; then
    "$program" report "$work/results.h5" --out "$work/report.html" --trajectory "$work/cloud.h5" \
        --trajectory "$work/three.h5" > /dev/null || fail "no report with players"
    look report 1280
    expect players=2 drawn=36 scrubbed=2 energyCursor=1 partsCursor=1 parts=153 wide=0
else
    fail "no study: $(tail -3 "$work/log")"
fi
echo "ok"
