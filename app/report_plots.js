/* Plots and tables of the report, made of what the commands printed. */

const PALETTE = ["#3572b0", "#d1495b", "#2e9b62", "#c98a12", "#8e5bc0", "#17909c", "#b5502a",
  "#6b7d2f", "#d06aa8", "#7a7a7a", "#4454d0", "#99651a", "#108a4a"];
const SPACING = [[], [6, 3], [2, 2], [10, 3, 2, 3]];
const charts = new Set();

/* The same line for the same name everywhere. */
const known = [];
function lineOf(name) {
  if (!known.includes(name)) known.push(name);
  const i = known.indexOf(name);
  return { color: PALETTE[i % PALETTE.length], dash: SPACING[Math.floor(i / PALETTE.length) % 4] };
}
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
function dress(chart) {
  for (const axis of Object.values(chart.options.scales)) {
    axis.grid.color = css("--line");
    axis.ticks.color = axis.title.color = css("--soft");
  }
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  for (const chart of charts) { dress(chart); chart.update(); }
});

function axis(text, more) {
  return { grid: {}, ticks: { maxRotation: 0, autoSkipPadding: 12 },
    title: { display: Boolean(text), text }, ...more };
}
/* lines: name, points ([x, y]). */
function drawPlot(title, lines, { type = "line", x, y, logarithmic, linearX = true, labels, max }) {
  const canvas = make("canvas", { role: "img", "aria-label": title });
  const node = make("figure", { class: "plot" }, make("figcaption", {}, title),
    make("div", { class: "canvas" }, canvas));
  const datasets = lines.map(line => {
    const style = lineOf(line.name);
    return { label: line.name, data: line.points.map(([px, py]) => ({ x: px, y: py })),
      borderColor: style.color, backgroundColor: style.color, borderDash: style.dash,
      borderWidth: type === "line" ? 2 : 0, pointRadius: line.points.length > 12 ? 0 : 3,
      pointHitRadius: 8, categoryPercentage: 1, barPercentage: .95, spanGaps: true };
  });
  const chart = new Chart(canvas, { type, data: { labels, datasets },
    options: { animation: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", axis: "x", intersect: false },
      plugins: { legend: { display: false } },
      scales: { x: axis(x, linearX ? { type: "linear", bounds: "data" } : {}),
        y: axis(y, logarithmic ? { type: "logarithmic" } : { beginAtZero: true, max }) } } });
  charts.add(chart);
  dress(chart);
  chart.update();
  return { node, chart };
}
/* Buttons that take lines out of several plots. */
function makeLegend(plots) {
  const names = [...new Set(plots.flatMap(p => p.chart.data.datasets.map(d => d.label)))];
  if (plots.every(p => p.chart.data.datasets.length < 2)) return null;
  return make("div", { class: "legend", role: "group", "aria-label": "Lines that are shown" },
    ...names.map(name => {
      const style = lineOf(name);
      const button = make("button", { type: "button", "aria-pressed": true },
        make("i", { style: `border-top-color: ${style.color}; border-top-style: ` +
          (style.dash.length ? "dashed" : "solid") }), name);
      button.addEventListener("click", () => {
        const shown = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", shown);
        for (const { chart } of plots)
          chart.data.datasets.forEach((d, i) => {
            if (d.label === name) chart.setDatasetVisibility(i, shown);
          });
        for (const { chart } of plots) chart.update();
      });
      return button;
    }));
}

/* Runs of a figure that have results. numbers: of its runs; none: all of them. */
function resultsOf(figure, numbers) {
  return (numbers || figure.runs.map((_, i) => i))
    .map(i => (DATA.runs[figure.runs[i]] || {}).result).filter(Boolean);
}
const numbersOf = what => what.runs || (what.run == null ? undefined : [what.run]);
/* Results of bench; those of a sweep one by one. */
const benchRuns = result => result.command !== "bench" ? []
  : result.runs ? result.runs.map(run => ({ ...result, ...run })) : [result];
const benches = (figure, what) => resultsOf(figure, numbersOf(what)).flatMap(benchRuns)
  .filter(r => r.methods);
const range = count => Array.from({ length: count }, (_, i) => i);
const mean = list => list.reduce((a, b) => a + b, 0) / list.length;

const PLOTS = {
  /* A number a frame. */
  series(figure, plot) {
    const results = benches(figure, plot), lines = [];
    for (const result of results)
      for (const m of result.methods) {
        const values = (m.series || {})[plot.value];
        if (!values || (plot.methods && !plot.methods.includes(m.name))) continue;
        const points = values.map((v, i) => [i, v == null ? null : v * (plot.factor || 1)])
          .map(([i, v]) => [i, plot.logarithmic && !(v > 0) ? null : v]);
        if (points.every(([, v]) => !v)) continue; /* nothing of the kind */
        lines.push({ name: results.length > 1 ? `${m.name}, ${result.height}` : m.name, points });
      }
    return lines.length ? drawPlot(plot.title, lines, { x: "frame", logarithmic: plot.logarithmic })
      : null;
  },
  /* Milliseconds over the values of a sweep. */
  sweep(figure, plot) {
    const results = benches(figure, plot), lines = new Map();
    const sizes = results.length > 0 && results[0].sweep === "size";
    for (const result of results)
      for (const m of result.methods) {
        if (!m.map) continue; /* the yardstick */
        if (!lines.has(m.name)) lines.set(m.name, []);
        lines.get(m.name).push([sizes ? result.width * result.height / 1e6 : Number(result.value),
          m.ms_median]);
      }
    return lines.size ? drawPlot(plot.title, [...lines].map(([name, points]) => ({ name, points })),
      { x: sizes ? "million pixels" : "texels a side", y: "ms" }) : null;
  },
  bounds(figure, plot) {
    const [result] = resultsOf(figure);
    return result && drawPlot(plot.title, result.bounds.map(b => ({ name: "xi4 = " + b.xi4,
      points: result.z.map((z, i) => [z, b.shadow[i]]) })), { x: "z", y: "shadow", max: 1 });
  },
  /* One plot for each filter, side by side. */
  histogram(figure, plot) {
    const [result] = resultsOf(figure);
    if (!result) return null;
    return result.histograms.map(h => {
      const counts = h[plot.value], bins = counts.length;
      const low = plot.value === "log10" ? result.log10_min : 0;
      const high = plot.value === "log10" ? result.log10_max : 1;
      const labels = range(bins).map(i => (low + (high - low) * (i + .5) / bins).toFixed(2));
      const name = h.sigma > 0 ? `sigma ${h.sigma}` : "not filtered";
      const most = Math.max(...counts.slice(1)) / h.texels * 100;
      return drawPlot(`${plot.title}, ${name}`, [{ name, points: counts.map((c, i) =>
        [labels[i], c / h.texels * 100]) }], { type: "bar", linearX: false, labels, y: "% of texels",
        max: most > 0 ? most * 1.05 : undefined });
    });
  },
};

/* A line where other programs took more than a little of the processors' time. */
function makeWarning(runs) {
  const loads = runs.flatMap(run => benchRuns(run.result || {})).filter(r => r.busy)
    .map(r => r.other_load);
  return loads.length ? make("p", { class: "error" }, "The machine was busy with other things (" +
    `${Math.round(100 * Math.max(...loads))} % of its processors): times are too long, and noisy.`) : null;
}

/* columns: [heading, function of a row, explanation]. */
function makeTable(title, columns, rows) {
  if (!rows.length) return null;
  const cell = (tag, value) => value instanceof Node ? value
    : make(tag, tag === "th" ? { scope: "col" } : {}, value == null ? "–" : String(value));
  return make("div", {}, make("p", { class: "caption" }, title),
    make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": title }, make("table", {},
      make("thead", {}, make("tr", {}, ...columns.map(c => make("th", { scope: "col", title: c[2] },
        c[0])))),
      make("tbody", {}, ...rows.map(row => make("tr", {}, ...columns.map(c => cell("td", c[1](row)))))))));
}
const percent = (value, count) => value == null ? "–" : (100 * value).toFixed(count);
const thousandths = value => value == null ? "–" : (1000 * value).toFixed(3);

/* How many times as fast as its yardstick, frame by frame; extra: milliseconds added to both. */
function speedupsOf(result, name, extra) {
  const method = result.methods.find(m => m.name === name);
  const yardstick = method && result.methods.find(m => m.name === method.yardstick);
  if (!yardstick || yardstick === method || !method.series) return null;
  const ratios = method.series.ms.map((ms, i) => (yardstick.series.ms[i] + extra) / (ms + extra));
  return { mean: mean(ratios), min: Math.min(...ratios), max: Math.max(...ratios) };
}
function speedupTable(title, results, label) {
  const rows = results.flatMap(result => result.methods
    .filter(m => m.name.startsWith("lt-")).map(m => {
      const gbuffer = m.passes ? m.passes.gbuffer.ms_median : 0;
      const alone = speedupsOf(result, m.name, 0);
      return alone && { place: label(result), name: m.name, alone,
        frame: speedupsOf(result, m.name, gbuffer) };
    }).filter(Boolean));
  const part = (key, what) => row => fixed(row[key][what], 2);
  return makeTable(title, [["", r => r.place], ["method", r => r.name],
    ["frame: mean", part("frame", "mean"), "G-buffer and visibility"], ["min", part("frame", "min")],
    ["max", part("frame", "max")], ["visibility: mean", part("alone", "mean")],
    ["min", part("alone", "min")], ["max", part("alone", "max")]], rows);
}

const TABLES = {
  methods(figure, table) {
    const [result] = benches(figure, table);
    if (!result) return null;
    const moves = result.methods.some(m => m.flicker > 0);
    return makeTable(`${result.scene}, ${result.camera}, ${result.width} x ${result.height}`, [
      ["method", m => m.name], ["ms", m => fixed(m.ms_median, 1), "Median over the frames"],
      ["min", m => fixed(m.ms_min, 1)], ["max", m => fixed(m.ms_max, 1)],
      ["maps, ms", m => m.map ? fixed(m.passes.shadow_map.ms_mean + m.passes.filter.ms_mean, 2) : "–",
        "Drawing and filtering, mean"],
      ["rays a pixel", m => fixed(m.rays_per_pixel, 3)],
      ["wrong, %", m => percent(m.wrong_pixels, 3), "Against its yardstick"],
      ["against", m => m.yardstick],
      ["speed-up", m => m.yardstick === m.name ? "–" : fixed(m.speedup_mean, 2), "Of its yardstick, mean"],
      ...(moves ? [["flicker, 1/1000", m => thousandths(m.flicker)],
        ["toggles, 1/1000", m => thousandths(m.toggles)]] : [])], result.methods.filter(m => m.ms_median != null));
  },
  rays(figure) {
    const [result] = benches(figure, {});
    const rows = result ? result.methods.filter(m => m.name.startsWith("ray-") && m.ms_median) : [];
    const base = rows.find(m => m.name === "ray-mip0");
    return makeTable("Milliseconds of the visibility stage", [["method", m => m.name],
      ["ms", m => fixed(m.ms_median, 1)], ["min", m => fixed(m.ms_min, 1)],
      ["max", m => fixed(m.ms_max, 1)],
      ["of ray-mip0", m => base ? fixed(m.ms_median / base.ms_median, 2) : "–"],
      ["million rays/s", m => fixed(m.rays_per_second / 1e6, 2)]], rows);
  },
  mips(figure) {
    const [result] = resultsOf(figure);
    return result && makeTable(`${result.material}: texels that pass, %`, [
      ["mip", l => result.levels.indexOf(l)], ["texels", l => `${l.width} x ${l.height}`],
      ["averaged", l => percent(l.averaged, 2)], ["rescaled", l => percent(l.rescaled, 2)]],
      result.levels);
  },
  classes() {
    const rows = [["#000000", "black", 0, 0, "", "surely lit"], ["#28a03c", "green", 0, 1, "", "surely in shadow"],
      ["#e62828", "red", 1, 0, 0, "the ray agreed: lit"], ["#ffffff", "white", 1, 1, 1, "the ray agreed: shadow"],
      ["#a03cc8", "purple", 1, 0, 1, "the ray corrected a lit test"],
      ["#f5d728", "yellow", 1, 1, 0, "the ray corrected a test in shadow"]];
    return makeTable("Classes of the mask (Table 1)", [
      ["class", r => make("td", { class: "swatch" }, make("i", { style: "background: " + r[0] }), r[1])],
      ["ray traced", r => r[2]], ["shadow by the test", r => r[3]], ["shadow by the ray", r => r[4] === "" ? "–" : r[4]],
      ["", r => make("td", { class: "text" }, r[5])]], rows);
  },
  leaks(figure) {
    const rows = benches(figure, {}).flatMap(r => r.methods.filter(m => m.leak));
    return makeTable("Shares of the pixels that the map was asked about, %", [["method", m => m.name],
      ["unsure", m => percent(m.leak.unsure, 2)], ["added", m => percent(m.leak.expanded, 2)],
      ["taken away", m => percent(m.leak.removed, 2)],
      ["not seen before", m => percent(m.leak.lost, 2)], ["wrong", m => percent(m.wrong_pixels, 4)]], rows);
  },
  times(figure, table) {
    const rows = benches(figure, table).flatMap(r => r.methods.filter(m => m.series));
    const unique = rows.filter((m, i) => rows.findLastIndex(n => n.name === m.name) === i);
    return makeTable("Milliseconds a frame", [["method", m => m.name],
      ["mean", m => fixed(mean(m.series.ms), 1)], ["min", m => fixed(Math.min(...m.series.ms), 1)],
      ["max", m => fixed(Math.max(...m.series.ms), 1)],
      ["of it maps", m => fixed(mean(m.series.map_ms), 1)],
      ["rays a frame", m => Math.round(mean(m.series.rays)).toLocaleString("en")],
      ["wrong, %", m => percent(m.wrong_pixels, 3)]], unique);
  },
  speedups(figure, table) {
    return speedupTable("How many times as fast as rays", benches(figure, table),
      r => `${r.width} x ${r.height}`);
  },
  histogram(figure) {
    const [result] = resultsOf(figure);
    return result && makeTable("Texels", [["sigma", h => h.sigma], ["filter", h => `${h.filter_width} x ${h.filter_width}`],
      ["below 1e-6, %", h => percent(h.below_1e_6, 2)], ["above 6e-5, %", h => percent(h.above_6e_5, 2)]],
      result.histograms);
  },
};
