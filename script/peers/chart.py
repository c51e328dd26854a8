"""Draws time against error as SVG, one panel a scene."""
import html
import math

WIDTH, HEIGHT, COLUMNS = 400, 300, 3
LEFT, RIGHT, TOP, BOTTOM = 46, 12, 30, 40
STYLES = {  # family: (colour, marker)
    "Sideray": ("#1456c8", "circle"), "three.js": ("#c2410c", "square"), "VTK": ("#0f766e", "square"), "F3D": ("#65a30d", "square"),
    "pyrender": ("#a16207", "square"), "MuJoCo": ("#be185d", "square"), "Filament": ("#7c3aed", "square"),
    "EEVEE": ("#ea8c00", "diamond"), "Cycles": ("#444444", "triangle"), "Mitsuba": ("#8a8a8a", "triangle")}


def kind(program):
    """Returns the points joined by a line: programs that differ only in samples or presets."""
    if program["family"] == "Sideray":
        name = program["program"]
        return "paths" if name.startswith("paths") else "none" if "--gl none" in name else "gl"
    return "denoised" if "denoised" in program["program"] else program["family"]


def label(program):
    name = program["program"]
    if program["family"] in ("Cycles", "Mitsuba", "EEVEE") or name.startswith("paths"):
        return name.split(", ")[1]
    return {"raster look": "raster", "MuJoCo classic": "MuJoCo", "MuJoCo Filament": "Filament", "best, 4 samples": "4 samples"}.get(name, name)


def whole_label(program):
    name = program["program"].replace(",", "")
    if program["family"] == "Sideray":
        return {"balanced": "Sideray", "raster look": "Sideray without rays"}.get(name, "Sideray " + name.replace("balanced ", ""))
    return "MuJoCo" if name == "MuJoCo classic" else name.replace("MuJoCo Filament", "Filament")


def front(points):
    """Returns the points that no other point beats in both time and error."""
    kept, best = [], math.inf
    for p in sorted(points, key=lambda p: (p["ms"], p["flip"])):
        if p["flip"] < best:
            best = p["flip"]
            kept.append(p)
    return kept


def marker(shape, x, y, color, hollow, size=5.0):
    fill = "#ffffff" if hollow else color
    look = f'fill="{fill}" stroke="{color}" stroke-width="1.6"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size}" {look}/>'
    if shape == "square":
        return f'<rect x="{x - size + 1:.1f}" y="{y - size + 1:.1f}" width="{2 * size - 2}" height="{2 * size - 2}" {look}/>'
    corners = {"diamond": ((0, -1.2), (1.2, 0), (0, 1.2), (-1.2, 0)), "triangle": ((0, -1.1), (1.1, 0.9), (-1.1, 0.9))}[shape]
    return f'<polygon points="{" ".join(f"{x + size * a:.1f},{y + size * b:.1f}" for a, b in corners)}" {look}/>'


def text(x, y, words, size=11, color="#222222", anchor="start", weight="normal"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" fill="{color}" text-anchor="{anchor}" font-weight="{weight}">'
            f'{html.escape(words)}</text>')


class Panel:
    """A chart of points. `relative`: their times and errors are multiples of another program's, and they have whole names."""

    def __init__(self, points, x, y, width=WIDTH, height=HEIGHT, relative=False):
        self.points, self.x, self.y, self.width, self.height, self.relative = points, x, y, width, height, relative
        fastest = min(p["ms"] for p in points)
        self.low = fastest * 0.7 if relative else 10 ** math.floor(math.log10(fastest * 0.9))
        self.high = max(p["ms"] for p in points) * 1.6
        self.least, self.most = min(p["flip"] for p in points) * 0.85, max(p["flip"] for p in points) * 1.15
        self.taken = []

    def at(self, point):
        share = math.log(point["ms"] / self.low) / math.log(self.high / self.low)
        up = math.log(point["flip"] / self.least) / math.log(self.most / self.least)
        return (self.x + LEFT + share * (self.width - LEFT - RIGHT), self.y + TOP + (1 - up) * (self.height - TOP - BOTTOM))

    def axes(self, title):
        x0, x1 = self.x + LEFT, self.x + self.width - RIGHT
        y0, y1 = self.y + self.height - BOTTOM, self.y + TOP
        parts = [text(x0, self.y + 18, title, 14, "#111111", weight="bold")]
        for flip in (0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 2, 3, 5):
            if self.least <= flip <= self.most:
                y = self.at({"ms": self.low, "flip": flip})[1]
                parts.append(f'<path d="M{x0} {y:.1f}H{x1}" stroke="#e4e4e4"/>')
                parts.append(text(x0 - 5, y + 4, f"{flip:g}" + ("x" if self.relative else ""), 10, "#555555", "end"))
        for ms in (power * digit for power in (0.1, 1, 10, 100, 1000, 10000, 100000) for digit in ((1, 3) if self.relative else (1,))):
            if not self.low * 0.999 <= ms <= self.high:
                continue
            x = self.at({"ms": ms, "flip": self.most})[0]
            words = f"{ms:g}x" if self.relative else f"{ms:g} ms" if ms < 1000 else f"{ms / 1000:g} s"
            parts.append(f'<path d="M{x:.1f} {y0}V{y1}" stroke="#e4e4e4"/>')
            parts.append(text(x, y0 + 14, words, 10, "#555555", "middle"))
        return parts + [f'<path d="M{x0} {y1}V{y0}H{x1}" fill="none" stroke="#777777"/>']

    def lines(self):
        groups = {}
        for p in self.points:
            groups.setdefault(kind(p), []).append(p)
        for name, points in groups.items():
            if name in ("paths", "denoised", "Cycles", "Mitsuba", "EEVEE"):
                way = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, sorted(points, key=lambda p: p["ms"])))
                dash = ' stroke-dasharray="4 3"' if name == "denoised" else ""
                yield f'<polyline points="{way}" fill="none" stroke="{STYLES[points[0]["family"]][0]}" stroke-opacity="0.45"{dash}/>'

    def name_of(self, p):
        """The label of a point, where there is room for it."""
        if kind(p) == "none" and not self.relative:  # beside those of OpenGL, whose names they have
            return ""
        words, (x, y) = whole_label(p) if self.relative else label(p), self.at(p)
        wide = 5.6 * len(words)
        for dx, dy in ((8, 4), (8, -6), (8, 13), (-8 - wide, 4), (-8 - wide, -6), (-8 - wide, 13), (-wide / 2, -9), (-wide / 2, 17)):
            box = (x + dx, y + dy - 9, x + dx + wide, y + dy + 2)
            inside = self.x + LEFT < box[0] and box[2] < self.x + self.width and box[3] < self.y + self.height - BOTTOM + 1
            if inside and not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in self.taken):
                self.taken.append(box)
                return text(x + dx, y + dy, words, 10, STYLES[p["family"]][0], weight="bold" if p["family"] == "Sideray" else "normal")
        return ""

    def draw(self, title):
        parts = self.axes(title) + list(self.lines())
        ours = [p for p in self.points if p["family"] == "Sideray"]
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, front(ours)))
        parts.append(f'<polyline points="{way}" fill="none" stroke="{STYLES["Sideray"][0]}" stroke-width="2.2" stroke-opacity="0.6"/>')
        order = [p for p in self.points if p["family"] != "Sideray"] + ours
        for p in order:
            x, y = self.at(p)
            self.taken.append((x - 6, y - 6, x + 6, y + 6))
            color, shape = STYLES[p["family"]]
            shape = "triangle" if kind(p) == "paths" else shape
            parts.append(marker(shape, x, y, color, kind(p) in ("none", "denoised")))
        on_front = {id(p) for p in front(self.points)}
        ranked = sorted(self.points, key=lambda p: (p["family"] in ("Cycles", "Mitsuba"), id(p) not in on_front, p["family"] != "Sideray"))
        return parts + [self.name_of(p) for p in ranked]


def legend_entries():
    entries = [("Sideray, OpenGL", "Sideray", "circle", False), ("Sideray, --gl none", "Sideray", "circle", True),
               ("Sideray, paths", "Sideray", "triangle", False)]
    entries += [(name, name, shape, False) for name, (_, shape) in STYLES.items() if name != "Sideray"]
    entries.insert(-1, ("Cycles, denoised", "Cycles", "triangle", True))
    return entries


def legend(x, y, width):
    parts, at = [], x
    for words, family, shape, hollow in legend_entries():
        wide = 24 + 6.4 * len(words)
        if at + wide > x + width:
            at, y = x, y + 20
        parts.append(marker(shape, at + 6, y - 4, STYLES[family][0], hollow))
        parts.append(text(at + 16, y, words, 11.5))
        at += wide
    return parts, y


def document(parts, width, height):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            'font-family="DejaVu Sans, Verdana, Arial, sans-serif"><rect width="100%" height="100%" fill="#ffffff"/>'
            + "\n".join(parts) + "</svg>\n")


def draw(panels, note):
    """panels: {title: points}, each point with family, program, ms and flip."""
    columns = min(COLUMNS, len(panels))
    width = max(columns * WIDTH, 800)
    parts = []
    for i, (title, points) in enumerate(panels.items()):
        parts += Panel(points, i % columns * WIDTH, i // columns * HEIGHT).draw(title)
    y = -(-len(panels) // columns) * HEIGHT
    parts.append(text(LEFT, y + 4, note, 11.5, "#444444"))
    entries, y = legend(LEFT, y + 28, width - 2 * LEFT)
    return document(parts + entries, width, y + 14)


def draw_relative(points, notes):
    """One panel, of large letters: each point's ms and flip are multiples of those of Sideray's defaults."""
    scale, width, height = 1.5, 560, 330
    parts = [f'<g transform="scale({scale})">', *Panel(points, 0, 0, width, height, relative=True).draw("Error over time, as multiples of Sideray's defaults")]
    parts += [text(LEFT, height - 12 + 13 * i, note, 9, "#444444") for i, note in enumerate(notes)]
    return document([*parts, "</g>"], round(scale * width), round(scale * (height + 13 * len(notes) - 12)))


def draw_each(panels, note):
    """The same as pieces of HTML, which stand beside each other where there is room."""
    for title, points in panels.items():
        yield document(Panel(points, 0, 0).draw(title), WIDTH, HEIGHT)
    entries = []
    for words, family, shape, hollow in legend_entries():
        entries.append(f'<svg width="14" height="14" style="width:14px">{marker(shape, 7, 7, STYLES[family][0], hollow)}</svg> {words}')
    yield f'<p class="note">{html.escape(note)}<br>{" &nbsp; ".join(entries)}</p>'
