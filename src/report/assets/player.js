/* Players: a trajectory that moves, its controls, and its energy error at the same time. */

const writePlayers = (() => {
  const MARGIN = {left: 54, right: 12, top: 8, bottom: 42};
  const RADII = {least: 1.5, most: 22};
  const SHRINK = {state: 0.72, arrows: 0.45}; /* circles leave room for figures and arrows */
  const FOLLOWED = 0.96; /* part of the particles that the moving window holds */
  const SAMPLES = 200;   /* frames that windows are found from */
  const PLANES = {xy: [0, 1], xz: [0, 2], yz: [1, 2]};
  const METRIC = "|energy error| / energy scale [1]";
  const INK = "#1b1b1b", OUTLINE = "#333333", QUIET = "#5a5a5a";

  const hex = colour => "#" + colour.toString(16).padStart(6, "0");

  const decode = (text, Kind) => {
    const bytes = atob(text);
    const buffer = new Uint8Array(bytes.length);
    for (let i = 0; i < bytes.length; i++) buffer[i] = bytes.charCodeAt(i);
    return new Kind(buffer.buffer);
  };

  const read = script => {
    const film = JSON.parse(script.textContent);
    film.position = decode(film.position, Uint16Array);
    film.velocity = decode(film.velocity, Int16Array);
    if (film.state) film.state = decode(film.state, Uint8Array);
    film.count = film.time.length;
    film.unit = film.low.map((low, k) => (film.high[k] - low) / 65535);
    film.masses = [...new Set(film.mass)].sort((a, b) => a - b);
    film.least = Math.min(...film.size);
    film.mean = film.size.reduce((sum, size) => sum + size, 0) / film.particles;
    script.remove();
    return film;
  };

  const at = (film, frame, k) => (frame * film.dimension + k) * film.particles;

  /* Coordinate k of every particle. */
  const coordinates = (film, frame, k) => {
    const from = at(film, frame, k), out = new Float64Array(film.particles);
    for (let i = 0; i < out.length; i++)
      out[i] = film.low[k] + film.unit[k] * film.position[from + i];
    return out;
  };

  const speeds = (film, frame) => {
    const out = new Float64Array(film.particles);
    for (let k = 0; k < film.dimension; k++) {
      const from = at(film, frame, k);
      for (let i = 0; i < out.length; i++) out[i] += film.velocity[from + i] ** 2;
    }
    return out.map(square => Math.sqrt(square) * film.fastest / 32767);
  };

  /* --- windows: [[low, high], [low, high]] --- */

  const everything = (film, plane) => plane.map(k => film.window[k]);

  /* Where most particles are along axis k: the middle at some frames, and the widest extent. */
  const crowd = (film, k) => {
    const stride = Math.max(1, (film.count - 1) / SAMPLES), middles = [];
    let extent = 0;
    for (let frame = 0; frame <= film.count - 1 + 1e-9; frame += stride) {
      const sorted = coordinates(film, Math.round(frame), k).sort();
      const last = sorted.length - 1, cut = Math.floor(last * (1 - FOLLOWED) / 2);
      extent = Math.max(extent, sorted[last - cut] - sorted[cut]);
      middles.push((sorted[last - cut] + sorted[cut]) / 2);
    }
    return {stride, middles, extent: 1.1 * extent + 4 * film.radius};
  };

  const middleOf = ({stride, middles}, frame) => {
    const place = Math.min(frame / stride, middles.length - 1), k = Math.floor(place);
    const next = Math.min(k + 1, middles.length - 1);
    return middles[k] + (place - k) * (middles[next] - middles[k]);
  };

  const widened = window => {
    const wide = window[0][1] - window[0][0], tall = window[1][1] - window[1][0];
    const least = [0.15 * tall || 1, 0.15 * wide || 1];
    return window.map(([low, high], k) => {
      const lack = Math.max(0, least[k] - (high - low)) / 2;
      return [low - lack, high + lack];
    });
  };

  const followed = (film, plane, frame) => widened(plane.map(k => {
    if (!film.crowds[k]) film.crowds[k] = crowd(film, k);
    const middle = middleOf(film.crowds[k], frame), half = film.crowds[k].extent / 2;
    return [middle - half, middle + half];
  }));

  const areaOf = ([[left, right], [low, high]]) => (right - left) * (high - low);

  const isSpread = (film, plane) =>
    areaOf(followed(film, plane, 0)) < 0.4 * areaOf(everything(film, plane));

  /* --- drawing --- */

  /* The plot within the canvas, as wide and as tall as the window asks for. */
  const fit = (window, width, most) => {
    const room = width - MARGIN.left - MARGIN.right;
    const wide = window[0][1] - window[0][0], tall = window[1][1] - window[1][0];
    const scale = Math.min(room / wide, most / tall);
    const left = MARGIN.left + Math.max(0, (room - scale * wide) / 2);
    return {window, scale, left, top: MARGIN.top, width: scale * wide, height: scale * tall,
            x: value => left + scale * (value - window[0][0]),
            y: value => MARGIN.top + scale * (window[1][1] - value)};
  };

  const radiusOf = (film, view) =>
    Math.max(Math.min(film.radius * view.scale || 8, RADII.most), RADII.least / film.least);

  /* particle -> which of the colours it has */
  const colouring = {
    mass: film => {
      const shades = [...new Set(film.shade)];
      const rank = film.shade.map(shade => shades.indexOf(shade));
      return {colours: shades.map(hex), of: () => rank};
    },
    speed: film => ({
      colours: film.colours.map(hex),
      of: frame => {
        const [low, high] = film.speeds, last = film.colours.length - 1;
        const perUnit = high > low ? (last + 1) / (high - low) : 0;
        return speeds(film, frame).map(speed =>
          Math.max(0, Math.min(last, Math.floor(perUnit * (speed - low)))));
      },
    }),
  };
  colouring.state = colouring.mass; /* within the figures */

  const polygon = (context, x, y, radius, look) => {
    for (let k = 0; k < look.corners; k++) {
      const angle = 2 * Math.PI * (look.first + k / look.corners);
      const to = k ? "lineTo" : "moveTo";
      context[to](x + radius * look.reach * Math.cos(angle),
                  y - radius * look.reach * Math.sin(angle));
    }
    context.closePath();
  };

  const drawFigures = (context, film, frame, xs, ys, radius, members) => {
    film.states.forEach((look, state) => {
      if (!look.corners) return;
      context.beginPath();
      for (const i of members)
        if (film.state[frame * film.particles + i] === state)
          polygon(context, xs[i], ys[i], radius * film.size[i], look);
      context.fillStyle = hex(look.fill);
      context.strokeStyle = hex(look.stroke);
      context.lineWidth = 1.2;
      context.fill();
      context.stroke();
    });
  };

  const withinPlot = (view, xs, ys) => [...xs.keys()].filter(i =>
    xs[i] >= view.left - 0.5 && xs[i] <= view.left + view.width + 0.5
    && ys[i] >= view.top - 0.5 && ys[i] <= view.top + view.height + 0.5);

  /* In one path. */
  const drawCircles = (context, film, xs, ys, radius, colour, members) => {
    context.strokeStyle = OUTLINE;
    context.lineWidth = Math.min(0.9, 0.15 * radius + 0.3);
    context.beginPath();
    for (const i of members) {
      const r = radius * film.size[i];
      context.moveTo(xs[i] + r, ys[i]);
      context.arc(xs[i], ys[i], r, 0, 2 * Math.PI);
    }
    context.fillStyle = colour;
    context.fill();
    context.stroke();
  };

  const drawPins = (context, film, xs, ys, radius, members) => {
    context.strokeStyle = INK;
    context.lineWidth = 1.2;
    context.beginPath();
    for (const i of members) {
      const d = 0.6 * radius * film.size[i];
      context.moveTo(xs[i] - d, ys[i] - d);
      context.lineTo(xs[i] + d, ys[i] + d);
      context.moveTo(xs[i] - d, ys[i] + d);
      context.lineTo(xs[i] + d, ys[i] - d);
    }
    context.stroke();
  };

  /* The farther first, as in pictures: who has the plane's axes to the right and up looks from +z at
   * xy, from +x at yz, but from -y at xz. */
  const byDepth = (film, frame, plane, members) => {
    const from = at(film, frame, 3 - plane[0] - plane[1]);
    const towards = plane[0] === 0 && plane[1] === 2 ? -1 : 1;
    return members.sort((a, b) =>
      towards * (film.position[from + a] - film.position[from + b]) || a - b);
  };

  /* What is usually the fastest reaches past the next particle, the fastest of all not far. */
  const arrowScale = (film, view) =>
    film.fastest > 0 ? Math.min(2 * Math.max(10, 2 * film.radius * film.mean * view.scale) / film.speeds[1],
                                Math.max(view.width, view.height) / 5 / film.fastest) : 0;

  const arrow = (context, x, y, dx, dy) => {
    const length = Math.hypot(dx, dy);
    if (length < 1.5) return;
    const head = Math.min(6, 0.45 * length) / length;
    const [tipX, tipY] = [x + dx, y + dy];
    context.moveTo(x, y);
    context.lineTo(tipX, tipY);
    context.moveTo(tipX - head * (dx - 0.4 * dy), tipY - head * (dy + 0.4 * dx));
    context.lineTo(tipX, tipY);
    context.lineTo(tipX - head * (dx + 0.4 * dy), tipY - head * (dy - 0.4 * dx));
  };

  const drawArrows = (context, film, frame, plane, view, xs, ys) => {
    const unit = film.fastest / 32767 * arrowScale(film, view);
    const [across, up] = plane.map(k => at(film, frame, k));
    context.strokeStyle = INK;
    context.lineWidth = 1.1;
    context.beginPath();
    for (let i = 0; i < film.particles; i++)
      arrow(context, xs[i], ys[i], unit * film.velocity[across + i],
            -unit * film.velocity[up + i]);
    context.stroke();
  };

  /* Lines across the plot at `value` of axis k, from one neighbouring wall to the other. */
  const across = (context, view, k, value, between) => {
    const [low, high] = view.window[1 - k];
    const from = Math.max(low, between ? between[0] ?? -Infinity : -Infinity);
    const to = Math.min(high, between ? between[1] ?? Infinity : Infinity);
    context.beginPath();
    context.moveTo(k ? view.x(from) : view.x(value), k ? view.y(value) : view.y(from));
    context.lineTo(k ? view.x(to) : view.x(value), k ? view.y(value) : view.y(to));
    context.stroke();
  };

  const drawSurroundings = (context, film, plane, view) => {
    plane.forEach((axis, k) => {
      const box = film.periods && film.periods[axis];
      context.strokeStyle = QUIET;
      context.lineWidth = 1;
      context.setLineDash([6, 4]);
      if (box) box.forEach(value => across(context, view, k, value, null));
      context.setLineDash([]);
      context.strokeStyle = "#222222";
      context.lineWidth = 3;
      if (film.walls)
        for (const value of film.walls[axis])
          if (value !== null) across(context, view, k, value, film.walls[plane[1 - k]]);
    });
  };

  const niceStep = (scale, apart) => {
    const least = apart / scale, power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map(nice => nice * power).find(step => step >= least * (1 - 1e-9));
  };

  const tickText = value =>
    String(Number(value.toPrecision(6))).replace("-", "−");

  const drawAxis = (context, view, k, name) => {
    const [low, high] = view.window[k], step = niceStep(view.scale, k ? 40 : 60);
    const bottom = view.top + view.height;
    context.textAlign = k ? "right" : "center";
    context.textBaseline = k ? "middle" : "top";
    const first = Math.ceil(low / step - 1e-9), ticks = Math.floor(high / step + 1e-9) - first + 1;
    for (let i = 0; i < ticks; i++) {
      const value = (first + i) * step;
      const x = k ? view.left : view.x(value), y = k ? view.y(value) : bottom;
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(k ? x - 4 : x, k ? y : y + 4);
      context.stroke();
      context.fillText(tickText(value), k ? x - 7 : x, k ? y : y + 7);
    }
    context.textAlign = "center";
    context.save();
    context.translate(k ? Math.max(9, view.left - 45) : view.left + view.width / 2,
                      k ? view.top + view.height / 2 : bottom + 25);
    if (k) context.rotate(-Math.PI / 2);
    context.fillText(`${name} [length]`, 0, 0);
    context.restore();
  };

  const drawAxes = (context, view, plane) => {
    context.strokeStyle = QUIET;
    context.lineWidth = 1;
    context.strokeRect(view.left, view.top, view.width, view.height);
    context.fillStyle = INK;
    context.font = "12px system-ui, 'Liberation Sans', Arial, sans-serif";
    plane.forEach((axis, k) => drawAxis(context, view, k, "xyz"[axis]));
  };

  /* Where one may hide another each is drawn by itself, else those of a colour together. */
  const batches = (film, frame, plane, members, {colours}, ranks) => {
    if (film.dimension === 3)
      return byDepth(film, frame, plane, members).map(i => ({colour: colours[ranks[i]], of: [i]}));
    const of = colours.map(() => []);
    for (const i of members) of[ranks[i]].push(i);
    return of.map((particles, rank) => ({colour: colours[rank], of: particles}))
      .filter(batch => batch.of.length);
  };

  const drawParticles = (context, film, view, frame, plane, shown) => {
    const [xs, ys] = plane.map((axis, k) => coordinates(film, frame, axis)
      .map(k ? view.y : view.x));
    const shrink = shown.arrows ? SHRINK.arrows : shown.colour === "state" ? SHRINK.state : 1;
    const radius = shrink * radiusOf(film, view), members = withinPlot(view, xs, ys);
    const pinned = new Set(film.pinned), inDepth = film.dimension === 3;
    const figures = of => {
      if (shown.colour === "state") drawFigures(context, film, frame, xs, ys, radius, of);
    };
    if (!inDepth) figures(members);
    for (const batch of batches(film, frame, plane, members, shown.colouring,
                                shown.colouring.of(frame))) {
      if (inDepth) figures(batch.of);
      drawCircles(context, film, xs, ys, radius, batch.colour, batch.of);
      if (inDepth && pinned.has(batch.of[0])) drawPins(context, film, xs, ys, radius, batch.of);
    }
    if (!inDepth && pinned.size) drawPins(context, film, xs, ys, radius, film.pinned);
    if (shown.arrows) drawArrows(context, film, frame, plane, view, xs, ys);
    return members.length;
  };

  const drawFrame = (canvas, film, view, frame, plane, shown) => {
    const context = canvas.getContext("2d");
    const ratio = canvas.width / canvas.clientWidth || 1;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = "#ffffff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.save();
    context.beginPath();
    context.rect(view.left, view.top, view.width, view.height);
    context.clip();
    drawSurroundings(context, film, plane, view);
    const drawn = drawParticles(context, film, view, frame, plane, shown);
    context.restore();
    drawAxes(context, view, plane);
    return drawn;
  };

  /* --- legend --- */

  const mark = (image, ...text) => element("span", {className: "mark"}, image, ...text);

  /* As the film draws; draw(context) has 34 x 14 to itself. */
  const painted = draw => {
    const scale = 2; /* legible when printed */
    const canvas = element("canvas", {width: 34 * scale, height: 14 * scale, className: "swatch"});
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    draw(context);
    return canvas;
  };

  const circlePicture = (radius, fill, look) => painted(context => {
    if (look && look.corners) {
      context.beginPath();
      polygon(context, 17, look.corners === 3 ? 9 : 7, 4.2, look);
      context.fillStyle = hex(look.fill);
      context.strokeStyle = hex(look.stroke);
      context.lineWidth = 1.2;
      context.fill();
      context.stroke();
    }
    context.beginPath();
    context.arc(17, look && look.corners === 3 ? 9 : 7, look ? 4 : radius, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.strokeStyle = OUTLINE;
    context.lineWidth = 0.9;
    context.fill();
    context.stroke();
  });

  const massMarks = (film, shaded) => {
    const most = 6, {masses} = film;
    const shown = masses.length <= most ? masses : [...Array(most).keys()].map(
      k => masses[Math.floor(k * (masses.length - 1) / (most - 1))]);
    return shown.map(mass => {
      const i = film.mass.indexOf(mass), number = film.mass.filter(one => one === mass).length;
      return mark(circlePicture(6.5 * film.size[i], shaded ? hex(film.shade[i]) : "#ffffff"),
                  `mass ${mass}` + (masses.length <= most ? ` (${number})` : ""));
    });
  };

  const speedMark = film => mark(painted(context => {
    film.colours.forEach((colour, k) => {
      context.fillStyle = hex(colour);
      context.fillRect(34 * k / film.colours.length, 1, 1, 12);
    });
  }), `speed ${film.speeds.map(speed => tickText(Number(speed.toPrecision(3)))).join(" to ")}`
     + (film.fastest > film.speeds[1] ? " and more" : "") + " [length/time]");

  const makeKey = film => {
    const box = element("div", {className: "legend"});
    const numbers = film.states.map(() => element("span", {}));
    const show = colour => box.replaceChildren(...{
      mass: () => massMarks(film, true),
      speed: () => [speedMark(film)].concat(film.masses.length > 1 ? massMarks(film, false) : []),
      state: () => film.states.map((look, k) =>
        mark(circlePicture(4, "#ffffff", look), look.name + " ", numbers[k]))
        .concat(film.masses.length > 1 ? massMarks(film, true) : []),
    }[colour]());
    const tally = frame => {
      const count = film.states.map(() => 0);
      for (let i = 0; i < film.particles; i++) count[film.state[frame * film.particles + i]]++;
      numbers.forEach((span, k) => { span.textContent = `(${count[k]})`; });
    };
    return {box, show, tally};
  };

  /* --- energies over time --- */

  const nearestFrame = (film, time) => {
    let low = 0, high = film.count - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (film.time[middle] <= time) low = middle; else high = middle;
    }
    return time - film.time[low] < film.time[high] - time ? low : high;
  };

  const timeAxis = film => {
    const axis = linearX("time");
    axis.ticks.includeBounds = false;
    return {...axis, min: film.time[0], max: film.time[film.count - 1]};
  };

  /* A chart over time with an upright line at the frame that is shown; a press on it goes there.
   * `plot`: {name, title, empty, y (axis), lines: [{name, look, points}]}. */
  const makePlot = (film, go, plot) => {
    const holder = element("div", {className: "canvas"});
    const caption = element("figcaption", {}, plot.title);
    const lines = plot.lines.filter(({points}) => points.length > 1);
    if (!lines.length) {
      holder.classList.add("nothing");
      holder.append(element("p", {className: "empty"}, plot.empty));
      return {figure: element("figure", {}, caption, holder), draw: () => {}, mark: () => {}};
    }
    const canvas = element("canvas", {}), cursor = element("div", {className: "cursor"});
    canvas.dataset.chart = "player-" + plot.name;
    canvas.setAttribute("role", "img");
    holder.append(canvas, cursor);
    let chart = null;
    const legend = element("div", {});
    const figure = element("figure", {}, caption, holder, legend,
                           chartSaver(`${film.name} ${plot.title}`, () => chart));
    const seek = event => go(nearestFrame(film, chart.scales.x.getValueForPixel(event.offsetX)));
    canvas.addEventListener("pointerdown", seek);
    canvas.addEventListener("pointermove", event => { if (event.buttons & 1) seek(event); });
    const draw = () => {
      const hidden = new Set();
      chart = makeChart(canvas, {
        lines, hidden, radius: film.count > 150 ? 0 : 2, x: timeAxis(film), y: plot.y(lines),
        marks: {},
        tooltip: point => [`t = ${tickText(point.x)}`, scientific(point.y, 4),
                           `${film.method} ${film.options}`],
        csv: {heads: ["line", "method", "options", "time [time]", plot.unit],
              row: (point, line) => [line, film.method, film.options, point.x, point.y]},
        label: plot.title + " against time",
      });
      if (lines.length > 1) legend.append(makeLegend(lines, hidden, [chart], {}));
    };
    const put = frame => {
      const {chartArea: area, scales: {x}} = chart;
      cursor.style.transform = `translateX(${x.getPixelForValue(film.time[frame])}px)`;
      cursor.style.top = area.top + "px";
      cursor.style.height = area.bottom - area.top + "px";
    };
    return {figure, draw, mark: put};
  };

  const overTime = (film, values) =>
    (values || []).map((y, k) => ({x: film.time[k], y})).filter(({y}) => y !== null);

  const errorPlot = film => ({
    name: "energy", title: "Energy error", unit: METRIC,
    empty: film.energy ? "The energy error is 0 in all but one frame at most."
                       : "The file has no energy error.",
    y: ([{points}]) => logY(METRIC, points.map(point => point.y)),
    lines: [{name: "energy error", look: lookOf(0),
             points: overTime(film, film.energy).filter(({y}) => y > 0)}],
  });

  const ENERGY = "energy [energy]";

  const energyPlot = film => {
    const {kinetic, potential} = film;
    const total = kinetic && potential && kinetic.map((value, k) =>
      (value === null || potential[k] === null ? null : value + potential[k]));
    const lines = [["kinetic", kinetic], ["potential", potential], ["kinetic + potential", total]];
    return {
      name: "parts", title: "Kinetic and potential energy", unit: ENERGY,
      empty: "The file has no energies.",
      y: () => linearX(ENERGY),
      lines: lines.map(([name, values], k) =>
        ({name, look: lookOf(k), points: overTime(film, values)})),
    };
  };

  /* --- controls --- */

  const labelled = (text, control) =>
    element("label", {}, element("span", {}, text), control);

  const button = (text, title, press) => {
    const made = element("button", {type: "button", title}, text);
    made.addEventListener("click", press);
    return made;
  };

  const chooser = (choices, chosen, change) => {
    const list = element("select", {}, optionList(choices, chosen));
    list.addEventListener("change", () => change(list.value));
    return list;
  };

  const SPEEDS = [["0.1", "1/10"], ["0.25", "1/4"], ["0.5", "1/2"], ["1", "1"], ["2", "2"],
                  ["4", "4"], ["10", "10"]];

  /* The whole in about 20 seconds, but neither a slide show nor a blur. */
  const framesPerSecond = film => Math.min(60, Math.max(8, film.count / 20));

  /* A player is what the functions below share: `film`, where it is, how it is shown, and the
   * elements that show it. */
  const layOut = player => {
    const {canvas, film, mode, plane, frame} = player, width = canvas.clientWidth;
    if (!width) return;
    const most = Math.max(220, Math.min(0.72 * window.innerHeight, 640));
    const seen = mode === "follow" ? followed(film, plane, frame) : everything(film, plane);
    player.view = fit(seen, width, most);
    const height = Math.round(player.view.height + MARGIN.top + MARGIN.bottom);
    const ratio = Math.max(1, window.devicePixelRatio || 1);
    canvas.style.height = height + "px";
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  };

  const tell = ({film, frame, told}) => {
    const error = film.energy && film.energy[frame];
    told.textContent = `t = ${tickText(film.time[frame])} · step ${count(film.step[frame])} · `
      + `frame ${frame + 1} of ${film.count}`
      + (error !== null ? ` · energy error ${scientific(error)}` : "");
  };

  const draw = player => {
    const {canvas, film, plane, frame} = player;
    if (!player.view) return;
    if (player.mode === "follow")
      player.view = fit(followed(film, plane, frame), canvas.clientWidth,
                        player.view.height + 1e-9);
    const drawn = drawFrame(canvas, film, player.view, frame, plane, player);
    Object.assign(canvas.dataset, {frame, drawn, colour: player.colour});
    tell(player);
    if (player.colour === "state") player.legend.tally(frame);
    player.scrub.value = frame;
    for (const plot of player.plots) plot.mark(frame);
  };

  const refit = player => {
    layOut(player);
    draw(player);
  };

  const go = (player, frame) => {
    player.frame = Math.max(0, Math.min(player.film.count - 1, frame));
    draw(player);
  };

  const play = (player, on) => {
    if (on && player.frame === player.film.count - 1) player.frame = 0;
    player.playing = on;
    player.last = null;
    player.part = 0;
    player.toggle.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(now => tick(player, now));
  };

  const tick = (player, now) => {
    const {film} = player;
    if (!player.playing) return;
    if (player.last !== null)
      player.part += (now - player.last) / 1000 * framesPerSecond(film) * player.speed;
    player.last = now;
    const passed = Math.floor(player.part);
    player.part -= passed;
    if (passed) go(player, player.frame + passed);
    if (player.frame === film.count - 1) play(player, false);
    else requestAnimationFrame(later => tick(player, later));
  };

  const stopAt = (player, frame) => {
    if (player.playing) play(player, false);
    go(player, frame);
  };

  const setColour = (player, colour) => {
    player.colour = colour;
    player.colouring = colouring[colour](player.film);
    player.legend.show(colour);
    draw(player);
  };

  const makeTransport = player => {
    const {film} = player;
    player.toggle = button("Play", "play or pause (space)", () => play(player, !player.playing));
    player.toggle.className = "play";
    player.scrub = element("input", {type: "range", min: 0, max: film.count - 1, step: 1, value: 0});
    player.scrub.setAttribute("aria-label", "frame");
    player.scrub.addEventListener("input", () => stopAt(player, Number(player.scrub.value)));
    return element("div", {className: "transport"}, player.toggle,
      button("−1", "one frame back (left arrow)", () => stopAt(player, player.frame - 1)),
      button("+1", "one frame on (right arrow)", () => stopAt(player, player.frame + 1)),
      player.scrub);
  };

  const makeChoices = player => {
    const {film} = player;
    const colours = [["mass", "mass"], ["speed", "speed"]]
      .concat(film.state ? [["state", "solid, liquid, gas"]] : []);
    const windows = [["all", "everything"], ["follow", "follows most particles"]];
    const set = key => value => {
      player[key] = value;
      refit(player);
    };
    const arrows = element("input", {type: "checkbox"});
    arrows.addEventListener("change", () => set("arrows")(arrows.checked));
    return element("div", {className: "controls"},
      labelled("Speed", chooser(SPEEDS, "1", value => { player.speed = Number(value); })),
      labelled("Colour", chooser(colours, player.colour, value => setColour(player, value))),
      labelled("Window", chooser(windows, player.mode, set("mode"))),
      film.dimension === 3
        ? labelled("Plane", chooser(Object.keys(PLANES).map(name => [name, name]), "xy",
                                    name => set("plane")(PLANES[name])))
        : null,
      element("label", {}, arrows, element("span", {}, "velocities")));
  };

  /* What a key does on the element that has the focus, a button or a list, stays as it is. */
  const isNative = ({target, key}) =>
    target.tagName === "SELECT" || target.type === "checkbox"
    || (target.tagName === "BUTTON" && key === " ") || (target.type === "range" && key !== " ");

  const keyboard = player => {
    const last = player.film.count - 1;
    const keys = {" ": () => play(player, !player.playing),
                  ArrowLeft: () => stopAt(player, player.frame - 1),
                  ArrowRight: () => stopAt(player, player.frame + 1),
                  Home: () => stopAt(player, 0), End: () => stopAt(player, last)};
    return event => {
      if (isNative(event) || !keys[event.key] || event.ctrlKey || event.altKey || event.metaKey)
        return;
      event.preventDefault();
      keys[event.key]();
    };
  };

  const makeCanvas = film => {
    const canvas = element("canvas", {tabIndex: 0, className: "film"});
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${film.particles} particles of ${film.name}; space plays, `
                                      + "arrow keys step");
    return canvas;
  };

  /* Returns what the player does with a key. */
  const makePlayer = (film, root) => {
    film.crowds = [];
    const player = {
      film, frame: 0, playing: false, speed: 1, last: null, part: 0, view: null, plane: PLANES.xy,
      mode: !film.walls && isSpread(film, PLANES.xy) ? "follow" : "all",
      colour: film.masses.length > 1 ? "mass" : "speed", arrows: false,
      canvas: makeCanvas(film), told: element("p", {className: "told"}), legend: makeKey(film),
    };
    player.plots = [errorPlot, energyPlot].map(plot =>
      makePlot(film, frame => stopAt(player, frame), plot(film)));
    const stage = element("div", {className: "stage"}, player.canvas, player.told,
                          makeTransport(player), makeChoices(player), player.legend.box);
    const key = keyboard(player);
    root.append(stage, element("div", {className: "plots"},
                               player.plots.map(({figure}) => figure)));
    root.addEventListener("keydown", key);
    for (const plot of player.plots) plot.draw(); /* their size is of a page that is laid out */
    setColour(player, player.colour);
    refit(player);
    new ResizeObserver(() => refit(player)).observe(stage);
    return key;
  };

  /* --- sections --- */

  const describe = film => [
    `${film.particles} particles, ${count(film.frames)} frames`,
    film.stride > 1 ? `1 of every ${film.stride} shown, ${count(film.count)} in all, so that the `
                      + "page stays small: what happens between them is not seen" : "",
    film.options].filter(Boolean).join(" · ");

  const writeOne = (page, script, title) => {
    const film = read(script);
    const wide = areaOf(everything(film, PLANES.xy)) > 0
      && film.window[0][1] - film.window[0][0] > 2 * (film.window[1][1] - film.window[1][0]);
    const root = element("div", {className: "player" + (wide ? " wide" : "")});
    page.append(element("section", {className: "motion"},
      element("h2", {}, (title === film.name ? "In motion" : film.name + " in motion")
                        + (film.method ? ": " + film.method : "")),
      element("p", {className: "quiet"}, describe(film)), root));
    return makePlayer(film, root);
  };

  return page => {
    const keys = [...document.querySelectorAll("script.trajectory")]
      .map(script => writeOne(page, script, document.title));
    if (keys.length === 1)
      document.addEventListener("keydown", event => {
        if (event.target === document.body) keys[0](event);
      });
  };
})();
