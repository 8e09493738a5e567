// The page: hears the monitor's events, keeps what they tell, and shows it. What belongs to another
// run than the chosen one is never drawn; a new choice opens a new stream, whose first event is
// complete, so nothing of the old one can remain.
"use strict";

(() => {
  const { Figure, h, colour, faded } = Figures;
  const $ = (id) => document.getElementById(id);
  const SILENCE_S = 3; // as in feed.h

  // ---- What is known ----

  const known = { runs: new Map(), searches: new Map(), workers: new Map(), cases: new Map(), problems: [], own: {}, monitor: null };
  let chosen = null;     // what the last events told of the choice: {run, state, scenario, ...}
  let choice = { run: null, search: null };
  let follow = { run: true, search: true };
  let now = 0, heardHere = performance.now(), everHeard = false;
  let heardTime = ""; // on the reader's clock
  let chosenNews = true; // since what is chosen was last drawn

  const clock = () => now + (performance.now() - heardHere) / 1000;

  function forget() {
    known.runs.clear();
    known.searches.clear();
    known.workers.clear();
    known.cases.clear();
    chosen = null;
    chosenNews = true;
  }

  function course(old, news) {
    if (!news) return old || [];
    const points = (old || []).slice(0, news.from);
    points.push(...news.points);
    return points;
  }

  function learn(event) {
    now = event.now;
    heardHere = performance.now();
    heardTime = new Date().toLocaleTimeString();
    everHeard = true;
    if (event.reset) {
      forget();
      known.monitor = event.monitor;
    }
    for (const run of event.runs || []) known.runs.set(run.id, run);
    for (const worker of event.workers || []) known.workers.set(worker.id, worker);
    for (const search of event.searches || []) {
      if (!known.searches.has(search.run)) known.searches.set(search.run, new Map());
      known.searches.get(search.run).set(search.search, search);
    }
    if (event.problems) known.problems = event.problems;
    if (event.own) known.own = event.own;
    if (event.chosen) learnChosen(event.chosen);
  }

  // Names of cases: {axes: paths or null, texts: by search}.
  function learnCases(run, news) {
    if (!known.cases.has(run)) known.cases.set(run, { axes: null, texts: new Map() });
    const cases = known.cases.get(run);
    if (news.axes) cases.axes = news.axes.slice(1);
    for (const [search, ...texts] of news.cases) cases.texts.set(search, texts);
  }

  function learnChosen(news) {
    if (news.run !== choice.run) return;
    chosenNews = true;
    if (news.cases) learnCases(news.run, news.cases);
    const old = chosen && chosen.search === news.search ? chosen : {};
    chosen = {
      ...old, ...news,
      scenario: news.scenario || old.scenario || null,
      steps: course(old.steps, news.steps),
      pace: course(chosen && chosen.pace, news.pace),
    };
  }

  // ---- The stream ----

  let stream = null, again = 0;

  function connect() {
    if (stream) stream.close();
    clearTimeout(again);
    const query = choice.run === null ? "" : `?run=${choice.run}` + (choice.search === null ? "" : `&search=${choice.search}`);
    stream = new EventSource("/events" + query);
    stream.onmessage = (message) => {
      learn(JSON.parse(message.data));
      if (!chooseAnew()) draw();
    };
    stream.onerror = () => {
      // The browser tries again by itself, but not after a refusal.
      if (stream.readyState === EventSource.CLOSED) again = setTimeout(connect, 3000);
      showLink();
    };
  }

  function choose(run, search) {
    if (choice.run === run && choice.search === search) return false;
    choice = { run, search };
    chosen = null;
    chosenNews = true;
    history.replaceState(null, "", run === null ? "#" : `#run=${run}` + (search === null ? "" : `&search=${search}`));
    connect();
    return true;
  }

  const isActive = (run) => run.state === "running" || run.state === "waiting for workers";
  const isSilent = (entry) => clock() - entry.heard_at > SILENCE_S;

  // Where the user has not chosen, the newest run and its latest search are shown.
  function chooseAnew() {
    let { run, search } = choice;
    if (follow.run && known.runs.size > 0) {
      const best = (r) => (isActive(r) ? 1e12 : 0) + r.heard_at;
      const runs = [...known.runs.values()];
      const current = known.runs.get(run);
      const next = runs.reduce((a, b) => (best(b) > best(a) ? b : a));
      if (!current || (!isActive(current) && next !== current && isActive(next))) {
        run = next.id;
        search = null;
      }
    }
    const searches = known.searches.get(run);
    if (searches && (search === null || (follow.search && searches.size > 1))) {
      // Those that are done are told of again and again: the latest is one that goes on, if any does.
      const rank = (s) => (s.status === "running" ? 1e12 : 0) + s.heard_at;
      const latest = [...searches.values()].reduce((a, b) => (rank(b) >= rank(a) ? b : a));
      const current = searches.get(search);
      if (!current || (current.status !== "running" && latest.status === "running")) search = latest.search;
    }
    return choose(run, search);
  }

  function readHash() {
    const hash = new URLSearchParams(location.hash.slice(1));
    const run = hash.get("run"), search = hash.get("search");
    if (run && /^[0-9a-f]{1,16}$/.test(run)) {
      choice = { run, search: search && /^\d{1,9}$/.test(search) ? +search : null };
      follow = { run: false, search: search === null };
    }
  }

  // ---- Words and numbers ----

  const plain = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
  function brief(value) {
    if (value == null) return "–";
    if (Math.abs(value) < 10000) return plain.format(value);
    const unit = Math.abs(value) < 1e6 ? [1e3, "k"] : Math.abs(value) < 1e9 ? [1e6, "M"] : [1e9, "G"];
    return (value / unit[0]).toPrecision(3) + " " + unit[1];
  }
  const percent = (share, digits = 0) => share == null ? "–" : (100 * share).toFixed(digits) + " %";
  const fixed = (value, digits) => value == null ? "–" : value.toFixed(digits).replace("-", "−");
  function span(seconds) {
    if (seconds == null || seconds < 0) return "–";
    if (seconds < 60) return seconds.toFixed(seconds < 10 ? 1 : 0) + " s";
    if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
    return `${Math.floor(seconds / 3600)} h ${Math.floor((seconds % 3600) / 60)} min`;
  }
  const names = new Intl.Collator("en", { numeric: true }); // host9 before host10
  const words = (name) => String(name).replaceAll("_", " ");
  const show = (element, text) => { if (element.textContent !== text) element.textContent = text; };

  // ---- Tables ----

  // A table whose rows keep their place in the document while their values change, sorted by a
  // column that the user chooses. columns: [{name, unit, text, value(row), cell(row, td)}].
  class Table {
    constructor(element, columns, key, sort, descending, decorate) {
      Object.assign(this, { columns, key, sort, descending, decorate, rows: new Map(), limit: Infinity });
      this.body = h("tbody");
      this.heads = columns.map((column, i) => h("th", { scope: "col", class: column.text ? "text" : null },
        h("button", { type: "button", onclick: () => this.sortBy(i) }, column.name, column.unit ? h("small", {}, ` [${column.unit}]`) : null)));
      element.append(h("thead", {}, h("tr", {}, ...this.heads)), this.body);
      this.element = element;
    }

    sortBy(index) {
      this.descending = this.sort === index ? !this.descending : !this.columns[index].text;
      this.sort = index;
      this.draw(this.data);
    }

    draw(data) {
      this.data = data;
      this.element.hidden = data.length === 0;
      this.heads.forEach((head, i) => head.setAttribute("aria-sort", i !== this.sort ? "none" : this.descending ? "descending" : "ascending"));
      const value = this.columns[this.sort].value;
      const sign = this.descending ? -1 : 1;
      const order = (a, b) => (a == null) - (b == null) ||
        sign * (typeof a === "number" && typeof b === "number" ? a - b : names.compare(a, b));
      const sorted = [...data].sort((a, b) => order(value(a), value(b)) || sign * order(this.key(a), this.key(b))).slice(0, this.limit);
      const kept = new Set();
      let place = this.body.firstChild;
      for (const entry of sorted) {
        const key = String(this.key(entry));
        kept.add(key);
        if (!this.rows.has(key)) this.rows.set(key, this.row(entry));
        const row = this.rows.get(key);
        row.entry = entry;
        this.columns.forEach((column, i) => column.cell ? column.cell(entry, row.cells[i]) : show(row.cells[i], String(column.show ? column.show(entry) : column.value(entry))));
        if (this.decorate) this.decorate(entry, row.element);
        if (place === row.element) place = place.nextSibling;
        else this.body.insertBefore(row.element, place);
      }
      for (const [key, row] of this.rows) {
        if (kept.has(key)) continue;
        row.element.remove();
        this.rows.delete(key);
      }
    }

    row(entry) {
      const row = { entry };
      row.cells = this.columns.map((column) => {
        if (!column.pick) return h("td", { class: column.text ? "text" : null });
        return h("button", { type: "button", class: "pick", onclick: () => column.pick(row.entry) });
      });
      row.element = h("tr", {}, ...row.cells.map((cell, i) => this.columns[i].pick ? h("th", { scope: "row", class: this.columns[i].text ? "text" : null }, cell) : cell));
      return row;
    }
  }

  function bar(cell, share, text) {
    if (!cell.firstChild) cell.append(h("span", { class: "bar" }, h("i"), h("span")));
    cell.firstChild.firstChild.style.setProperty("--share", percent(Math.min(Math.max(share || 0, 0), 1), 1).replace(" ", ""));
    show(cell.firstChild.lastChild, text);
  }

  const heard = (entry) => {
    const age = clock() - entry.heard_at;
    return age < SILENCE_S ? "now" : span(age) + " ago";
  };

  const mark = (row, current, dim) => {
    row.classList.toggle("faded", dim);
    if (current) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
  };

  const runsTable = new Table($("runs"), [
    { name: "Run", text: true, value: (r) => r.name, pick: (r) => { follow = { run: false, search: true }; choose(r.id, null); $("detail").focus({ preventScroll: true }); } },
    { name: "State", text: true, value: (r) => r.state, show: (r) => isActive(r) && isSilent(r) ? "silent" : r.state },
    { name: "Searches", value: (r) => r.searches, show: (r) => `${r.searches_done} of ${r.searches}` },
    { name: "Designs", value: (r) => r.samples, show: (r) => brief(r.samples) },
    { name: "Rate", unit: "1/s", value: (r) => r.rate, show: (r) => isActive(r) && !isSilent(r) ? brief(r.rate) : "–" },
    { name: "Workers", value: (r) => r.workers },
    { name: "Handed out again", value: (r) => r.released, show: (r) => brief(r.released) },
    { name: "Lost", value: (r) => r.lost, show: (r) => brief(r.lost) },
    { name: "Time", value: (r) => r.elapsed_s, show: (r) => span(r.elapsed_s) },
    { name: "Heard", value: (r) => r.heard_at, show: heard },
  ], (r) => r.id, 9, true, (r, row) => mark(row, r.id === choice.run, !isActive(r) || isSilent(r)));

  const pickSearch = (run, search) => { follow.search = follow.run = false; $("search-follow").checked = false; choose(run, search); };

  // The table of cases has a column an axis, so it is made when the axes are known.
  function searchesTableOf(axes) {
    $("searches").replaceChildren();
    const value = (i) => (s) => { const number = Sweep.numberOf(s.values[i]); return number === null ? s.values[i] ?? "" : number; };
    const table = new Table($("searches"), [
      { name: "Search", value: (s) => s.search, pick: (s) => pickSearch(s.run, s.search) },
      { name: "Status", text: true, value: (s) => words(s.status) },
      { name: "ln(volume)", value: (s) => s.log_volume, show: (s) => fixed(s.log_volume, 2) },
      ...axes.map((path, i) => ({ name: path, text: true, value: value(i), show: (s) => Sweep.brief(s.values[i]) })),
      { name: "Phase", text: true, value: (s) => s.phase },
      { name: "Step", value: (s) => s.step == null ? null : s.step / (s.step_count || 1), show: (s) => s.step == null ? "–" : `${s.step} of ${s.step_count}` },
      { name: "Good", unit: "%", value: (s) => s.good_share, show: (s) => percent(s.good_share).replace(" %", "") },
      { name: "Purity ≥", value: (s) => s.purity_lower95, show: (s) => s.purity_lower95 > 0 ? s.purity_lower95.toFixed(4) : "–" },
      { name: "Designs", value: (s) => s.evaluations, show: (s) => brief(s.evaluations) },
    ], (s) => s.search, 0, false, (s, row) => { mark(row, s.search === choice.search, s.status === "waiting"); if (s.name) row.title = s.name; });
    table.limit = 200;
    table.axes = axes.join();
    return table;
  }
  let searchesTable = searchesTableOf([]);

  const workersTable = new Table($("workers"), [
    { name: "Worker", text: true, value: (w) => w.name },
    { name: "State", text: true, value: (w) => w.left ? "left" : isSilent(w) ? "silent" : w.queue > 0 ? "working" : "idle",
      cell: (w, td) => { show(td, w.left ? "left" : isSilent(w) ? "⚠ silent" : w.queue > 0 ? "working" : "idle"); td.classList.toggle("flag", !w.left && isSilent(w)); } },
    { name: "Threads", value: (w) => w.threads },
    { name: "Busy", unit: "%", value: (w) => w.busy, cell: (w, td) => bar(td, w.busy, percent(w.busy)) },
    { name: "Rate", unit: "1/s", value: (w) => w.rate, cell: (w, td) => bar(td, w.rate / Table.rateMax, brief(w.rate)) },
    { name: "Queue", unit: "batches", value: (w) => w.queue },
    { name: "Designs", value: (w) => w.samples, show: (w) => brief(w.samples) },
    { name: "Lost", unit: "messages", value: (w) => w.lost, show: (w) => brief(w.lost) },
    { name: "Dropped", unit: "datagrams", value: (w) => w.dropped, show: (w) => brief(w.dropped) },
    { name: "Heard", value: (w) => w.heard_at, show: heard },
  ], (w) => w.id, 0, false, (w, row) => row.classList.toggle("faded", w.left || isSilent(w)));

  // ---- Sections ----

  function tiles(element, list) {
    if (element.children.length !== list.length)
      element.replaceChildren(...list.map(([name]) => h("div", {}, h("dt", {}, name), h("dd", {}, h("span"), h("small")))));
    list.forEach(([name, value, unit, title], i) => {
      const tile = element.children[i];
      show(tile.firstChild, name);
      show(tile.lastChild.firstChild, value);
      show(tile.lastChild.lastChild, unit || "");
      if (title) tile.title = title;
    });
  }

  const free = () => chosen && chosen.scenario ? chosen.scenario.variables.filter((v) => v.upper > v.lower).length
    : chosen && chosen.bounds ? chosen.bounds.lower.length : 0;

  function drawHead(run) {
    const state = chosen && chosen.state;
    const texts = state && known.cases.has(run.id) ? known.cases.get(run.id).texts.get(state.search) : null;
    show($("run-title"), run.name + (run.searches > 1 && state ? ` · ${texts ? texts[0] : `search ${state.search}`}` : ""));
    const status = run.searches > 1 && state ? (state.status === "running" ? state.phase : state.status)
      : run.state === "done" && state ? state.status : run.state;
    $("run-state").dataset.state = status;
    show($("run-state"), words(status));
    show($("run-heard"), isActive(run) && isSilent(run) ? `not heard for ${span(clock() - run.heard_at)}: this is how it stood then` : "");
    const share = run.searches > 1 ? run.searches_done / run.searches
      : state ? (state.status === "running" ? state.step / (state.step_count || 1) : 1) : 0;
    $("progress").firstChild.style.setProperty("--share", (100 * Math.min(share, 1)).toFixed(1) + "%");
    $("progress").setAttribute("aria-valuenow", Math.round(100 * share));
    const volume = state ? state.log_volume : null;
    const width = volume != null && free() > 0 ? Math.exp(volume / free()) : null;
    tiles($("tiles"), [
      ["Phase", state ? state.phase : "–"],
      ["Step", state ? String(state.step) : "–", state ? `of about ${state.step_count}` : ""],
      ["Good share", state ? percent(state.good_share) : "–", "", "Of the samples of the last step"],
      ["ln(volume)", fixed(volume, 2), width == null ? "" : `${percent(width)} of range`, "Sum over the free variables of ln(corridor width / design width); beside it their geometric mean"],
      ["Purity (95 %)", state && state.purity_lower95 > 0 ? "≥ " + percent(state.purity_lower95, 2) : "–", "", "The share of good designs in the box, with 95 % confidence"],
      ["Designs", brief(run.samples)],
      ["Rate", isActive(run) && !isSilent(run) ? brief(run.rate) : "–", isActive(run) && !isSilent(run) ? "designs a second" : ""],
      ["Time", span(run.elapsed_s), run.left_s >= 0 && isActive(run) ? `${span(run.left_s)} left` : ""],
    ]);
  }

  // Figures of the choice are made anew when what they show is of another shape.
  let shape = "", corridorFigures = [], courseFigures = null, paceFigures = null;

  const line = (label, name, data, more) => ({
    label, data, borderColor: colour(name), backgroundColor: faded(colour(name), more && more.$opacity || 0.3),
    pointBackgroundColor: colour(name), pointBorderColor: colour(name), borderWidth: 2, ...more,
  });

  // The variables of one spring and direction, over deformation.
  function groups(scenario) {
    const found = new Map();
    scenario.variables.forEach((variable, index) => {
      const key = `${variable.spring}${variable.direction}`;
      if (!found.has(key)) found.set(key, { spring: variable.spring, direction: variable.direction, indexes: [] });
      found.get(key).indexes.push(index);
    });
    return [...found.values()];
  }

  function corridorFigure(parent, scenario, group, top) {
    const axial = group.direction === "x";
    const name = scenario.springs[group.spring];
    const x = (i) => scenario.variables[i].deformation_m;
    const points = (value) => group.indexes.map((i) => ({ x: x(i), y: value(i) }));
    const space = [points((i) => scenario.variables[i].lower / 1e3), points((i) => scenario.variables[i].upper / 1e3)];
    const box = [[], []];
    const title = `${name}, ${axial ? "axial" : "lateral"} force F${axial ? "x" : "y"}`;
    const figure = new Figure(parent, {
      lively: true, title, file: `corridor-${name}-F${group.direction}`.replace(/[^\w.-]+/g, "_"),
      x: "Deformation [m]", y: "Force [kN]",
      axes: { y: { beginAtZero: true, suggestedMax: top }, x: { min: x(group.indexes[0]), max: x(group.indexes.at(-1)) } },
      datasets: () => [
        line("", "design", space[0], { borderDash: [5, 4], borderWidth: 1.5, $mute: true }),
        line("design space", "design", space[1], { borderDash: [5, 4], borderWidth: 1.5, fill: "-1", $opacity: 0.08, $mute: false }),
        line("", axial ? "series-1" : "series-2", box[0], { $mute: true, pointRadius: 2.5 }),
        line("corridor", axial ? "series-1" : "series-2", box[1], { fill: "-1", $opacity: 0.32, pointRadius: 2.5 }),
      ],
      tooltip: {
        filter: (item) => item.datasetIndex % 2 === 1,
        callbacks: {
          title: (items) => items.length ? `deformation ${items[0].parsed.x} m` : "",
          label: (item) => {
            const pair = item.datasetIndex === 1 ? space : box;
            return `${item.dataset.label}: ${pair[0][item.dataIndex].y.toFixed(1)} to ${pair[1][item.dataIndex].y.toFixed(1)} kN`;
          },
        },
      },
      describe: () => box[0].length === 0 ? "No corridor is known yet." : "Corridor by deformation: " +
        box[0].map((p, i) => `${p.x} m: ${p.y.toFixed(0)} to ${box[1][i].y.toFixed(0)} kN`).join("; ") + ".",
      table: () => ({
        head: ["deformation_m", "lower_N", "upper_N", "design_lower_N", "design_upper_N"],
        rows: group.indexes.map((i, k) => [x(i), box[0][k] && box[0][k].y * 1e3, box[1][k] && box[1][k].y * 1e3, space[0][k].y * 1e3, space[1][k].y * 1e3]),
      }),
    });
    return (bounds) => {
      // The same points move: the corridor is seen to grow and shrink from where it was.
      ["lower", "upper"].forEach((side, s) => {
        const told = bounds[side].length ? points((i) => bounds[side][i] / 1e3) : [];
        if (told.length === box[s].length) told.forEach((point, k) => { box[s][k].y = point.y; });
        else box[s].splice(0, box[s].length, ...told);
      });
      figure.update();
    };
  }

  // Models without springs: a bar a variable, over its range in the design space. Where the scenario
  // is not known, over plain values.
  function intervalFigure(parent, variables, known) {
    const count = Math.min(variables.length, 200);
    const share = [];
    let bounds = { lower: [], upper: [] };
    const figure = new Figure(parent, {
      title: "Interval of each variable", file: "intervals", type: "bar", wide: true,
      height: `${Math.max(10, 3.5 + count * 1.25)}rem`,
      labels: variables.slice(0, count).map((v) => v.name),
      x: known ? "Share of the design space [%]" : "Value [unit of the variable; N for forces]", y: "Variable",
      options: { indexAxis: "y", interaction: { mode: "index", intersect: false, axis: "y" } },
      axes: { x: known ? { min: 0, max: 100 } : {}, y: { type: "category" } },
      datasets: () => [line("corridor", "series-1", share, { borderSkipped: false, borderWidth: 1, $bar: true, $opacity: 0.45, backgroundColor: faded(colour("series-1"), 0.45) })],
      tooltip: { callbacks: { label: (item) => `${bounds.lower[item.dataIndex]} to ${bounds.upper[item.dataIndex]}` } },
      describe: () => variables.slice(0, 30).map((v, i) => `${v.name}: ${bounds.lower[i]} to ${bounds.upper[i]}`).join("; ") + ".",
      table: () => ({
        head: ["variable", "lower", "upper", "design_lower", "design_upper"],
        rows: variables.map((v, i) => [v.name, bounds.lower[i], bounds.upper[i], v.lower, v.upper]),
      }),
    });
    return (told) => {
      bounds = told;
      share.length = 0;
      variables.slice(0, count).forEach((v, i) => {
        const of = (value) => !known ? value : v.upper > v.lower ? (100 * (value - v.lower)) / (v.upper - v.lower) : 0;
        share.push(told.lower.length ? [of(told.lower[i]), of(told.upper[i])] : null);
      });
      figure.update();
    };
  }

  function drawCorridors() {
    const scenario = chosen && chosen.scenario;
    const bounds = chosen && chosen.bounds;
    const count = bounds ? bounds.lower.length : 0;
    const next = JSON.stringify([choice, scenario || count]);
    if (shape !== next) {
      shape = next;
      [...Figures.all].filter((figure) => $("corridors").contains(figure.element)).forEach((figure) => figure.remove());
      corridorFigures = [];
      if (scenario && scenario.springs.length > 0) {
        const list = groups(scenario);
        const top = (direction) => Math.max(...list.filter((g) => g.direction === direction).flatMap((g) => g.indexes.map((i) => scenario.variables[i].upper / 1e3)));
        corridorFigures = list.map((group) => corridorFigure($("corridors"), scenario, group, top(group.direction)));
      } else if (scenario) {
        corridorFigures = [intervalFigure($("corridors"), scenario.variables, true)];
      } else if (count > 0) {
        const numbered = bounds.lower.map((_, i) => ({ name: `variable ${i + 1}` }));
        corridorFigures = [intervalFigure($("corridors"), numbered, false)];
      }
    }
    show($("corridors-note"), !chosen || !chosen.state ? "No search of this run is heard yet."
      : !scenario ? "The monitor does not know the scenario of this search, so its corridors cannot be drawn over deformation and design space. It asks for it as long as the run goes on."
      : bounds.lower.length === 0 ? "This search has more variables than its messages carry: its corridors are in the run folder."
      : "The corridors as far as the search has come. What they promise, and what was found in them, is in the run's result.");
    if (bounds) corridorFigures.forEach((draw) => draw(bounds));
  }

  // Spans of steps in the same phase.
  function phases(steps) {
    const spans = [];
    for (const [step, phase] of steps) {
      const last = spans.at(-1);
      if (last && last.label === phase) last.to = step;
      else {
        if (last) last.to = step;
        spans.push({ label: phase, from: step, to: step });
      }
    }
    return spans;
  }

  function courseFigure(parent, title, y, column, scale, more) {
    const data = [];
    let steps = [];
    const figure = new Figure(parent, {
      title, file: title.toLowerCase().replace(/[^a-z]+/g, "-"), x: "Step", y,
      axes: { y: more.axis, x: { ticks: { precision: 0 } } },
      datasets: () => [line(more.label, more.colour, data, { pointRadius: 0, ...more.line })],
      tooltip: { callbacks: { title: (items) => items.length ? `step ${items[0].parsed.x}, ${(steps[items[0].dataIndex] || [])[1]}` : "" } },
      describe: () => steps.length === 0 ? "No step is heard yet." : `From ${data[0].y?.toFixed(2)} at step ${steps[0][0]} to ${data.at(-1).y?.toFixed(2)} at step ${steps.at(-1)[0]}, phase ${steps.at(-1)[1]}.`,
      table: () => ({ head: ["step", "phase", more.column], rows: steps.map((s) => [s[0], s[1], s[column]]) }),
    });
    return (told) => {
      steps = told;
      data.length = 0;
      data.push(...steps.map((s) => ({ x: s[0], y: s[column] == null ? null : s[column] * scale })));
      figure.chart.$bands = phases(steps);
      figure.chart.options.elements.point.radius = steps.length < 30 ? 2.5 : 0;
      figure.update();
    };
  }

  function drawCourse() {
    courseFigures ||= [
      courseFigure($("course"), "Volume of the box", "ln(volume / design space) [1]", 3, 1,
        { label: "ln(volume)", colour: "series-1", column: "log_volume", axis: { suggestedMax: 0 }, line: {} }),
      courseFigure($("course"), "Good share of the samples", "Good samples [%]", 2, 100,
        { label: "good share", colour: "series-3", column: "good_share", axis: { min: 0, max: 100 }, line: {} }),
    ];
    courseFigures.forEach((update) => update((chosen && chosen.steps) || []));
  }

  function paceFigure(parent, title, y, column, scale, more) {
    const data = [];
    let pace = [];
    const figure = new Figure(parent, {
      title, file: title.toLowerCase().replace(/[^a-z]+/g, "-"), x: "Time of the run [s]", y,
      axes: { y: { beginAtZero: true, ...more.axis } },
      datasets: () => [line(more.label, more.colour, data, { fill: "origin", $opacity: 0.12 })],
      describe: () => pace.length === 0 ? "Nothing is heard yet." : `${more.label} at last: ${data.at(-1).y?.toPrecision(3)}.`,
      table: () => ({ head: ["elapsed_s", more.column], rows: pace.map((p) => [p[0], p[column]]) }),
    });
    return (told) => {
      pace = told;
      data.length = 0;
      data.push(...pace.map((p) => ({ x: p[0], y: p[column] == null ? null : p[column] * scale })));
      figure.update();
    };
  }

  function drawPace(run) {
    paceFigures ||= [
      paceFigure($("pace"), "Throughput", "Designs [1/s]", 1, 1,
        { label: "designs a second", colour: "series-1", column: "designs_per_s", axis: { ticks: { callback: brief } } }),
      paceFigure($("pace"), "Messages lost", "Lost lately [%]", 2, 100,
        { label: "lost share", colour: "series-4", column: "lost_share", axis: { suggestedMax: 1 } }),
    ];
    paceFigures.forEach((update) => update((chosen && chosen.pace) || []));
    tiles($("losses"), [
      ["Messages lost", brief(run.lost), "", "Gaps in the sequences the coordinator heard"],
      ["Batches counted", brief(run.batches)],
      ["Handed out again", brief(run.released), "", "Batches whose lease lapsed"],
      ["Came twice", brief(run.duplicates), "", "Outcomes that came a second time and were not counted"],
      ["Rejected", brief(run.rejected), "", "Packets that failed a check"],
      ["Missed by this monitor", brief(known.own.lost || 0), "", "What is shown may lag"],
    ]);
  }

  const sweepChart = new Sweep.Chart($("searches-chart"), $("sweep-axis"), (search) => pickSearch(choice.run, search));

  function drawSearches(run) {
    $("searches-section").hidden = run.searches <= 1;
    if (run.searches <= 1) return;
    const cases = known.cases.get(run.id);
    const axes = (cases && cases.axes) || [];
    const list = Sweep.rowsOf(run, known.searches.get(run.id) || new Map(), cases);
    const filter = $("search-filter").value.trim().toLowerCase();
    const shown = filter === "" ? list : list.filter((s) => Sweep.matches(s, filter));
    if (searchesTable.axes !== axes.join()) searchesTable = searchesTableOf(axes);
    $("search-follow").checked = follow.search;
    show($("searches-count"), `${plain.format(shown.length)} of ${plain.format(list.length)} heard of, ${plain.format(run.searches)} in the run`);
    searchesTable.draw(shown);
    $("searches-more").hidden = shown.length <= searchesTable.limit;
    sweepChart.update(shown, axes);
  }

  function drawProblems() {
    const texts = known.problems.map((problem) => problem.text);
    $("problems").hidden = texts.length === 0;
    const list = $("problem-list");
    while (list.children.length > texts.length) list.lastChild.remove();
    texts.forEach((text, i) => {
      if (!list.children[i]) list.append(h("li"));
      show(list.children[i], text);
    });
  }

  function drawWorkers() {
    const list = [...known.workers.values()];
    const alive = list.filter((w) => !w.left && !isSilent(w));
    Table.rateMax = Math.max(1, ...alive.map((w) => w.rate));
    $("workers-empty").hidden = list.length > 0;
    const sum = (value) => alive.reduce((total, w) => total + value(w), 0);
    show($("workers-note"), alive.length === 0 ? "" :
      `${alive.length} working ${alive.length === 1 ? "process" : "processes"} with ${sum((w) => w.threads)} threads, ${brief(sum((w) => w.rate))} designs a second together, ${percent(sum((w) => w.busy) / alive.length)} busy`);
    workersTable.draw(list);
  }

  // ---- Freshness ----

  function showLink() {
    const age = (performance.now() - heardHere) / 1000;
    const live = everHeard && stream.readyState === EventSource.OPEN && age < SILENCE_S;
    $("link").dataset.state = live ? "live" : everHeard ? "lost" : "connecting";
    show($("link"), live ? "live" : everHeard ? "connection lost" : "connecting");
    $("stale").hidden = live || !everHeard;
    show($("stale"), live || !everHeard ? "" : `The monitor is not heard since ${heardTime}. This picture is old; it goes on by itself when the monitor is back.`);
    document.body.classList.toggle("is-stale", !live);
  }

  const xray = new Xray.Xray($("xray-section"));

  // ---- Drawing ----

  let asked = false, listsDrawn = -1e9;

  function draw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      drawNow();
    });
  }

  function drawNow() {
    showLink();
    const run = known.runs.get(choice.run);
    $("detail").hidden = !run;
    $("runs-empty").hidden = known.runs.size > 0;
    if (known.monitor) {
      show($("source"), known.monitor.source);
      // A run folder knows nothing of workers, losses and the time of each step.
      const recorded = !known.monitor.source.includes("://");
      $("workers-section").hidden = $("pace-section").hidden = recorded;
      show($("about"), `sobox ${known.monitor.version} · ${brief(known.own.received || 0)} messages heard · all data stays between this page and the monitor`);
    }
    // Lists of thousands are drawn once a second, what is chosen with every event.
    if (performance.now() - listsDrawn > 950) {
      listsDrawn = performance.now();
      drawProblems();
      runsTable.draw([...known.runs.values()]);
      drawWorkers();
      if (run) drawSearches(run);
    }
    if (!run) return;
    document.title = `${run.name} · sobox`;
    drawHead(run);
    if (!chosenNews) return;
    chosenNews = false;
    drawCorridors();
    xray.update(choice, chosen);
    drawCourse();
    drawPace(run);
  }

  // ---- Theme ----

  const themes = ["auto", "light", "dark"];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let theme = "auto";

  function setTheme(name) {
    theme = name;
    try { localStorage.setItem("theme", name); } catch { /* private windows keep nothing */ }
    document.documentElement.dataset.theme = name === "auto" ? (dark.matches ? "dark" : "light") : name;
    $("theme").querySelector("span").textContent = name;
    $("theme").setAttribute("aria-label", `Colours: ${name === "auto" ? "as the system" : name}`);
    Figures.repaint();
  }

  $("theme").addEventListener("click", () => setTheme(themes[(themes.indexOf(theme) + 1) % themes.length]));
  dark.addEventListener("change", () => setTheme(theme));
  try { theme = localStorage.getItem("theme") || "auto"; } catch { /* as above */ }
  setTheme(themes.includes(theme) ? theme : "auto");

  $("search-filter").addEventListener("input", () => { listsDrawn = -1e9; searchesTable.limit = 200; draw(); });
  $("search-follow").addEventListener("change", (event) => { follow.search = event.target.checked; if (!chooseAnew()) draw(); });
  $("searches-more").addEventListener("click", () => { searchesTable.limit += 200; listsDrawn = -1e9; draw(); });
  addEventListener("hashchange", () => { const old = choice; readHash(); if (old.run !== choice.run || old.search !== choice.search) { chosen = null; chosenNews = true; connect(); } });

  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  readHash();
  connect();
  setInterval(draw, 1000);
})();
