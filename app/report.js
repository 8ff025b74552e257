/* The report's page: parts as tabs, comparisons in the viewer, figures with their commands. */

const baseName = path => path.split("/").pop();
const imageUrl = path => "images/" + baseName(path).split("").map(c =>
  /[#?%"'() ]/.test(c) ? "%" + c.charCodeAt(0).toString(16) : c).join("");
const runOf = number => DATA.runs[number] || {};
const failed = runs => runs.filter(run => run.error);

/* The commands that made something, with the seconds they took. */
function makeCommands(runs) {
  return make("details", {}, make("summary", {}, `Commands (${runs.length})`),
    make("pre", {}, runs.map(run => run.line).join("\n")),
    make("p", { class: "soft" }, `${runs.reduce((sum, run) => sum + (run.seconds || 0), 0).toFixed(1)} s; ` +
      `gnomon ${DATA.gnomon}, commit ${DATA.commit}, ${DATA.machine.processor}, ` +
      `${DATA.threads} threads, ${DATA.isa}.`));
}
function makeErrors(runs) {
  return failed(runs).map(run => make("p", { class: "error" }, `${run.line}: ${run.error}`));
}

/* Comparisons --------------------------------------------------------------------------------- */

const LAYERS = { class: "classes of leak tracing", rays: "rays", cascade: "cascades",
  lod: "level of detail", lookups: "alpha lookups" };

/* The files beside a rendered picture, by what they show. */
function layersOf(run) {
  const layers = {}, files = (((run.result || {}).frames || [])[0] || {}).files || [];
  for (const file of files.slice(1)) {
    const parts = baseName(file).slice(baseName(files[0]).length - 4).split(".");
    const key = Object.keys(LAYERS).find(name => parts.includes(name));
    if (!key) continue;
    const more = parts.filter(part => part && part !== key && part !== "png");
    layers[LAYERS[key] + (more.length ? ", " + more.join(".") : "")] = imageUrl(file);
  }
  return layers;
}
function pictureOf(name, run, flip) {
  const files = (((run.result || {}).frames || [])[0] || {}).files || [];
  if (!files.length) return null;
  const flipped = ((flip || {}).result || {}).files;
  return { name, url: imageUrl(files[0]),
    layers: { ...(flipped ? { "FLIP map": imageUrl(flipped[0]) } : {}), ...layersOf(run) } };
}
function showComparison(comparison) {
  const methods = comparison.methods.map(m => ({ ...m, made: runOf(m.run), compared: runOf(m.flip) }));
  const pictures = [pictureOf("reference", runOf(comparison.reference.run)),
    ...methods.map(m => pictureOf(m.name, m.made, m.compared))].filter(Boolean);
  const times = ((runOf(comparison.times).result || {}).methods || []);
  const runs = [runOf(comparison.reference.run), ...methods.flatMap(m => [m.made, m.compared]),
    runOf(comparison.times)];
  const number = (m, key) => (m.compared.result || {})[key];
  const bench = m => times.find(t => t.name === m.name) || {};
  return make("div", {},
    ...makeErrors(runs), makeWarning(runs),
    pictures.length > 1 ? makeViewer({ label: `${comparison.scene}, ${comparison.camera}`,
      width: DATA.width, height: DATA.height, pictures, spot: [.4, .7],
      left: "ray-mip0", right: pictures[pictures.length - 1].name }) : null,
    makeTable("Against the reference (16 samples a pixel); milliseconds of the visibility stage", [
      ["method", m => m.name], ["ms", m => fixed(bench(m).ms_median, 1)],
      ["rays a pixel", m => fixed(bench(m).rays_per_pixel, 3)],
      ["FLIP", m => fixed(number(m, "flip_mean"), 4), "Mean of the map"],
      ["SSIM", m => fixed(number(m, "ssim"), 4)], ["PSNR, dB", m => fixed(number(m, "psnr"), 2)],
      ["mean abs", m => fixed(number(m, "mean_abs"), 5)]], methods),
    makeCommands(runs));
}
function makeComparisons() {
  const place = make("div");
  const [label, choice] = makeChoice("Scene and camera",
    DATA.comparisons.map(c => `${c.scene}, ${c.camera}`), 0, show);
  function show() { place.replaceChildren(showComparison(DATA.comparisons[choice.value])); }
  show();
  return [make("p", {}, "Two pictures of the same view: under a divider, in turns, or as a difference. Drag, or use ",
    "the arrow keys; ", make("kbd", {}, "F"), " flips, ", make("kbd", {}, "D"), " shows the difference, ",
    make("kbd", {}, "S"), " the divider, ", make("kbd", {}, "+"), " and ", make("kbd", {}, "−"),
    " zoom. A click, or shift and the arrow keys, moves the frame that is shown four times as large for every method."),
    make("div", { class: "bar" }, label), place];
}

/* Figures ------------------------------------------------------------------------------------- */

/* A part of a picture; crop: left, top, width, height as shares. */
function makeCrop(picture, crop, exposure) {
  const [x, y, w, h] = crop;
  return make("div", { class: "crop", role: "img", "aria-label": `part of ${picture.caption}`, style:
    `aspect-ratio: ${w * DATA.width} / ${h * DATA.height}; background-image: url("${imageUrl(picture.file)}"); ` +
    `background-size: ${100 / w}% ${100 / h}%; ` +
    `background-position: ${w < 1 ? 100 * x / (1 - w) : 0}% ${h < 1 ? 100 * y / (1 - h) : 0}%;` +
    (exposure ? ` filter: brightness(${exposure})` : "") });
}
function captionOf(figure, picture, number, count) {
  const bench = benches(figure, {}).flatMap(r => r.methods).find(m => m.name === picture.method);
  const letter = figure.rows || count < 2 || picture.wide ? "" : `(${String.fromCharCode(97 + number)}) `;
  return letter + picture.caption + (bench && bench.ms_median ? `, ${bench.ms_median.toFixed(1)} ms` : "");
}
function makePicture(figure, picture, i, all) {
  const crops = figure.crops || [];
  const image = make("img", { src: imageUrl(picture.file), alt: picture.caption, loading: "lazy" });
  const frames = i === 0 ? crops.map(([x, y, w, h]) => make("i", { style:
    `left: ${100 * x}%; top: ${100 * y}%; width: ${100 * w}%; height: ${100 * h}%` })) : [];
  return make("figure", { class: picture.wide || picture.profile ? "wide" : null },
    make("a", { class: picture.profile ? "whole profile" : "whole", href: imageUrl(picture.file) }, image,
      ...frames),
    ...crops.map(crop => makeCrop(picture, crop, figure.exposure)),
    make("figcaption", {}, captionOf(figure, picture, i, all.length)));
}
function makePictures(figure) {
  const rows = figure.rows || [], pictures = figure.pictures || [];
  const columns = count => `--columns: ${count > 6 ? Math.ceil(count / 2) : count}`;
  return [
    pictures.length ? make("div", { class: pictures.some(p => p.wide || p.profile)
      ? "pictures row" : "pictures", style: columns(pictures.length) },
      ...pictures.map((p, i) => makePicture(figure, p, i, pictures))) : null,
    ...rows.map(row => make("div", { class: "pictures", style: columns(row.pictures.length) },
      ...row.pictures.map(p => make("figure", {}, makeCrop(p, row.crop),
        make("figcaption", {}, p.caption)))))];
}
/* A button that opens the figure's pictures in the viewer; those of the first one's size. */
function makeOpener(figure) {
  const all = [...(figure.pictures || []), ...(figure.rows || []).flatMap(r => r.pictures)];
  const unique = all.filter((p, i) => all.findIndex(q => q.file === p.file) === i &&
    !p.wide && !p.profile);
  if (unique.length < 2) return null;
  const place = make("div");
  const button = makeButton("Compare these pictures", "Opens the viewer below", async () => {
    if (place.firstChild) { place.replaceChildren(); return; }
    const loaded = await Promise.all(unique.map(p => new Promise(done => {
      const image = new Image();
      image.onload = image.onerror = () => done({ ...p, width: image.naturalWidth,
        height: image.naturalHeight });
      image.src = imageUrl(p.file);
    })));
    const { width, height } = loaded[0];
    const pictures = loaded.filter(p => p.width === width && p.height === height)
      .map(p => ({ name: (p.caption.length < 5 ? baseName(p.file) : p.caption), url: imageUrl(p.file) }));
    place.replaceChildren(makeViewer({ label: figure.title, width, height, pictures, spot: [.5, .6],
      left: pictures[0].name, right: pictures[1].name }));
  });
  return make("div", {}, button, place);
}
function makeFigure(figure) {
  const runs = figure.runs.map(runOf);
  const plots = (figure.plots || []).flatMap(plot => PLOTS[plot.kind](figure, plot)).filter(Boolean);
  const tables = (figure.tables || []).map(table => TABLES[table.kind](figure, table)).filter(Boolean);
  return make("article", { id: figure.id + "-" + figure.scene.replace(/\W/g, "-") },
    make("h3", {}, `${figure.number}: ${figure.title}`, make("span", { class: "soft" },
      figure.id === "moment3" ? "" : ` · ${figure.scene}`)),
    make("p", {}, figure.text), ...makeErrors(runs), makeWarning(runs), ...makePictures(figure), makeOpener(figure),
    plots.length ? makeLegend(plots) : null,
    plots.length ? make("div", { class: "plots" }, ...plots.map(plot => plot.node)) : null,
    ...tables, makeCommands(runs));
}
const isSequence = figure => figure.id === "sequence";
function makePaper(paper) {
  const figures = DATA.figures.filter(f => f.paper === paper && !isSequence(f));
  const place = f => (f.number.startsWith("Table") ? 100 : 0) + Number(f.number.match(/\d+/)[0]);
  figures.sort((a, b) => place(a) - place(b));
  const note = paper !== "leak" ? null
    : make("p", { class: "soft" }, "Figure 7 and Table 2 are in the part on sequences.");
  return [make("p", { class: "paper" }, DATA.papers[paper]), note, ...figures.map(makeFigure)];
}
function makeSequences() {
  const figures = DATA.figures.filter(isSequence), place = make("div");
  const [label, choice] = makeChoice("Scene", figures.map(f => f.scene), 0, show);
  function show() { place.replaceChildren(makeFigure(figures[choice.value])); }
  show();
  return [speedupTable("Leak tracing, Table 2: how many times as fast as rays, over the frames of a sequence",
    figures.flatMap(f => benches(f, {})), r => r.scene),
    make("p", { class: "soft" }, "Frame: the G-buffer and visibility, in place of the paper's scene with shading; visibility: its stage alone."),
    make("div", { class: "bar" }, label), place];
}
function makeAbout() {
  const machine = DATA.machine;
  const seconds = DATA.runs.reduce((sum, run) => sum + (run.seconds || 0), 0);
  return [make("pre", {}, DATA.command_line),
    makeWarning(DATA.runs),
    makeTable("Where and when", [["", r => r[0]], ["", r => make("td", { class: "text" }, String(r[1]))]], [
      ["gnomon", `${DATA.gnomon}, commit ${DATA.commit}`], ["processor", machine.processor],
      ["cores", machine.cores], ["memory, GB", fixed(machine.memory_gb, 1)],
      ["system", machine.system], ["threads", DATA.threads], ["instruction set", DATA.isa],
      ["commands", `${DATA.runs.length}, ${seconds.toFixed(0)} s`]]),
    make("p", {}, "Every picture, plot and table names the commands that made it. Times are of this machine, one run each unless a command says otherwise: compare them with each other, not with the papers'."),
    ...makeErrors(DATA.runs), makeCommands(DATA.runs)];
}

/* Parts --------------------------------------------------------------------------------------- */

const PARTS = [["comparisons", "Comparisons", makeComparisons, DATA.comparisons.length],
  ["sequences", "Sequences", makeSequences, DATA.figures.some(isSequence)],
  ...["ray", "leak", "moment"].map((paper, i) => [paper, ["Ray cones", "Leak tracing", "Moments"][i],
    () => makePaper(paper), DATA.figures.some(f => f.paper === paper && !isSequence(f))]),
  ["about", "About", makeAbout, true]].filter(part => part[3]);

/* Panels are filled when they are first shown: plots need their size. */
function showPart(id) {
  for (const [name, , fill] of PARTS) {
    const tab = document.getElementById("tab-" + name), panel = document.getElementById("part-" + name);
    const chosen = name === id;
    tab.setAttribute("aria-selected", chosen);
    tab.tabIndex = chosen ? 0 : -1;
    panel.hidden = !chosen;
    if (chosen && !panel.firstChild) panel.append(...fill().filter(Boolean));
  }
}
function start() {
  document.getElementById("facts").textContent = `gnomon ${DATA.gnomon}, commit ${DATA.commit}; ` +
    `${DATA.machine.processor}, ${DATA.threads} threads, ${DATA.isa}; ${DATA.width} x ${DATA.height}, ` +
    `sequences of ${DATA.frames} frames.`;
  const tabs = document.getElementById("tabs"), main = document.getElementById("main");
  for (const [name, title] of PARTS) {
    const tab = make("button", { type: "button", role: "tab", id: "tab-" + name,
      "aria-controls": "part-" + name },
      title);
    tab.addEventListener("click", () => { location.hash = name; });
    tabs.append(tab);
    main.append(make("section", { id: "part-" + name, role: "tabpanel", "aria-labelledby": "tab-" + name }));
  }
  tabs.addEventListener("keydown", event => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const at = PARTS.findIndex(part => "tab-" + part[0] === document.activeElement.id);
    const next = PARTS[(at + step + PARTS.length) % PARTS.length][0];
    location.hash = next;
    document.getElementById("tab-" + next).focus();
    event.preventDefault();
  });
  const follow = () => {
    const wanted = location.hash.slice(1);
    showPart(PARTS.some(part => part[0] === wanted) ? wanted : PARTS[0][0]);
  };
  addEventListener("hashchange", follow);
  follow();
}
start();
