// The cases of a sweep: a table with what each has on the axes and how it stands, sorted and filtered,
// and the volume of each over any of the axes.
"use strict";

const Sweep = (() => {
  const { Figure, colour, faded } = Figures;

  // Of a search that goes on the volume is none to compare with.
  const STATUS = {
    done: ["series-3", "circle"],
    purity_missed: ["series-2", "triangle"], no_good_design: ["series-4", "crossRot"],
  };
  const words = (name) => String(name).replaceAll("_", " ");

  // Units of the keys that sweeps are made over, by their last name (common/scenario/README.md).
  const UNITS = {
    mass: "kg", yaw_inertia: "kg m²", speed: "m/s", overlap: "m", face_x: "m", edge_y: "m", width: "m",
    edge_radius: "m", firewall_distance: "m", duration: "s", time_step: "s", length: "m", samples: "1",
  };
  function titleOf(path) {
    const last = path.split(".").at(-1).replace(/\[.*/, "");
    const unit = UNITS[last] || (/force/.test(path) ? "N" : "");
    return unit ? `${path} [${unit}]` : path;
  }

  // A value of an axis as a number, or null when it is none.
  function numberOf(text) {
    return text !== undefined && text.trim() !== "" && isFinite(text) ? Number(text) : null;
  }

  // A value as a table shows it: 0.30000000000000004 is what a grid makes of 0.3.
  function brief(text) {
    const number = numberOf(text);
    return number === null ? text ?? "–" : String(+number.toPrecision(8));
  }

  // Searches as rows: those heard of, and the cases that only have a name so far.
  function rowsOf(run, searches, cases) {
    const rows = new Map();
    if (cases)
      for (const [index, texts] of cases.texts)
        rows.set(index, { run: run.id, search: index, name: texts[0], values: texts.slice(1), status: "waiting", phase: "–" });
    for (const [index, search] of searches) {
      const known = rows.get(index);
      rows.set(index, { ...search, name: known ? known.name : "", values: known ? known.values : [] });
    }
    return [...rows.values()];
  }

  // Every word of the filter must be somewhere in the row; a number alone names a search.
  function matches(row, filter) {
    if (/^\d+$/.test(filter)) return String(row.search) === filter || row.values.includes(filter);
    const text = `${row.name} ${row.phase} ${words(row.status)} ${row.values.join(" ")}`.toLowerCase();
    return filter.split(/\s+/).every((word) => text.includes(word));
  }

  class Chart {
    // `pick(search)` is called when a point is chosen.
    constructor(parent, select, pick) {
      this.parent = parent;
      this.select = select;
      this.pick = pick;
      this.axes = null;
      this.data = Object.keys(STATUS).map(() => []);
      select.addEventListener("change", () => { this.remove(); this.update(this.rows, this.paths); });
    }

    remove() {
      if (this.figure) this.figure.remove();
      this.figure = null;
    }

    // `paths` of the axes, without the case's name.
    update(rows, paths) {
      this.rows = rows;
      this.paths = paths;
      const names = ["search number", ...paths];
      if (JSON.stringify(names) !== this.axes) {
        this.axes = JSON.stringify(names);
        const first = paths.findIndex((_, i) => new Set(rows.map((row) => row.values[i])).size > 1);
        this.select.replaceChildren(...names.map((name) => Figures.h("option", {}, name)));
        this.select.selectedIndex = first + 1;
        this.remove();
      }
      const axis = this.select.selectedIndex - 1;
      const numeric = axis < 0 || rows.every((row) => row.values[axis] === undefined || numberOf(row.values[axis]) !== null);
      // Words stand side by side, in the order of their first case.
      const labels = numeric ? [] : [...new Set(rows.map((row) => row.values[axis]).filter((v) => v !== undefined))];
      const shape = JSON.stringify([axis, numeric, labels]);
      if (shape !== this.shape) this.remove();
      this.shape = shape;
      this.fill(rows, (row) => axis < 0 ? row.search : numeric ? numberOf(row.values[axis]) : row.values[axis]);
      if (!this.figure) this.make(axis < 0 ? "Search" : titleOf(paths[axis]), numeric, labels);
      this.figure.update();
    }

    fill(rows, valueOf) {
      const names = Object.keys(STATUS);
      this.data.forEach((points) => { points.length = 0; });
      for (const row of rows) {
        const kind = names.indexOf(row.status), x = valueOf(row);
        if (kind >= 0 && row.log_volume != null && x != null && x !== undefined)
          this.data[kind].push({ x, y: row.log_volume, search: row.search, name: row.name });
      }
    }

    make(title, numeric, labels) {
      this.figure = new Figure(this.parent, {
        title: "Volume by case", file: "sweep-volume", x: title, y: "ln(volume / design space) [1]", labels: numeric ? undefined : labels,
        options: {
          normalized: false,
          interaction: { mode: "nearest", intersect: false, axis: "xy" },
          onClick: (_event, items) => { if (items.length) this.pick(this.data[items[0].datasetIndex][items[0].index].search); },
        },
        axes: {
          x: numeric ? { ticks: { precision: 0 }, grace: "4%" } : { type: "category", offset: true },
          y: { suggestedMax: 0 },
        },
        datasets: () => Object.entries(STATUS).map(([status, [name, style]], i) => ({
          label: words(status), data: this.data[i], showLine: false, pointRadius: 4, pointStyle: style,
          borderColor: colour(name), backgroundColor: faded(colour(name), 0.3), pointBackgroundColor: colour(name), borderWidth: 2,
        })),
        tooltip: {
          callbacks: {
            title: (items) => items.length ? `search ${items[0].raw.search} ${items[0].raw.name || ""}` : "",
            label: (item) => `${item.dataset.label}: ln(volume) ${item.raw.y.toFixed(2)}`,
          },
        },
        describe: () => Object.keys(STATUS).map((status, i) => `${this.data[i].length} ${words(status)}`).join(", ") + ".",
        table: () => ({
          head: ["search", "case", title, "status", "log_volume"],
          rows: Object.keys(STATUS).flatMap((status, i) => this.data[i].map((p) => [p.search, p.name || null, p.x, status, p.y])).sort((a, b) => a[0] - b[0]),
        }),
      });
    }
  }

  return { Chart, rowsOf, matches, numberOf, brief };
})();
