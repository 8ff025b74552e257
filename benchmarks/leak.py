#!/usr/bin/env python3
"""Tables and figures of leak tracing, from what `gnomon bench --json` wrote.

    leak.py report FOLDER [--images FOLDER] [--into docs/benchmarks.md]

report reads FOLDER/PART@NAME.json as benchmarks/run.sh names them, prints the tables as Markdown,
and writes the figures as SVG. --into puts each table between its marks in a document:
    <!-- table NAME --> ... <!-- end -->

Only Python's own library is needed.
"""
import argparse
import json
import math
import pathlib
import re
import sys

INK, AXIS, RAY, LEAK, LIGHT = "#222", "#999", "#b35c00", "#2f6da8", "#9db8d2"
# Tracing all, with the alpha rule of leak tracing's presets.
SATURATE = "ray-saturate"


# Results --------------------------------------------------------------------------------------

class Run:
    """One measurement: some methods on the frames of one camera."""

    def __init__(self, document):
        self.document = document
        self.methods = {m["name"]: m for m in document["methods"]}
        self.ms = {name: m["series"]["ms"] for name, m in self.methods.items()}

    def __contains__(self, name):
        return name in self.methods

    def __getitem__(self, name):
        return self.methods[name]

    def yardstick(self, name):
        """Tracing all with the same alpha rule."""
        return self[name]["yardstick"]

    def mean(self, name):
        return sum(self.ms[name]) / len(self.ms[name])

    def speedups(self, name):
        """Of every frame."""
        return [all_ / leak for all_, leak in
                zip(self.ms[self.yardstick(name)], self.ms[name])]

    def rays(self, name):
        """Share of the rays that tracing all needs."""
        return self[name]["rays_per_pixel"] / self[self.yardstick(name)]["rays_per_pixel"]


def read(folder):
    """{part: {name: Run}}, in the order in which they were measured."""
    found = {}
    for path in sorted(folder.glob("*@*.json"), key=lambda p: p.stat().st_mtime):
        part, name = path.name.removesuffix(".json").split("@")
        found.setdefault(part, {})[name] = Run(json.loads(path.read_text()))
    return found


# Tables ---------------------------------------------------------------------------------------

def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def three(values, digits=2):
    return [f"{x:.{digits}f}" for x in (sum(values) / len(values), min(values), max(values))]


def speed_table(runs, alpha):
    """Table 2 of the paper: how many times as fast as tracing all."""
    methods = [name + alpha for name in ("lt-evsm", "lt-vsm")]
    head = ["scene", "tracing all, ms"]
    for name in methods:
        head += [f"{name}, ms", "mean", "least", "most", "whole path"]
    rows = []
    for scene, run in runs.items():
        all_ = run.yardstick(methods[0])
        row = [scene, f"{run.mean(all_):.1f}"]
        for name in methods:
            row += [f"{run.mean(name):.1f}", *three(run.speedups(name)),
                    f"{run.mean(all_) / run.mean(name):.2f}"]
        rows.append(row)
    return table(head, rows)


def pass_table(runs):
    """Where the time goes."""
    rows = []
    for scene, run in runs.items():
        for name in ("lt-evsm", "lt-vsm"):
            passes = run[name]["passes"]
            rows.append([scene, name, f"{run.mean(name):.1f}"] +
                        [f"{passes[p]['ms_mean']:.1f}"
                         for p in ("shadow_map", "filter", "test", "trace")] +
                        [f"{run.rays(name) * 100:.1f} %"])
    return table(["scene", "method", "ms", "drawing maps", "filter", "test and mask", "rays",
                  "rays of tracing all"], rows)


def fidelity_table(runs):
    rows = []
    for scene, run in runs.items():
        for name in ("lt-evsm", "lt-vsm"):
            hard, soft, all_ = run[name + ":mip0"], run[name], run[SATURATE]
            rows.append([scene, name, f"{hard['wrong_pixels'] * 100:.4f} %",
                         f"{hard['wrong_max'] * 100:.4f} %", f"{soft['mean_abs']:.5f}",
                         f"{soft['wrong_pixels'] * 100:.4f} %",
                         f"{soft['flicker'] / all_['flicker']:.3f}"])
    return table(["scene", "method", "mip0: wrong pixels", "worst frame",
                  "saturate: mean abs", "wrong pixels", "flicker / ray-saturate"], rows)


ABLATIONS = [("sm:no-reuse", "plain map, made anew"), ("vsm:no-reuse", "vsm, made anew"),
             ("msm128:no-reuse", "msm128, made anew"), (SATURATE, "tracing all"),
             ("lt-evsm", "leak tracing (lt-evsm)"),
             ("lt-evsm:no-remove", "without removal"), ("lt-evsm:no-expand", "without expansion"),
             ("lt-evsm:no-reuse", "without reuse of maps"),
             ("ltt-evsm", "the test alone, no mask"), ("hybrid-pcf", "hybrid-pcf")]


def ablation_table(run):
    """Table 3 of the paper."""
    rows = []
    for name, what in ABLATIONS:
        if name not in run:
            continue
        method = run[name]
        traced = name.startswith(("lt", "hybrid"))
        rows.append([what, *three(run.ms[name], 1),
                     f"{run.rays(name) * 100:.1f} %" if traced else "-",
                     f"{method['wrong_pixels'] * 100:.3f} %" if traced else "-",
                     f"{method['mean_abs']:.5f}" if traced else "-"])
    return table(["", "mean, ms", "least", "most", "rays of tracing all", "wrong pixels",
                  "mean abs"], rows)


def is_kind(name):
    return name.startswith(("lt-", "hybrid")) and ":no-" not in name


def kind_table(run):
    """Figure 8a in numbers."""
    rows = []
    for name in run.methods:
        if is_kind(name):
            rows.append([name, *three(run.ms[name], 1), *three(run.speedups(name)),
                         f"{run.rays(name) * 100:.1f} %",
                         f"{run[name]['wrong_pixels'] * 100:.3f} %",
                         f"{run[name]['mean_abs']:.5f}",
                         f"{run[name]['map']['bytes'] / 1e6:.0f}"])
    return table(["method", "mean, ms", "least", "most", "speed-up: mean", "least", "most",
                  "rays", "wrong pixels", "mean abs", "MB"], rows)


def height_table(runs):
    rows = []
    for run in sorted(runs.values(), key=lambda r: r.document["height"]):
        d = run.document
        rows.append([f"{d['width']}x{d['height']}", f"{run.mean(SATURATE):.1f}",
                     f"{run.mean('lt-evsm'):.1f}", *three(run.speedups("lt-evsm")),
                     f"{run.rays('lt-evsm') * 100:.1f} %"])
    return table(["picture", "tracing all, ms", "lt-evsm, ms", "speed-up: mean", "least", "most",
                  "rays of tracing all"], rows)


def texel_table(run):
    rows = []
    for name in run.methods:
        if not name.startswith("lt-"):
            continue
        size = re.search(r":size=(\d+)", name)
        method = run[name]
        rows.append([f"{size[1]}²" if size else name, f"{run.mean(name):.1f}",
                     *three(run.speedups(name)), f"{run.rays(name) * 100:.1f} %",
                     f"{method['wrong_pixels'] * 100:.3f} %", f"{method['wrong_max'] * 100:.3f} %",
                     f"{method['mean_abs']:.5f}"])
    return table(["maps", "lt-evsm, ms", "speed-up: mean", "least", "most", "rays",
                  "wrong pixels", "worst frame", "mean abs"], rows)


def light_table(runs):
    rows = []
    for run in sorted(runs.values(), key=lambda r: len(r.document["lights"])):
        name = next(n for n in run.methods if n.startswith("lt-"))
        lights, method = len(run.document["lights"]), run[name]
        rows.append([lights, f"{run.mean(run.yardstick(name)) / lights:.1f}",
                     f"{run.mean(name) / lights:.1f}",
                     f"{run.mean(run.yardstick(name)) / run.mean(name):.2f}",
                     f"{method['mask_bytes'] / 1e6:.2f}",
                     f"{method['mask_bytes'] / lights / 1e6:.3f}",
                     f"{method['map']['bytes'] / lights / 1e6:.1f}"])
    return table(["lights", "tracing all, ms a light", "lt-evsm, ms a light", "speed-up",
                  "masks, MB", "MB a light", "maps, MB a light"], rows)


# Figures --------------------------------------------------------------------------------------

def text(x, y, what, **style):
    attributes = "".join(f' {k.replace("_", "-")}="{v}"' for k, v in style.items())
    what = str(what).replace("&", "&amp;").replace("<", "&lt;")
    return f'<text x="{x:.1f}" y="{y:.1f}"{attributes}>{what}</text>'


def svg(width, height, title, parts):
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 '
        f'{width} {height}" font-family="sans-serif" font-size="12" fill="{INK}">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        text(24, 26, title, font_size=15), *parts, "</svg>", ""])


def round_up(value):
    """The next of 1, 2, 5 times a power of ten."""
    power = 10 ** math.floor(math.log10(value))
    return next(k * power for k in (1, 2, 3, 4, 5, 6, 8, 10) if k * power >= value * 0.9999)


def panel(x, y, width, height, title, seconds, series):
    """Lines of milliseconds over time; series: (values, colour, name)."""
    top = round_up(max(max(values) for values, _, _ in series))
    out = [text(x, y - 8, title, font_weight=600)]
    for i in range(5):
        at = y + height - height * i / 4
        out.append(f'<path d="M{x} {at:.1f}h{width}" stroke="{AXIS}" stroke-width="'
                   f'{1 if i == 0 else 0.3}"/>')
        out.append(text(x - 6, at + 4, f"{top * i / 4:g}", text_anchor="end"))
    for i in range(3):
        out.append(text(x + width * i / 2, y + height + 16,
                        f"{seconds[0] + (seconds[1] - seconds[0]) * i / 2:.2g} s",
                        text_anchor="middle"))
    for values, colour, name in series:
        step = width / max(len(values) - 1, 1)
        points = " ".join(f"{x + i * step:.1f},{y + height - height * v / top:.1f}"
                          for i, v in enumerate(values))
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.6">'
                   f"<title>{name}</title></polyline>")
    # The means, the larger one above; not on top of each other.
    low = y + height + 20
    for mean, colour in sorted((sum(values) / len(values), colour)
                               for values, colour, _ in series):
        low = min(y + height - height * mean / top + 4, low - 13)
        out.append(text(x + width + 4, low, f"{mean:.0f}", fill=colour, font_weight=600))
    return out


def panels(title, runs, columns, name_of):
    """A panel a run: tracing all against leak tracing."""
    width, height, left, gap_x, gap_y, first = 260, 130, 60, 90, 76, 84
    parts = [text(24, 48, "tracing all", fill=RAY, font_weight=600),
             text(98, 48, "leak tracing (lt-evsm)", fill=LEAK, font_weight=600),
             text(246, 48, "milliseconds a frame; at the right their mean", fill=INK)]
    for i, (name, run) in enumerate(runs):
        d = run.document
        parts += panel(left + i % columns * (width + gap_x),
                       first + i // columns * (height + gap_y), width, height,
                       name_of(name, run), (0, (d["frames"] - 1) / d["fps"]),
                       [(run.ms[SATURATE], RAY, "tracing all"),
                        (run.ms["lt-evsm"], LEAK, "lt-evsm")])
    rows = -(-len(runs) // columns)
    return svg(left + min(columns, len(runs)) * (width + gap_x) - 30,
               first + rows * (height + gap_y) - 36, title, parts)


def kind_figure(run):
    """A bar a map type: the mean, and a line from the least to the most."""
    names = [SATURATE] + [n for n in run.methods if is_kind(n)]
    left, width, row = 170, 560, 24
    top = round_up(max(max(run.ms[n]) for n in names))
    parts = [text(24, 48, "milliseconds a frame: mean (bar), least to most (line)")]
    height = 70 + row * len(names)
    for i in range(5):
        at = left + width * i / 4
        parts.append(f'<path d="M{at:.1f} 62V{height}" stroke="{AXIS}" stroke-width="0.3"/>')
        parts.append(text(at, height + 16, f"{top * i / 4:g}", text_anchor="middle"))
    for i, name in enumerate(names):
        y = 68 + i * row
        mean, least, most = float(run.mean(name)), min(run.ms[name]), max(run.ms[name])
        colour = RAY if name == SATURATE else LIGHT if "filtered" in name or "nlmsm" in name \
            else LEAK
        parts.append(text(left - 8, y + 13, name, text_anchor="end"))
        parts.append(f'<rect x="{left}" y="{y}" width="{width * mean / top:.1f}" height="16" '
                     f'fill="{colour}"/>')
        parts.append(f'<path d="M{left + width * least / top:.1f} {y + 8}H'
                     f'{left + width * most / top:.1f}" stroke="{INK}"/>')
        parts.append(text(left + width + 10, y + 13, f"{mean:.1f}", font_weight=600))
    parts.append(text(left + width + 10, 56, "mean"))
    parts.append(text(24, height + 36, "dark: single depth, light: filtered maps"))
    return svg(left + width + 70, height + 50,
               f"Map types under leak tracing, {scene_of(run)}", parts)


def scene_of(run):
    return pathlib.Path(run.document["scene"]).name


def draw(found, images):
    figures = {}
    if "path" in found:
        figures["leak-time"] = panels("Visibility over the camera's path",
                                      list(found["path"].items()), 3, lambda name, run: name)
    if "ablation" in found:
        figures["leak-kinds"] = kind_figure(next(iter(found["ablation"].values())))
    if "height" in found:
        runs = sorted(found["height"].items(), key=lambda r: r[1].document["height"])
        figures["leak-heights"] = panels(
            f"Pictures of several sizes, {scene_of(runs[0][1])}", runs, 4,
            lambda name, run: f"{run.document['width']} × {run.document['height']}")
    images.mkdir(parents=True, exist_ok=True)
    for name, what in figures.items():
        (images / f"{name}.svg").write_text(what)


# Commands -------------------------------------------------------------------------------------

def tables(found):
    """{name: Markdown}."""
    out = {}
    if "path" in found:
        runs = found["path"]
        out["speed"] = speed_table(runs, "")
        out["speed-mip0"] = speed_table(runs, ":mip0")
        out["passes"] = pass_table(runs)
        out["fidelity"] = fidelity_table(runs)
    for run in found.get("ablation", {}).values():
        out["ablation"] = ablation_table(run)
        out["kinds"] = kind_table(run)
    if "height" in found:
        out["heights"] = height_table(found["height"])
    for run in found.get("texels", {}).values():
        out["texels"] = texel_table(run)
    if "lights" in found:
        out["lights"] = light_table(found["lights"])
    return out


def insert(document, name, what):
    """The document with a table in the place that is marked for it, if there is one."""
    mark = re.compile(rf"(<!-- table {re.escape(name)} -->\n).*?(\n<!-- end -->)", re.S)
    return mark.sub(lambda m: m[1] + what + m[2], document)


def report(arguments):
    found = read(arguments.folder)
    if not found:
        sys.exit(f"leak.py: {arguments.folder}: no results")
    made = tables(found)
    for name, what in made.items():
        print(f"\n{name}\n\n{what}")
    if arguments.images:
        draw(found, arguments.images)
    if arguments.into:
        document = arguments.into.read_text()
        for name, what in made.items():
            document = insert(document, name, what)
        arguments.into.write_text(document)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("report")
    command.add_argument("folder", type=pathlib.Path)
    command.add_argument("--images", type=pathlib.Path)
    command.add_argument("--into", type=pathlib.Path)
    command.set_defaults(run=report)
    arguments = parser.parse_args()
    arguments.run(arguments)


main()
