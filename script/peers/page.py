"""Writes the page of script/scoreboard from its results: Markdown with the rows that pictures show, HTML with all figures, and pictures."""
import html
import json
import math
import re

import chart
from PIL import Image, ImageDraw, ImageFont

BEGIN, END = "<!-- results: script/scoreboard --docs -->\n", "<!-- end of the results -->\n"
SHOWN = ("balanced", "best, 4 samples --gl none", "three.js", "VTK", "F3D", "pyrender", "MuJoCo classic", "MuJoCo Filament",
         "EEVEE, 4", "Cycles, 4, denoised", "Mitsuba, 16")

IN_SHORT = {"raster look", "balanced --gl none", "paths, 4", *SHOWN}
IN_README = {*IN_SHORT, "Cycles, 1", "Cycles, 4", "Cycles, 16", "Cycles, 16, denoised", "Mitsuba, 1", "Mitsuba, 4", "Mitsuba, 64"} - {"best, 4 samples --gl none"}


def collect(folder, settings, programs):
    """{scene: {truth, programs}} of what was measured, the counts of panes, and what flickers."""
    results = {}
    for setting in settings:
        path = folder / setting.name / "truth.json"
        if not path.is_file():
            continue
        records = [json.loads(file.read_text()) for p in programs if (file := folder / setting.name / f"{p.file}.json").is_file()]
        results[setting.name] = {**json.loads(path.read_text()), "programs": records}
    panes = [json.loads(file.read_text()) for file in sorted((folder / "panes").glob("*.json")) if file.stem != "stats"]
    dolly = {s.name: found for s in settings if (found := [json.loads(f.read_text()) for f in sorted((folder / f"dolly-{s.name}").glob("*.json"))])}
    return {"scenes": results, "panes": panes, "dolly": dolly}


def milliseconds(record, cores):
    """A frame's processor time divided by the cores, the least time on an idle machine."""
    return record["processor_ms"] / cores


def measured(scene):
    return [r for r in scene["programs"] if "flip" in r]


def panels(data, cores):
    return {name: [{**r, "ms": max(milliseconds(r, cores), 0.5)} for r in measured(scene)] for name, scene in data["scenes"].items()}


def time_text(ms):
    return f"{ms:.0f} ms" if ms < 1000 else f"{ms / 1000:.1f} s"


def summary_rows(data, cores):
    """A row a program: over all scenes that it drew, the mean error and the geometric mean of its time."""
    scenes = data["scenes"]
    names = list(dict.fromkeys(r["program"] for s in scenes.values() for r in measured(s)))
    for name in names:
        found = {scene: r for scene, s in scenes.items() for r in measured(s) if r["program"] == name}
        times = [max(milliseconds(r, cores), 0.5) for r in found.values()]
        first = next(iter(found.values()))
        yield {"program": name, "family": first["family"], "flips": [found[s]["flip"] if s in found else None for s in scenes],
               "flip": sum(r["flip"] for r in found.values()) / len(found) if len(found) == len(scenes) else None,
               "ms": math.exp(sum(map(math.log, times)) / len(times)), "peak": max(r["peak_mb"] for r in found.values()),
               "start": sorted(r["process_processor_s"] for r in found.values())[len(found) // 2]}


def relative_points(data, cores, base="balanced"):
    """For the README: geometric means over the scenes that a program drew of its time and error as multiples of those of `base` there."""
    found = {}
    for scene in data["scenes"].values():
        records = {r["program"]: r for r in measured(scene)}
        for name, r in records.items():
            if base in records and name in IN_README:
                ours = records[base]
                ratios = math.log(r["processor_ms"] / ours["processor_ms"]), math.log(r["flip"] / ours["flip"])
                found.setdefault((name, r["family"]), []).append(ratios)
    return [{"program": name, "family": family, "ms": math.exp(sum(t for t, _ in ratios) / len(ratios)),
             "flip": math.exp(sum(e for _, e in ratios) / len(ratios))} for (name, family), ratios in found.items()]


def bold(record, words):
    return f"**Sideray, {words}**" if record["family"] == "Sideray" else words


def table(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|---" * len(head) + "|", *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"


def mean_text(row):
    """The mean error, and the number of scenes where not all were drawn."""
    drawn = [flip for flip in row["flips"] if flip is not None]
    return f"{sum(drawn) / len(drawn):.3f}" + (f" ({len(drawn)})" if len(drawn) < len(row["flips"]) else "")


def summary_table(data, cores, all_figures):
    """All rows with the error in each scene, or those of the pictures with the mean error."""
    rows = sorted(summary_rows(data, cores), key=lambda r: r["ms"])
    if all_figures:
        return table(["program", "frame", "FLIP, mean", *data["scenes"], "start to picture, s", "memory, MB"],
                     [[bold(r, r["program"]), time_text(r["ms"]), number(r["flip"]), *map(number, r["flips"]), f"{r['start']:.1f}",
                       f"{r['peak']:.0f}"] for r in rows])
    return table(["program", "frame", "FLIP, mean", "start to picture, s", "memory, MB"],
                 [[bold(r, r["program"]), time_text(r["ms"]), mean_text(r), f"{r['start']:.1f}", f"{r['peak']:.0f}"]
                  for r in rows if r["program"] in IN_SHORT])


def number(value):
    return "" if value is None else f"{value:.4f}"


def scene_table(scene, cores):
    rows = [[bold(r, r["program"]), f"{r['processor_ms'] / cores:.0f}", f"{r['wall_ms']:.0f}", f"{r['flip']:.4f}", number(r["flip_own"]),
             f"{r['process_processor_s']:.1f}", f"{r['process_s']:.1f}", f"{r['peak_mb']:.0f}"]
            for r in sorted(measured(scene), key=lambda r: r["flip"])]
    rows += [[r["program"], "failed: " + r["error"].splitlines()[0], *[""] * 6] for r in scene["programs"] if "error" in r]
    return table(["program", "frame, ms", "by the clock", "FLIP to truth", "to Sideray's paths", "start to picture, s", "by the clock",
                  "memory, MB"], rows)


def panes_table(panes):
    """A row for all programs with the same counts."""
    rows = {}
    for record in sorted((p for p in panes if "right" in p), key=lambda p: -p["right"]):
        rows.setdefault(tuple(str(record[k]) for k in ("right", "order", "lost", "other")), []).append(bold(record, record["program"]))
    return table(["programs", "right", "another order", "a layer lost", "other colours"], [["; ".join(names), *counts] for counts, names in rows.items()])


def dolly_table(dolly):
    """A row for each program: the change of the error between frames in each scene, times 10^4."""
    measured_ = {scene: {r["program"]: r for r in records if "flicker" in r} for scene, records in dolly.items()}
    programs = {name: record for records in measured_.values() for name, record in records.items()}
    energy = {name: [of[name]["flicker_of_error"] if name in of else None for of in measured_.values()] for name in programs}
    order = sorted(programs, key=lambda name: [e for e in energy[name] if e is not None][0])
    rows = [[bold(programs[name], name), *("" if e is None else f"{1e4 * e:.1f}" for e in energy[name])] for name in order]
    return table(["program", *measured_], rows)


def truths_table(data, all_figures):
    """What each scene is, what made its truth, and how far path tracers are apart."""
    pairs = list(dict.fromkeys(pair for scene in data["scenes"].values() for pair in scene["apart"])) if all_figures else []
    rows = [[f"`{name}`", scene["what"], scene["truth"].replace(":", " ").replace(",", ", "),
             *(number(scene["apart"].get(pair)) for pair in pairs), number(scene["own_to_truth"])]
            for name, scene in data["scenes"].items()]
    return table(["scene", "", "truth, samples", *(f"FLIP of {pair}" for pair in pairs), "FLIP of Sideray's paths"], rows)


def versions(data, programs):
    """A line a family: what was measured, what it cannot draw."""
    seen = {}
    for record in (r for s in data["scenes"].values() for r in measured(s)):
        seen.setdefault(record["family"], set()).add(record["version"])
    for family in dict.fromkeys(p.family for p in programs):
        of = [p for p in programs if p.family == family]
        version = ", ".join(sorted(seen.get(family, ()))) or "not measured"
        lacks = next((p.lacks for p in of if p.lacks), "")
        yield [family, version, lacks or "nothing of these scenes"]


def markdown(data, programs, cores, machine, all_figures):
    parts = [f"{machine}; pictures of {next(iter(data['scenes'].values()))['size']}.\n",
             "## All scenes\n", "Times are geometric means over the scenes that the program drew.\n" if all_figures else
             "Times are geometric means over the scenes that the program drew; (5) means five of six.\n",
             summary_table(data, cores, all_figures), "## Scenes and truths\n", truths_table(data, all_figures)]
    for name, scene in data["scenes"].items():
        parts += [f"## {name}\n"] if all_figures else []
        parts += [f"![{name}](images/scoreboard-{name}.jpg)\n"]
        parts += [scene_table(scene, cores)] if all_figures else []
    if data["panes"]:
        stacks = next(p["stacks"] for p in data["panes"] if "stacks" in p)
        parts += ["## Stacks of panes\n", f"{stacks} stacks of four unlit panes, half transparent: in half of them each pane is an object, in "
                  "the others all four are one primitive. A stack is right if its middle has the colour that the order of the panes gives, blended "
                  "as light or as display values.\n", panes_table(data["panes"])]
    if data["dolly"]:
        parts += ["## While the camera moves\n", "A dolly of 12 frames of 240x135. `flicker_of_error` ([cli.md](cli.md#chart)) times 10^4: what changes from "
                  "frame to frame otherwise than in the truth, which is Cycles with 64 samples, denoised. Each frame is drawn by itself; \"a "
                  "sequence\" has Sideray's history.\n", dolly_table(data["dolly"])]
    parts += ["## Programs\n", table(["program", "version", "cannot draw"], versions(data, programs))]
    return "\n".join(parts)


def lettering(size):
    try:
        return ImageFont.truetype("DejaVuSans.ttf", size)
    except OSError:
        return ImageFont.load_default()


def sheet(folder, scene, cores, path, columns=3):
    """The truth and a picture of each kind of program, with time and error."""
    records = {r["program"]: r for r in measured(scene)}
    entries = [("truth", "", folder / "truth.png")]
    files = {json.loads(f.read_text()).get("program"): f.with_suffix(".png") for f in folder.glob("*.json") if f.stem not in ("truth", "stats")}
    for name in SHOWN:
        if name in records:
            r = records[name]
            ours = f"Sideray, {name}" if r["family"] == "Sideray" else name
            entries.append((ours, f"{time_text(milliseconds(r, cores))}, FLIP {r['flip']:.3f}", files[name]))
    width, height = Image.open(folder / "truth.png").size
    page = Image.new("RGB", (columns * (width + 6) - 6, -(-len(entries) // columns) * (height + 24)), "white")
    pen = ImageDraw.Draw(page)
    for i, (name, figures, file) in enumerate(entries):
        x, y = i % columns * (width + 6), i // columns * (height + 24)
        page.paste(Image.open(file).convert("RGB"), (x, y))
        pen.text((x + 3, y + height + 2), name, fill="black", font=lettering(14))
        pen.text((x + width - 3, y + height + 2), figures, fill="#444444", font=lettering(14), anchor="ra")
    page.save(path, quality=88)


STYLE = """body { font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 1240px; padding: 0 16px 48px; color: #1a1a1a; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 2em; } img, svg { max-width: 100%; height: auto; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(340px, 1fr)); } .charts .note { grid-column: 1 / -1; }
.charts svg { width: 100%; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: 14px; }
td, th { padding: 3px 10px; border-bottom: 1px solid #e2e2e2; text-align: right; } td:first-child, th:first-child { text-align: left; white-space: nowrap; }
.words td, .words th { text-align: left; vertical-align: top; min-width: 6em; } strong { color: #1456c8; } code { background: #f3f3f3; padding: 0 3px; }"""


def inline(words):
    """Bold, code, pictures and links of one line of Markdown."""
    words = html.escape(words, quote=False)
    words = re.sub(r"!\[([^]]*)\]\(([^)]*)\)", r'<img alt="\1" src="\2">', words)
    words = re.sub(r"\[([^]]*)\]\(([^)]*)\)", r'<a href="\2">\1</a>', words)
    words = re.sub(r"\*\*([^*]*)\*\*", r"<strong>\1</strong>", words)
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", words)


def html_table(lines):
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines if not line.startswith("|---")]
    wordy = ' class="words"' if any(len(c) > 60 for row in rows for c in row) else ""
    body = "".join("<tr>" + "".join(f"<{tag}>{inline(c)}</{tag}>" for c in row) + "</tr>\n"
                   for row, tag in zip(rows, ["th", *["td"] * len(rows)]))
    return f'<div class="wide"><table{wordy}>{body}</table></div>'


def html_page(text, charts):
    """The Markdown that this page uses, as HTML: headings, paragraphs, lists, tables, code blocks and pictures."""
    out = []
    for block in text.replace(BEGIN, "").replace(END, "").split("\n\n"):
        lines = block.strip("\n").split("\n")
        if lines[0].startswith("#"):
            level = len(lines[0].split()[0])
            out.append(f"<h{level}>{inline(lines[0].lstrip('# '))}</h{level}>")
            lines = lines[1:]
        if not lines or not lines[0]:
            continue
        if lines[0].startswith("|"):
            out.append(html_table(lines))
        elif lines[0].startswith("```"):
            out.append("<div class=wide><pre>" + html.escape("\n".join(lines[1:-1])) + "</pre></div>")
        elif lines[0].startswith("- "):
            items = "\n".join(lines)[2:].split("\n- ")
            out.append("<ul>" + "".join(f"<li>{inline(' '.join(i.split()))}</li>" for i in items) + "</ul>")
        elif "images/scoreboard.svg" in block:
            out.append(f'<div class="charts">{charts}</div>')
        else:
            out.append(f"<p>{inline(' '.join(lines))}</p>")
    title = "Sideray: time against error"
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{title}</title><style>{STYLE}</style></head><body>\n" + "\n".join(out) + "\n</body></html>\n")


def write_pages(root, folder, settings, programs, machine, cores):
    docs = root / "docs"
    data = collect(folder, settings, programs)
    (docs / "images" / "scoreboard.json").write_text(json.dumps(data, indent=0) + "\n")
    note = "Up: error, mean FLIP to the truth. Right: processor time of a frame over the cores. Both logarithmic; nearer to the lower left is better. The blue line is Sideray's front; numbers are samples."
    svg = chart.draw(panels(data, cores), note)
    (docs / "images" / "scoreboard.svg").write_text(svg)
    notes = ("Up: visible error (FLIP) to a path-traced truth. Right: processor time of a frame, without a GPU.",
             f"Geometric means over {len(data['scenes'])} scenes, or those that a program draws. Numbers are samples.",
             "Cycles and Mitsuba also make the truth. Nearer to the lower left is better.")
    (docs / "images" / "scoreboard-mean.svg").write_text(chart.draw_relative(relative_points(data, cores), notes))
    for name, scene in data["scenes"].items():
        sheet(folder / name, scene, cores, docs / "images" / f"scoreboard-{name}.jpg")
    page = docs / "scoreboard.md"
    before, rest = page.read_text().split(BEGIN)
    short, long = (before + BEGIN + "\n" + markdown(data, programs, cores, machine, tables) + "\n" + END + rest.split(END)[1]
                   for tables in (False, True))
    page.write_text(short)
    (docs / "scoreboard.html").write_text(html_page(long, "\n".join(chart.draw_each(panels(data, cores), note))))
