// Charts: one class around Chart.js that adds what every chart of the page has: a title with units,
// a legend whose lines differ in more than colour, a description for screen readers, its values as a
// table, and downloads as SVG, PNG and CSV.
"use strict";

const Figures = (() => {
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const all = new Set();

  // An element: h("td", {class: "text"}, "words", child).
  function h(name, attributes, ...children) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes || {})) {
      if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (value === true) element.setAttribute(key, "");
      else if (value !== false && value != null) element.setAttribute(key, value);
    }
    element.append(...children.filter((child) => child != null));
    return element;
  }

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  function faded(hex, alpha) {
    return hex + Math.round(alpha * 255).toString(16).padStart(2, "0");
  }

  function save(name, type, content) {
    const url = content instanceof Blob ? URL.createObjectURL(content)
      : URL.createObjectURL(new Blob([content], { type }));
    h("a", { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
  }

  const escape = (text) => String(text).replace(/[&<>"]/g, (c) =>
    ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

  // A value for a table: a cell that a spreadsheet would take for a formula is made text.
  function cell(value) {
    if (value == null) return "";
    const text = typeof value === "number" ? String(+value.toPrecision(7)) : String(value);
    const safe = typeof value === "string" && /^[=+\-@\t\r]/.test(text) ? "'" + text : text;
    return /[",\n]/.test(safe) ? '"' + safe.replace(/"/g, '""') + '"' : safe;
  }

  // Marks the spans that a figure names, phases for instance, behind its lines.
  const bands = {
    id: "bands",
    beforeDatasetsDraw(chart) {
      const { ctx, chartArea: area } = chart;
      ctx.save();
      for (const band of bandsOf(chart)) {
        ctx.fillStyle = band.colour;
        ctx.fillRect(band.left, area.top, band.right - band.left, area.bottom - area.top);
        if (band.right - band.left < 34) continue;
        ctx.fillStyle = colour("soft");
        ctx.font = "11px system-ui, sans-serif";
        ctx.textBaseline = "top";
        ctx.fillText(band.label, band.left + 4, area.top + 3, band.right - band.left - 6);
      }
      ctx.restore();
    },
  };

  function bandsOf(chart) {
    const spans = chart.$bands || [];
    const scale = chart.scales.x;
    return spans.map((span, i) => ({
      label: span.label,
      colour: colour(i % 2 ? "phase-b" : "phase-a"),
      left: Math.max(scale.getPixelForValue(span.from), chart.chartArea.left),
      right: Math.min(scale.getPixelForValue(span.to), chart.chartArea.right),
    })).filter((band) => band.right > band.left);
  }

  // The picture as Chart.js has laid it out, written as SVG. Chart.js itself only paints pixels.
  function svgOf(chart, title) {
    chart.update("none"); // not in the middle of a movement
    const { width, height, chartArea: area, scales } = chart;
    const ink = colour("ink"), soft = colour("soft"), line = colour("line");
    const out = [];
    const n = (value) => +value.toFixed(2);
    const text = (x, y, words, more = "") =>
      out.push(`<text x="${n(x)}" y="${n(y)}" ${more}>${escape(words)}</text>`);
    out.push(`<rect width="${n(width)}" height="${n(height + 24)}" fill="${colour("card")}"/>`,
      '<g transform="translate(0 24)">');
    text(8, -8, title, `font-size="14" font-weight="600" fill="${ink}"`);
    for (const band of bandsOf(chart)) {
      out.push(`<rect x="${n(band.left)}" y="${n(area.top)}" width="${n(band.right - band.left)}" ` +
        `height="${n(area.bottom - area.top)}" fill="${band.colour.slice(0, 7)}" fill-opacity="0.08"/>`);
      text(band.left + 4, area.top + 12, band.label, `fill="${soft}"`);
    }
    for (const scale of Object.values(scales)) {
      scale.ticks.forEach((tick, i) => {
        const at = scale.getPixelForTick(i);
        if (scale.isHorizontal()) {
          out.push(`<path d="M${n(at)} ${n(area.top)}V${n(area.bottom)}" stroke="${line}"/>`);
          text(at, area.bottom + 15, tick.label, `text-anchor="middle" fill="${soft}"`);
        } else {
          out.push(`<path d="M${n(area.left)} ${n(at)}H${n(area.right)}" stroke="${line}"/>`);
          text(area.left - 6, at + 4, tick.label, `text-anchor="end" fill="${soft}"`);
        }
      });
      const name = scale.options.title.text;
      if (scale.isHorizontal())
        text((area.left + area.right) / 2, height - 4, name, `text-anchor="middle" fill="${soft}"`);
      else
        text(0, 0, name, `text-anchor="middle" fill="${soft}" transform="translate(12 ` +
          `${n((area.top + area.bottom) / 2)}) rotate(-90)"`);
    }
    // Where a value is missing, the line is broken.
    const path = (points) => points.map((p, i) => p.skip ? "" :
      `${i === 0 || points[i - 1].skip ? "M" : "L"}${n(p.x)} ${n(p.y)}`).join("");
    chart.data.datasets.forEach((data, i) => {
      const points = chart.getDatasetMeta(i).data;
      if (points.length === 0) return;
      if (points[0].base !== undefined && points[0].height !== undefined) {
        for (const bar of points) {
          const left = Math.min(bar.x, bar.base);
          out.push(`<rect x="${n(left)}" y="${n(bar.y - bar.height / 2)}" ` +
            `width="${n(Math.abs(bar.x - bar.base))}" height="${n(bar.height)}" ` +
            `fill="${data.borderColor}" fill-opacity="${data.$opacity ?? 0.5}"/>`);
        }
        return;
      }
      const shown = points.filter((p) => !p.skip);
      if (data.fill === "-1") {
        const below = chart.getDatasetMeta(i - 1).data.filter((p) => !p.skip);
        out.push(`<path d="${path(shown)}${path([...below].reverse()).replace("M", "L")}Z" ` +
          `fill="${data.borderColor}" fill-opacity="${data.$opacity ?? 0.3}"/>`);
      }
      if (data.showLine !== false)
        out.push(`<path d="${path(points)}" fill="none" stroke="${data.borderColor}" ` +
          `stroke-width="${data.borderWidth}" stroke-dasharray="${(data.borderDash || []).join(" ")}"/>`);
      if (data.pointRadius > 0)
        for (const p of shown)
          out.push(data.pointStyle && data.pointStyle !== "circle"
            ? `<path transform="translate(${n(p.x - 12)} ${n(p.y - 6)})" d="${SHAPES[data.pointStyle] || SHAPES.circle}" fill="${data.borderColor}"/>`
            : `<circle cx="${n(p.x)}" cy="${n(p.y)}" r="${data.pointRadius}" fill="${data.borderColor}"/>`);
    });
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${n(width)}" height="${n(height + 24)}" ` +
      `viewBox="0 0 ${n(width)} ${n(height + 24)}" font-family="sans-serif" font-size="11">` +
      `<title>${escape(title)}</title>${out.join("")}</g></svg>\n`;
  }

  // A line of the legend as it looks in the chart.
  function sample(data) {
    const box = data.fill === "-1" || data.$bar;
    const dash = (data.borderDash || []).join(" ");
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const shape = document.createElementNS(svg.namespaceURI, box ? "rect" : "path");
    const set = (values) => Object.entries(values).forEach(([k, v]) => shape.setAttribute(k, v));
    svg.setAttribute("viewBox", "0 0 24 12");
    svg.setAttribute("aria-hidden", "true");
    if (data.showLine === false) set({ d: SHAPES[data.pointStyle] || SHAPES.circle, fill: data.borderColor });
    else if (box) set({ x: 1, y: 1, width: 22, height: 10, fill: data.borderColor, "fill-opacity": data.$opacity ?? 0.3, stroke: data.borderColor, "stroke-dasharray": dash });
    else set({ d: "M0 6H24", stroke: data.borderColor, "stroke-width": 2.5, "stroke-dasharray": dash });
    svg.append(shape);
    return svg;
  }
  const SHAPES = {
    circle: "M12 2a4 4 0 1 1-.01 0z", triangle: "M12 1l5 9H7z", rect: "M8 2h8v8H8z",
    crossRot: "M8 1l4 4 4-4 1 1-4 4 4 4-1 1-4-4-4 4-1-1 4-4-4-4z", rectRot: "M12 1l5 5-5 5-5-5z",
    star: "M11.3 1h1.4v3.6l2.8-2.3 1 1L14 6l2.5 2.7-1 1-2.8-2.3V11h-1.4V7.4L8.500 9.7l-1-1L10 6 7.500 3.300l1-1 2.800 2.300z",
  };

  class Figure {
    // spec: {title, file, x, y: axis titles, datasets(): with borderColor etc., describe(): text,
    // table(): {head, rows}, options: of Chart.js}
    constructor(parent, spec) {
      this.spec = spec;
      this.shown = false;
      this.canvas = h("canvas", { role: "img", tabindex: "0" });
      this.frame = h("div", { class: "canvas" }, this.canvas);
      this.values = h("div", { class: "values", tabindex: "0", hidden: true });
      this.legend = h("div", { class: "legend" });
      this.toggle = h("button", { type: "button", class: "quiet", "aria-pressed": "false", onclick: () => this.showTable() }, "Table");
      const button = (name, action) =>
        h("button", { type: "button", class: "quiet", "aria-label": `${name} of ${spec.title}`, onclick: action }, name);
      this.element = h("figure", { class: spec.wide ? "wide" : null },
        h("figcaption", {}, h("h3", {}, spec.title), this.toggle,
          button("SVG", () => save(spec.file + ".svg", "image/svg+xml", svgOf(this.chart, spec.title))),
          button("PNG", () => this.savePng()),
          button("CSV", () => save(spec.file + ".csv", "text/csv", this.csv()))),
        this.frame, this.values, this.legend);
      parent.append(this.element);
      if (spec.height) this.frame.style.height = spec.height;
      this.chart = new Chart(this.canvas, {
        type: spec.type || "line",
        data: { labels: spec.labels, datasets: spec.datasets() },
        options: this.options(),
        plugins: [bands],
      });
      this.drawLegend();
      all.add(this);
      this.refresh();
    }

    options() {
      const axis = (title, { ticks, ...more } = {}) => ({
        type: "linear",
        title: { display: true, text: title, color: colour("soft") },
        ticks: { color: colour("soft"), maxRotation: 0, autoSkipPadding: 14, ...ticks },
        grid: { color: colour("line"), drawTicks: false },
        border: { display: false },
        ...more,
      });
      const { x, y, axes = {}, options = {} } = this.spec;
      return {
        animation: this.spec.lively && !calm.matches ? { duration: 160 } : false,
        maintainAspectRatio: false,
        normalized: true,
        interaction: { mode: "index", intersect: false, axis: "x" },
        elements: { point: { radius: 0, hitRadius: 8, hoverRadius: 4 }, line: { tension: 0 } },
        ...options,
        scales: { x: axis(x, axes.x), y: axis(y, axes.y) },
        plugins: { legend: { display: false }, tooltip: { filter: (item) => !item.dataset.$mute, ...this.spec.tooltip }, ...options.plugins },
      };
    }

    setTitle(title) {
      if (this.spec.title === title) return;
      this.spec.title = title;
      this.element.querySelector("h3").textContent = title;
    }

    // Only what there is to see has a line in the legend.
    setLegend(shown) {
      const labels = this.chart.data.datasets.filter(shown).map((data) => data.label).join("\n");
      this.inLegend = shown;
      if (this.legendLabels !== labels) this.drawLegend();
      this.legendLabels = labels;
    }

    drawLegend() {
      this.legend.replaceChildren(...this.chart.data.datasets.filter((data) => data.label && !data.$mute && (!this.inLegend || this.inLegend(data)))
        .map((data) => h("span", {}, sample(data), data.label)));
    }

    // New values are in the datasets' arrays: draw them.
    update() {
      this.refresh();
      this.chart.update();
    }

    // What stands beside the picture.
    refresh() {
      this.canvas.setAttribute("aria-label", this.spec.title + ". " + this.spec.describe());
      if (this.shown) this.fillTable();
    }

    // Colours follow the theme.
    repaint() {
      this.spec.datasets().forEach((data, i) => {
        const own = this.chart.data.datasets[i];
        own.borderColor = data.borderColor;
        own.backgroundColor = data.backgroundColor;
        own.pointBackgroundColor = data.pointBackgroundColor;
        own.pointBorderColor = data.pointBorderColor;
      });
      this.chart.options = this.options();
      this.chart.update("none");
      this.drawLegend();
    }

    showTable() {
      this.shown = !this.shown;
      this.toggle.setAttribute("aria-pressed", this.shown);
      this.frame.hidden = this.shown;
      this.values.hidden = !this.shown;
      if (this.shown) this.fillTable();
      else this.chart.resize();
    }

    fillTable() {
      const { head, rows } = this.spec.table();
      const show = (value) => typeof value === "number" ? String(+value.toPrecision(5)) : value ?? "–";
      this.values.replaceChildren(h("table", {},
        h("thead", {}, h("tr", {}, ...head.map((name) => h("th", { scope: "col" }, name)))),
        h("tbody", {}, ...rows.slice(-400).map((row) => h("tr", {}, ...row.map((value) => h("td", {}, show(value))))))));
    }

    csv() {
      const { head, rows } = this.spec.table();
      return [head, ...rows].map((row) => row.map(cell).join(",")).join("\n") + "\n";
    }

    savePng() {
      // Painted on paper: a transparent picture is unreadable on half of all grounds.
      const paper = document.createElement("canvas");
      paper.width = this.canvas.width;
      paper.height = this.canvas.height;
      const context = paper.getContext("2d");
      this.chart.update("none");
      context.fillStyle = colour("card");
      context.fillRect(0, 0, paper.width, paper.height);
      context.drawImage(this.canvas, 0, 0);
      paper.toBlob((blob) => save(this.spec.file + ".png", "image/png", blob));
    }

    remove() {
      all.delete(this);
      this.chart.destroy();
      this.element.remove();
    }
  }

  const repaint = () => all.forEach((figure) => figure.repaint());

  return { Figure, h, colour, faded, repaint, all };
})();
