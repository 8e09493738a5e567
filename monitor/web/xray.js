// The samples of a step over two variables, each marked by what stands in its way, with the box drawn
// in: one page for each pair of variables. Which pair is looked at is the reader's choice, so points
// are fetched for it when they change and do not travel with the events.
"use strict";

const Xray = (() => {
  const { Figure, h, colour } = Figures;

  // A kind of sample differs from the others in colour and in shape. Good ones first.
  const LOOKS = [
    ["series-1", "circle"], ["series-2", "triangle"], ["series-4", "crossRot"], ["series-5", "rectRot"],
    ["series-3", "rect"], ["series-6", "star"],
  ];
  const look = (kind) => kind === 0 ? LOOKS[0] : LOOKS[1 + (kind - 1) % (LOOKS.length - 1)];

  const OUTCOME_WORDS = { s_L_min: "s_L_min (distance to the firewall)", non_finite: "no finite outcome" };

  function constraintName(constraint) {
    const unit = constraint.unit === "1" ? "" : " " + constraint.unit;
    const name = OUTCOME_WORDS[constraint.outcome] || constraint.outcome;
    if (constraint.min !== null && constraint.max !== null)
      return `${name} outside ${constraint.min} to ${constraint.max}${unit}`;
    return constraint.min !== null ? `${name} < ${constraint.min}${unit}` : `${name} > ${constraint.max}${unit}`;
  }

  // Forces are shown in kN, other variables as they are.
  function variableOf(scenario, index) {
    const variable = scenario && scenario.variables[index];
    if (!variable) return { name: `variable ${index + 1}`, title: `Variable ${index + 1} [unit of the variable; N for forces]`, scale: 1 };
    if (variable.spring === undefined)
      return { name: variable.name, title: `${variable.name} [unit of the variable]`, scale: 1, lower: variable.lower, upper: variable.upper };
    const name = `${scenario.springs[variable.spring]} F${variable.direction} at ${variable.deformation_m} m`;
    return { name, title: `${name} [kN]`, scale: 1e-3, lower: variable.lower / 1e3, upper: variable.upper / 1e3 };
  }

  class Xray {
    // `section` holds the controls by their ids; `fetched` is called when new points are drawn.
    constructor(section) {
      this.section = section;
      const $ = (id) => section.querySelector("#" + id);
      this.selects = [$("xray-x"), $("xray-y")];
      this.place = $("xray-place");
      this.slider = $("xray-step");
      this.stepText = $("xray-step-text");
      this.note = $("xray-note");
      this.all = $("xray-all");
      this.parent = $("xray");
      this.key = "";        // of what the figure was made for
      this.pair = [0, 1];   // places in this.free
      this.free = [];
      this.step = null;     // null: the latest
      this.asked = "";
      this.busy = false;
      this.selects.forEach((select, side) => select.addEventListener("change", () => {
        this.pair[side] = select.selectedIndex;
        this.show();
      }));
      $("xray-before").addEventListener("click", () => this.page(-1));
      $("xray-after").addEventListener("click", () => this.page(1));
      this.slider.addEventListener("input", () => this.chooseStep(+this.slider.value));
      this.parent.addEventListener("keydown", (event) => this.press(event));
    }

    press(event) {
      const actions = {
        ArrowRight: () => this.page(1), ArrowLeft: () => this.page(-1),
        ArrowUp: () => this.chooseStep(+this.slider.value + 1), ArrowDown: () => this.chooseStep(+this.slider.value - 1),
      };
      if (!actions[event.key] || event.altKey || event.ctrlKey || event.metaKey || event.target.closest(".values")) return;
      event.preventDefault();
      actions[event.key]();
    }

    // ---- Pairs and steps ----

    get pairCount() { return (this.free.length * (this.free.length - 1)) / 2; }

    // The number of a pair among (0,1), (0,2), ..., (1,2), ...
    placeOf([a, b]) {
      const n = this.free.length, low = Math.min(a, b), high = Math.max(a, b);
      return low === high ? -1 : (low * (2 * n - low - 1)) / 2 + high - low - 1;
    }

    page(by) {
      const n = this.free.length;
      if (n < 2) return;
      let [low, high] = [Math.min(...this.pair), Math.max(...this.pair)];
      if (by > 0) {
        high++;
        if (high >= n) { low++; high = low + 1; }
        if (high >= n) { low = 0; high = 1; }
      } else {
        high--;
        if (high <= low) { low--; high = n - 1; }
        if (low < 0) { low = n - 2; high = n - 1; }
      }
      this.pair = [low, high];
      this.show();
    }

    // The latest step that sampled a box. At the end a search looks beyond each of its bounds, a thin
    // slab at a time ("explain"): the slider leads there too.
    get latest() {
      const place = this.steps.findLastIndex(([, phase]) => phase !== "explain");
      return place < 0 ? this.steps.length - 1 : place;
    }

    chooseStep(place) {
      const kept = Math.min(Math.max(place, 0), this.steps.length - 1);
      this.step = kept === this.latest ? null : this.steps[kept][0];
      this.show();
    }

    // The axial and the lateral force at the middle of the first spring, or the first two variables.
    firstPair(scenario) {
      const at = (index) => scenario && scenario.variables[index];
      const first = at(this.free[0]);
      if (!first || first.spring === undefined) return [0, 1];
      const axial = this.free.filter((i) => at(i).spring === first.spring && at(i).direction === "x");
      const middle = axial[axial.length >> 1];
      const partner = this.free.findIndex((i) => at(middle) && at(i).spring === first.spring && at(i).direction === "y" && at(i).deformation_m === at(middle).deformation_m);
      return middle !== undefined && partner > 0 ? [this.free.indexOf(middle), partner] : [0, 1];
    }

    // ---- What is known ----

    // `chosen` as page.js keeps it, of what `choice` names; NULL while nothing of it is known.
    update(choice, chosen) {
      this.choice = choice;
      this.chosen = chosen;
      const samples = chosen && chosen.samples;
      this.section.hidden = !samples;
      if (!samples) return;
      this.steps = samples.steps;
      const scenario = chosen.scenario;
      const count = scenario ? scenario.variables.length : chosen.bounds ? chosen.bounds.lower.length : 0;
      const key = JSON.stringify([choice, scenario ? 1 : 0, count]);
      if (key !== this.key) {
        if (JSON.parse(this.key || "[null]")[0]?.run !== choice.run || JSON.parse(this.key)[0]?.search !== choice.search) this.step = null;
        this.key = key;
        this.begin(scenario, count);
      }
      this.show();
    }

    begin(scenario, count) {
      this.scenario = scenario;
      const before = this.free.map((i) => variableOf(this.scenarioBefore, i).name).join();
      this.free = [...Array(count).keys()].filter((i) => !scenario || scenario.variables[i].upper > scenario.variables[i].lower);
      const names = this.free.map((i) => variableOf(scenario, i).name);
      this.scenarioBefore = scenario;
      this.selects.forEach((select) => select.replaceChildren(...names.map((name) => h("option", {}, name))));
      // The next search of a sweep has the same variables: the same pair stays.
      if (names.join() !== before) this.pair = this.free.length > 1 ? this.firstPair(scenario) : [0, 0];
      this.asked = "";
      this.remove();
    }

    remove() {
      if (this.figure) this.figure.remove();
      this.figure = null;
    }

    // ---- Drawing ----

    // Asks for the points that are to be seen, unless they are there; the controls say which.
    show() {
      if (this.free.length === 0) return;
      const [a, b] = this.pair;
      this.selects.forEach((select, side) => { select.selectedIndex = this.pair[side]; });
      const place = this.placeOf(this.pair);
      this.place.textContent = place < 0 ? "the same variable" : `pair ${place + 1} of ${this.pairCount}`;
      const last = this.steps.length - 1;
      const at = this.step === null ? this.latest : this.steps.findLastIndex(([step]) => step <= this.step);
      this.slider.max = last;
      this.slider.value = Math.max(at, 0);
      this.slider.disabled = last < 1;
      const [step, phase] = this.steps[Math.max(at, 0)];
      const text = `step ${step}, ${phase}` + (this.step === null ? " (latest)" : "");
      this.stepText.textContent = text;
      this.slider.setAttribute("aria-valuetext", text);
      const query = `run=${this.choice.run}&search=${this.choice.search}&step=${step}`;
      this.all.href = `/samples.csv?${query}`;
      this.all.download = `samples-step-${step}.csv`;
      this.fetch(`/samples.json?${query}&x=${this.free[a]}&y=${this.free[b]}`, this.chosen.samples.changed);
    }

    // One question at a time; the last one that was meant is asked when the answer is there.
    async fetch(url, changed) {
      const wanted = this.step === null ? `${url}#${changed}` : url;
      if (wanted === this.asked) return;
      this.next = [url, wanted];
      if (this.busy) return;
      this.busy = true;
      while (this.next) {
        const [at, name] = this.next;
        this.next = null;
        this.asked = name;
        const told = await this.points(at);
        // An answer about what is no longer chosen is nobody's.
        if (told && !this.next && name === this.asked && !this.section.hidden) this.draw(told);
        else if (!told && this.asked === name) this.asked = "";
      }
      this.busy = false;
    }

    async points(url) {
      try {
        const answer = await fetch(url);
        return answer.ok ? await answer.json() : null;
      } catch {
        return null; // the monitor has gone: asked again with its next event
      }
    }

    // Kinds of samples: good, one a constraint, bad for a reason that is not told.
    kinds() {
      const constraints = this.scenario ? this.scenario.constraints.map(constraintName) : [];
      return ["good", ...constraints, "bad"];
    }

    kindOf(constraint) {
      if (constraint === -1) return 0;
      const known = this.scenario ? this.scenario.constraints.length : 0;
      return constraint === null || constraint >= known ? known + 1 : constraint + 1;
    }

    make() {
      const kinds = this.kinds();
      this.sets = kinds.map(() => []);
      this.box = [];
      this.sampled = [];
      const points = (label, data, kind) => ({
        label, data, type: "scatter", showLine: false, pointRadius: kind === 0 ? 3 : 4.5, pointHoverRadius: 6,
        pointStyle: look(kind)[1], borderColor: colour(look(kind)[0]),
        backgroundColor: colour(look(kind)[0]), pointBackgroundColor: colour(look(kind)[0]), pointBorderWidth: 1.5, borderWidth: 1.5,
      });
      const frame = (label, data, more) => ({
        label, data, type: "scatter", showLine: true, pointRadius: 0, pointHitRadius: 0, fill: false,
        borderColor: colour("ink"), backgroundColor: colour("ink"), borderWidth: 2, $frame: true, ...more,
      });
      this.figure = new Figure(this.parent, {
        title: "Samples", file: "samples", type: "scatter", x: "", y: "", height: "26rem", wide: true,
        options: { normalized: false, interaction: { mode: "nearest", intersect: true, axis: "xy" } },
        datasets: () => [
          frame("sampled from", this.sampled, { borderColor: colour("design"), borderDash: [5, 4], borderWidth: 1.5 }),
          frame("box", this.box),
          ...kinds.map((label, kind) => points(label, this.sets[kind], kind)),
        ],
        tooltip: {
          filter: (item) => !item.dataset.$frame,
          callbacks: {
            title: () => "",
            label: (item) => {
              const point = item.raw, [x, y] = this.variables;
              const why = point.violation == null ? "" : `, by ${(100 * point.violation).toPrecision(2)} % of its scale`;
              return [`${item.dataset.label}${why}`, `${x.name}: ${point.x.toPrecision(5)}`, `${y.name}: ${point.y.toPrecision(5)}`];
            },
          },
        },
        describe: () => this.describe(),
        table: () => ({
          head: [...(this.variables || []).map((v) => v.title), "result", "relative_violation"],
          rows: this.rows(),
        }),
      });
      this.all.hidden = false;
      this.figure.element.querySelector("figcaption").append(this.all);
    }

    rows() {
      const kinds = this.kinds();
      return this.sets.flatMap((set, kind) => set.map((p) => [p.x, p.y, kinds[kind], p.violation]));
    }

    describe() {
      if (!this.variables) return "No sample is heard yet.";
      const kinds = this.kinds();
      const counts = this.sets.map((set, kind) => set.length ? `${set.length} ${kinds[kind]}` : "").filter(Boolean);
      const side = (s) => `${this.variables[s].name} ${this.limits[s][0].toPrecision(4)} to ${this.limits[s][1].toPrecision(4)}`;
      return `${counts.join(", ")}. The box: ${side(0)}, ${side(1)}.`;
    }

    draw(told) {
      if (!this.figure) this.make();
      const variables = [variableOf(this.scenario, told.x), variableOf(this.scenario, told.y)];
      this.variables = variables;
      const scaled = (pair, side) => pair.map((value) => value * variables[side].scale);
      this.limits = [scaled(told.box.x, 0), scaled(told.box.y, 1)];
      const frame = (to, [x0, x1], [y0, y1]) => to.splice(0, to.length,
        { x: x0, y: y0 }, { x: x1, y: y0 }, { x: x1, y: y1 }, { x: x0, y: y1 }, { x: x0, y: y0 });
      frame(this.box, ...this.limits);
      frame(this.sampled, scaled(told.sampled.x, 0), scaled(told.sampled.y, 1));
      this.sets.forEach((set) => { set.length = 0; });
      for (const [x, y, constraint, violation] of told.points)
        this.sets[this.kindOf(constraint)].push({ x: x * variables[0].scale, y: y * variables[1].scale, violation });
      this.axes(variables);
      this.figure.setTitle(`${variables[1].name} over ${variables[0].name}`);
      const shown = told.count < told.samples ? `${told.count} of the step's ${told.samples.toLocaleString("en")} samples` : `All ${told.count} samples of the step`;
      const good = `${((100 * told.good) / told.samples).toFixed(0)} % of the step are good`;
      const why = told.detail === "share" ? " A certificate tells good from bad and not why."
        : " A bad one is marked by the constraint that it violates most.";
      this.note.textContent = `${shown}; ${good}.${why}`;
      this.figure.setLegend((data) => data.$frame || data.data.length > 0);
      this.figure.update();
    }

    // The whole design space, so that the box is seen in it and does not jump.
    axes(variables) {
      const spec = this.figure.spec;
      spec.x = variables[0].title;
      spec.y = variables[1].title;
      spec.axes = {
        x: { min: variables[0].lower, max: variables[0].upper }, y: { min: variables[1].lower, max: variables[1].upper },
      };
      const { x, y } = this.figure.chart.options.scales;
      [[x, 0], [y, 1]].forEach(([scale, side]) => {
        scale.title.text = variables[side].title;
        scale.min = variables[side].lower;
        scale.max = variables[side].upper;
      });
    }
  }

  return { Xray };
})();
