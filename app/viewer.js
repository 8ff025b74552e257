"use strict";
/* The viewer of pictures of one view: two at a time under a divider, in turns, or their difference;
 * zoom; a frame whose contents are shown enlarged for every picture. Used by the pages of
 * "gnomon demo" and "gnomon report". */

function make(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {}))
    if (value != null) node.setAttribute(key, value);
  node.append(...children.filter(child => child != null));
  return node;
}
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const fixed = (value, count) => value == null ? "–" : value.toFixed(count);

function makeChoice(label, words, selected, change) {
  const select = make("select", {}, ...words.map((word, i) => make("option", { value: i }, word)));
  select.value = Math.max(0, selected);
  select.addEventListener("change", change);
  return [make("label", {}, label, select), select];
}
function makeButton(text, label, action) {
  const node = make("button", { type: "button", "aria-label": label, title: label }, text);
  node.addEventListener("click", action);
  return node;
}
function makeRange(label, low, high, value, change) {
  const input = make("input", { type: "range", min: low, max: high, step: "any", value });
  input.addEventListener("input", change);
  return [make("label", {}, label, input), input];
}

/* what: label; width, height of the pictures; left, right: names of those shown first; spot: where
 * the frame starts, shares of width and height; pictures: name, url, and layers, an object from the
 * layer's name to the url of a picture that may lie over this one. */
function makeViewer(what) {
  const { width, height, pictures } = what;
  const index = name => Math.max(0, pictures.findIndex(p => p.name === name));
  const names = pictures.map(p => p.name);
  const layers = [...new Set(pictures.flatMap(p => Object.keys(p.layers || {})))];
  const [labelA, left] = makeChoice("left", names, index(what.left), pick);
  const [labelB, right] = makeChoice("right", names, index(what.right), pick);
  const [labelLayer, layer] = makeChoice("over it", ["nothing", ...layers], 0, pick);
  const [labelOpacity, opacity] = makeRange("strength", 0, 1, 0.85, draw);
  const [labelGain, gain] = makeRange("gain", 1, 16, 4, draw);
  const modes = ["slider", "flip", "difference"].map(mode => {
    const help = { slider: "A divider between the two (S)", flip: "The two in turns (F, again F)",
      difference: "How much the two differ (D)" }[mode];
    const node = makeButton(mode, help, () => setMode(mode));
    node.dataset.mode = mode;
    return node;
  });

  const side = letter => {
    const base = make("img", { alt: "" }), over = make("img", { alt: "" });
    return { base, over, box: make("div", { class: "layer " + letter }, base, over) };
  };
  const a = side("a"), b = side("b");
  const stack = make("div", { class: "stack" }, a.box, b.box);
  const tagA = make("span", { class: "tag a" }), tagB = make("span", { class: "tag b" });
  const spot = make("div", { class: "spot" }), divider = make("div", { class: "divider" });
  const viewer = make("div", { class: "viewer", tabindex: 0, role: "slider",
    "aria-label": "Divider between the two methods, " + what.label, "aria-valuemin": 0,
    "aria-valuemax": 100, style: "--aspect: " + width + " / " + height },
    stack, spot, divider, tagA, tagB);
  const patches = pictures.map(() => make("div", { class: "patch" }, make("i")));
  const insets = make("div", { class: "insets" }, ...patches.map((patch, i) =>
    make("figure", {}, patch, make("figcaption", {}, names[i]))));
  const state = { mode: "slider", split: .5, second: false, zoom: 1, x: 0, y: 0,
    u: what.spot[0], v: what.spot[1] };

  const over = picture => (picture.layers || {})[layers[layer.value - 1]];
  function drawInset() {
    const side = patches[0].clientWidth / 4; /* pixels of the picture */
    if (!side) return 0;
    state.u = clamp(state.u, side / 2 / width, 1 - side / 2 / width);
    state.v = clamp(state.v, side / 2 / height, 1 - side / 2 / height);
    const place = `${-(state.u * width - side / 2) * 4}px ${-(state.v * height - side / 2) * 4}px`;
    for (const [i, patch] of patches.entries()) {
      const top = over(pictures[i]);
      for (const [node, url] of [[patch, pictures[i].url], [patch.firstChild, top]]) {
        node.style.backgroundImage = url ? `url("${url}")` : "none";
        node.style.backgroundSize = `${width * 4}px ${height * 4}px`;
        node.style.backgroundPosition = place;
      }
      patch.firstChild.style.opacity = opacity.value;
    }
    return side;
  }
  function draw() {
    const w = viewer.clientWidth, h = viewer.clientHeight, z = state.zoom;
    if (!w) return; /* not shown */
    state.x = clamp(state.x, w - w * z, 0);
    state.y = clamp(state.y, h - h * z, 0);
    const inset = drawInset();
    viewer.classList.toggle("zoomed", z > 1);
    viewer.classList.toggle("difference", state.mode === "difference");
    for (const image of [a.base, a.over, b.base, b.over])
      image.style.transform = `translate(${state.x}px, ${state.y}px) scale(${z})`;
    for (const part of [a, b]) part.over.style.opacity = opacity.value;
    stack.style.filter = state.mode === "difference" ? `brightness(${gain.value})` : "";
    const split = state.mode === "slider" ? state.split : state.second || state.mode !== "flip" ? 0 : 1;
    b.box.style.clipPath = `inset(0 0 0 ${split * 100}%)`;
    divider.hidden = state.mode !== "slider";
    divider.style.left = split * 100 + "%";
    const first = names[left.value], second = names[right.value];
    tagA.textContent = state.mode === "difference" ? `${first} − ${second}` : first;
    tagB.textContent = second;
    tagA.hidden = state.mode === "flip" && state.second;
    tagB.hidden = state.mode === "difference" || (state.mode === "flip" && !state.second);
    for (const node of modes) node.setAttribute("aria-pressed", node.dataset.mode === state.mode);
    labelGain.hidden = state.mode !== "difference";
    labelOpacity.hidden = layer.value === "0";
    viewer.setAttribute("aria-valuenow", Math.round(split * 100));
    viewer.setAttribute("aria-valuetext", state.mode === "difference"
      ? `difference of ${first} and ${second}`
      : `${Math.round(split * 100)} % ${first}, the rest ${second}`);
    const unit = w / width * z, size = inset * unit;
    Object.assign(spot.style, { width: size + "px", height: size + "px",
      left: state.x + state.u * w * z - size / 2 + "px",
      top: state.y + state.v * h * z - size / 2 + "px" });
  }
  function pick() {
    for (const [part, select] of [[a, left], [b, right]]) {
      const picture = pictures[select.value], top = over(picture);
      part.base.src = picture.url;
      part.over.hidden = !top;
      if (top) part.over.src = top;
    }
    draw();
  }
  function setMode(mode) {
    state.second = mode === "flip" && state.mode === "flip" && !state.second;
    state.mode = mode;
    draw();
  }
  /* Zooms about a point of the viewer, in its own pixels. */
  function zoom(factor, px, py) {
    const next = clamp(state.zoom * factor, 1, 16), change = next / state.zoom;
    state.x = px - (px - state.x) * change;
    state.y = py - (py - state.y) * change;
    state.zoom = next;
    draw();
  }
  const middle = factor => zoom(factor, viewer.clientWidth / 2, viewer.clientHeight / 2);
  function place(event) {
    const box = viewer.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  viewer.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? .05 : .002)), ...place(event));
  }, { passive: false });
  const keys = { f: () => setMode("flip"), d: () => setMode("difference"),
    s: () => setMode("slider"), "-": () => middle(1 / 1.5), 0: () => middle(0),
    Home: () => { state.split = 0; }, End: () => { state.split = 1; },
    "+": () => zoom(1.5, viewer.clientWidth * state.u * state.zoom + state.x,
      viewer.clientHeight * state.v * state.zoom + state.y) };
  keys["="] = keys["+"];
  viewer.addEventListener("keydown", event => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) {
      state.u += arrow[0] * 6 / width;
      state.v += arrow[1] * 6 / height;
    } else if (arrow && arrow[0]) {
      state.split = clamp(state.split + arrow[0] * .02, 0, 1);
    } else if (keys[event.key]) {
      keys[event.key]();
    } else return;
    event.preventDefault();
    draw();
  });

  const fingers = new Map();
  let moved = 0, dividing = false, spread = 0;
  viewer.addEventListener("pointerdown", event => {
    if (event.button) return;
    fingers.set(event.pointerId, place(event));
    if (fingers.size === 1) { moved = 0; dividing = event.target === divider; }
    if (fingers.size === 2) { moved = 99; dividing = false; spread = 0; }
    if (dividing || state.zoom > 1 || fingers.size === 2) viewer.setPointerCapture(event.pointerId);
  });
  viewer.addEventListener("pointermove", event => {
    if (!fingers.has(event.pointerId)) return;
    const before = fingers.get(event.pointerId), now = place(event);
    fingers.set(event.pointerId, now);
    moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (fingers.size === 2) {
      const [p, q] = [...fingers.values()];
      const distance = Math.hypot(p[0] - q[0], p[1] - q[1]);
      if (spread) zoom(distance / spread, (p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
      spread = distance;
    } else if (dividing) {
      state.split = clamp(now[0] / viewer.clientWidth, 0, 1);
      draw();
    } else if (state.zoom > 1) {
      state.x += now[0] - before[0];
      state.y += now[1] - before[1];
      draw();
    }
  });
  for (const type of ["pointerup", "pointercancel"])
    viewer.addEventListener(type, event => {
      if (!fingers.delete(event.pointerId)) return;
      if (type === "pointerup" && !dividing && moved < 5 && fingers.size === 0) {
        const [x, y] = place(event);
        state.u = (x - state.x) / (viewer.clientWidth * state.zoom);
        state.v = (y - state.y) / (viewer.clientHeight * state.zoom);
        draw();
      }
      if (fingers.size === 0) dividing = false;
    });

  const node = make("div", { class: "comparison" },
    make("div", { class: "bar" }, labelA, labelB, layers.length ? labelLayer : null, labelOpacity,
      labelGain, make("span", { class: "push" }, ...modes), make("span", { class: "zoom push" },
        makeButton("−", "Zoom out", () => middle(1 / 1.5)),
        makeButton("+", "Zoom in", () => middle(1.5)),
        makeButton("Fit", "Whole picture", () => middle(0)))),
    viewer, insets);
  pick();
  new ResizeObserver(draw).observe(viewer);
  return node;
}
