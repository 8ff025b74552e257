/* Opens a report in headless Chromium and does what a reader does. Talks to the browser through two
 * pipes (its DevTools protocol), so that nothing but Node is needed. Says what does not hold. */
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const page = pathToFileURL(resolve(process.argv[2])).href;
const profile = mkdtempSync(join(tmpdir(), "gnomon-browser-"));
const browser = spawn("chromium", ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
  "--remote-debugging-pipe", "--user-data-dir=" + profile],
{ stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
const [, , , input, output] = browser.stdio;
const waiting = new Map(), listeners = [];
let last = 0, session, rest = Buffer.alloc(0), failures = 0;

output.on("data", bytes => {
  rest = Buffer.concat([rest, bytes]);
  for (let end; (end = rest.indexOf(0)) >= 0; rest = rest.subarray(end + 1)) {
    const message = JSON.parse(rest.subarray(0, end).toString());
    if (message.id) {
      const { done, fail } = waiting.get(message.id);
      waiting.delete(message.id);
      if (message.error) fail(new Error(message.error.message)); else done(message.result);
    } else for (const listener of listeners) listener(message);
  }
});
function send(method, params = {}) {
  return new Promise((done, fail) => {
    waiting.set(++last, { done, fail });
    input.write(JSON.stringify({ id: last, method, params, sessionId: session }) + "\0");
  });
}
function check(holds, text) {
  if (!holds) { failures++; console.error("does not hold: " + text); }
}
/* The value of an expression in the page. */
async function ask(expression) {
  const { result, exceptionDetails } = await send("Runtime.evaluate",
    { expression, returnByValue: true, awaitPromise: true });
  if (exceptionDetails) throw new Error(expression + ": " + exceptionDetails.exception.description);
  return result.value;
}
async function press(key, modifiers = 0) {
  const text = key.length === 1 ? key : undefined;
  await send("Input.dispatchKeyEvent", { type: "keyDown", key, text, modifiers });
  await send("Input.dispatchKeyEvent", { type: "keyUp", key, modifiers });
}
async function drag(from, to) {
  const move = (type, [x, y]) => send("Input.dispatchMouseEvent",
    { type, x, y, button: "left", buttons: 1, clickCount: 1 });
  await move("mousePressed", from);
  await move("mouseMoved", [(from[0] + to[0]) / 2, to[1]]);
  await move("mouseMoved", to);
  await move("mouseReleased", to);
}
const rest2 = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))";
const split = () => ask("Number(document.querySelector('.viewer').getAttribute('aria-valuenow'))");
const pressed = mode => ask(`document.querySelector('[data-mode="${mode}"]').getAttribute('aria-pressed')`);

async function tryViewer(width) {
  const at = `${width} pixels wide: `;
  await ask("document.querySelector('.viewer').scrollIntoView({ block: 'center' })");
  const box = await ask("(b => [b.left, b.top, b.width, b.height])(document.querySelector('.viewer').getBoundingClientRect())");
  check(box[2] > 0.8 * (width - 32), at + "the viewer is as wide as the page, " + box[2]);
  await drag([box[0] + box[2] / 2, box[1] + box[3] / 2], [box[0] + box[2] / 4, box[1] + box[3] / 2]);
  check(Math.abs(await split() - 25) <= 2, at + "the divider follows the mouse, to " + await split());
  await ask("document.querySelector('.viewer').focus()");
  await press("ArrowRight");
  check(Math.abs(await split() - 27) <= 2, at + "and the arrow keys, to " + await split());
  check(await ask("document.activeElement.matches(':focus-visible')"), at + "focus is visible");
  await press("End");
  check(await split() === 100, at + "End is the right edge");

  await press("f");
  check(await pressed("flip") === "true", at + "F flips");
  const clip = "document.querySelector('.layer.b').style.clipPath";
  const first = await ask(clip);
  await press("f");
  check(first !== await ask(clip), at + "F shows the other picture");
  await press("d");
  check(await pressed("difference") === "true", at + "D shows the difference");
  check(await ask("getComputedStyle(document.querySelector('.layer.b')).mixBlendMode") === "difference",
    at + "as a difference");
  await press("s");
  check(await pressed("slider") === "true", at + "S shows the divider");

  await press("+");
  const place = "document.querySelector('.viewer img').style.transform";
  check((await ask(place)).includes("scale(1.5)"), at + "+ zooms: " + await ask(place));
  await press("0");
  check((await ask(place)).includes("scale(1)"), at + "0 shows all: " + await ask(place));
  const inset = "[...document.querySelectorAll('.patch')].map(p => p.style.backgroundPosition).join()";
  const before = await ask(inset);
  await press("ArrowLeft", 8);
  check(before !== await ask(inset), at + "shift and an arrow move the frame");
  check(new Set((await ask(inset)).split(",")).size === 1, at + "the frames are linked");

  /* Layers: each is a picture that is there. */
  const layers = await ask(`(async () => {
    const select = [...document.querySelectorAll('.bar label')].find(l => l.textContent.startsWith('over it'))
      .querySelector('select');
    const broken = [], names = [...select.options].map(o => o.text);
    for (let i = 1; i < names.length; i++) {
      select.value = i;
      select.dispatchEvent(new Event('change'));
      const images = [...document.querySelectorAll('.viewer img')].filter(image => !image.hidden);
      await Promise.all(images.map(image => image.decode().catch(() => broken.push(names[i]))));
      if (images.length < 3) broken.push(names[i]);
    }
    select.value = 0;
    select.dispatchEvent(new Event('change'));
    return { names, broken };
  })()`);
  for (const name of ["FLIP map", "classes of leak tracing", "rays"])
    check(layers.names.includes(name), at + "there is a layer " + name);
  check(layers.broken.length === 0, at + "layers without a picture: " + layers.broken);
}

async function tryPage(width, scheme) {
  const at = `${width} pixels wide: `;
  await send("Emulation.setDeviceMetricsOverride",
    { width, height: 900, deviceScaleFactor: 1, mobile: width < 600 });
  await send("Emulation.setEmulatedMedia",
    { features: [{ name: "prefers-color-scheme", value: scheme }] });
  const loaded = new Promise(done => listeners.push(message => {
    if (message.method === "Page.loadEventFired") done();
  }));
  await send("Page.navigate", { url: page });
  await loaded;
  const light = await ask("getComputedStyle(document.body).backgroundColor");
  check(scheme === "dark" ? light === "rgb(25, 28, 26)" : light === "rgb(247, 246, 242)",
    at + `a ${scheme} page is ${light}`);
  await tryViewer(width);

  const tabs = await ask("[...document.querySelectorAll('[role=tab]')].map(tab => tab.id.slice(4))");
  check(tabs.length >= 4, at + "parts: " + tabs);
  await ask("document.querySelector('[role=tab][aria-selected=true]').focus()");
  for (const [i, name] of tabs.entries()) {
    if (i > 0) await press("ArrowRight");
    await ask(rest2);
    check(await ask(`document.getElementById('part-${name}').offsetHeight > 50`), at + name + " is shown");
    const wide = await ask("document.documentElement.scrollWidth");
    check(wide <= width, at + name + " is no wider than the window: " + wide);
  }
  const broken = await ask(`(async () => {
    const names = [];
    for (const image of document.images) {
      image.loading = 'eager';
      if (image.getAttribute('src')) await image.decode().catch(() => names.push(image.src));
    }
    return names;
  })()`);
  check(broken.length === 0, at + "pictures that do not load: " + broken);
  return tabs;
}

/* Every plot has numbers, and ink; a line can be taken out. */
async function tryPlots() {
  const plots = await ask(`[...charts].map(chart => ({
    title: chart.canvas.getAttribute('aria-label'),
    points: chart.data.datasets.map(d => d.data.filter(p => Number.isFinite(p.y)).length),
    ink: chart.width > 0 && chart.ctx.getImageData(0, 0, chart.canvas.width, chart.canvas.height).data
      .some(value => value > 0) }))`);
  check(plots.length >= 3, "plots: " + plots.map(p => p.title));
  for (const plot of plots) {
    check(plot.points.length > 0 && plot.points.every(count => count >= 2),
      `${plot.title} has data: ${plot.points}`);
    check(plot.ink, `${plot.title} is drawn`);
  }
  const shown = await ask(`(() => {
    location.hash = 'sequences';
    const button = document.querySelector('#part-sequences .legend button');
    const chart = [...charts].find(c => document.getElementById('part-sequences').contains(c.canvas));
    const before = chart.isDatasetVisible(0);
    button.click();
    return [before, chart.isDatasetVisible(0), button.getAttribute('aria-pressed')];
  })()`);
  check(shown.join() === "true,false,false", "the legend takes a line out: " + shown);
}

const deadline = setTimeout(() => { console.error("the browser does not answer"); browser.kill(); process.exit(1); },
  60000);
try {
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  ({ sessionId: session } = await send("Target.attachToTarget", { targetId, flatten: true }));
  listeners.push(({ method, params }) => {
    if (method === "Runtime.exceptionThrown")
      check(false, "no exception: " + params.exceptionDetails.exception.description);
    if (method === "Runtime.consoleAPICalled" && ["error", "warning"].includes(params.type))
      check(false, "a silent console: " + params.args.map(a => a.value || a.description).join(" "));
    if (method === "Log.entryAdded" && params.entry.level === "error")
      check(false, "a silent log: " + params.entry.text);
    if (method === "Network.requestWillBeSent")
      check(/^(file|data|blob):/.test(params.request.url), "no network: " + params.request.url);
  });
  for (const domain of ["Runtime", "Log", "Network", "Page"]) await send(domain + ".enable");
  const tabs = await tryPage(1440, "light");
  await tryPlots();
  await tryPage(390, "dark");
  await tryPlots();
  console.log(`report: ${tabs.length} parts, at 1440 and 390 pixels; ${failures} failures`);
} catch (error) {
  failures++;
  console.error(error.message);
} finally {
  clearTimeout(deadline);
  browser.once("exit", () => {
    rmSync(profile, { recursive: true, force: true });
    process.exit(failures ? 1 : 0);
  });
  browser.kill();
}
