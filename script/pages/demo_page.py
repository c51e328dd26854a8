"""demo_page.py DIR: prints the table of what script/demo rendered into DIR, and writes DIR/index.html."""
import base64
import html
import json
import os
import sys

folder = sys.argv[1]
TRUTH = "reference"
TITLES = {"raster": "raster", "hybrid": "hybrid", "raytraced": "ray traced, 2 events",
          "alone": "rays alone, without OpenGL", TRUTH: "reference"}
STAGES = ["gbuffer", "shadow_map", "mask", "readback", "trace", "upload", "light", "composite", "total_frame"]


def read(name):
    with open(os.path.join(folder, name), encoding="utf-8") as stream:
        return json.load(stream)


def rows():
    yield ["", *(stage.replace("_", " ") for stage in STAGES), "rays", "FLIP"]
    for name, title in TITLES.items():
        stats = read(name + ".json")
        flip = "(itself)" if name == TRUTH else "%.4f" % read(name + "-error.json")["flip"]
        yield [title, *("%.1f" % (stats["stages_ms"].get(stage) or 0.0) for stage in STAGES),
               "{:,}".format(stats["rays"]["total"]), flip]


def text_table(table):
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    for row in table:
        yield row[0].ljust(widths[0]) + "  " + "  ".join(c.rjust(w) for c, w in zip(row[1:], widths[1:]))


def html_table(table):
    lines = ["<table>"]
    for number, row in enumerate(table):
        tag = "th" if number == 0 else "td"
        lines.append("<tr>" + "".join("<%s>%s</%s>" % (tag, html.escape(cell), tag) for cell in row) + "</tr>")
    return "\n".join(lines + ["</table>"])


def figure(file, caption):
    with open(os.path.join(folder, file), "rb") as stream:
        data = base64.b64encode(stream.read()).decode("ascii")
    return '<figure><img src="data:image/png;base64,%s" alt="%s"><figcaption>%s</figcaption></figure>' % (
        data, html.escape(caption), html.escape(caption))


STYLE = """body { font: 15px/1.5 sans-serif; margin: 2em; background: #16181c; color: #e4e4e4 }
.side { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 1em }
figure { margin: 0 } img { width: 100%; display: block }
table { border-collapse: collapse; margin: 1em 0 } td, th { padding: .2em .7em; text-align: right }
td:first-child { text-align: left } tr + tr { border-top: 1px solid #444 }"""


def page(table):
    device = read("hybrid.json")["device"]
    size = read("hybrid.json")["config"]["size"]
    pictures = "\n".join(figure(name + ".png", title) for name, title in TITLES.items())
    maps = "\n".join(figure(name + "-flip.png", TITLES[name] + ": FLIP against the reference")
                     for name in TITLES if name != TRUTH)
    return """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Sideray demo</title><style>%s</style></head><body>
<h1>Sideray: one scene three ways, by rays alone, and the reference</h1>
<p>Scene <code>bistro</code>, %s. Milliseconds, medians; FLIP is the mean against the reference.
%s, Embree %s, %s threads.</p>
%s
<h2>Pictures</h2><div class="side">%s</div>
<h2>Where they differ</h2><div class="side">%s</div>
</body></html>
""" % (STYLE, size, html.escape(device["renderer"]), html.escape(device.get("embree", "?")),
       device.get("threads", "?"), html_table(table), pictures, maps)


table = list(rows())
path = os.path.join(folder, "index.html")
with open(path + ".tmp", "w", encoding="utf-8") as stream:
    stream.write(page(table))
os.replace(path + ".tmp", path)
print("\nMilliseconds a stage (medians), rays a frame, mean FLIP against the reference:")
print("\n".join(text_table(table)))
print("\nPictures: %s\nPage:     %s" % (os.path.abspath(folder), os.path.abspath(path)))
