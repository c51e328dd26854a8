#!/usr/bin/python3
"""Writes docs/robustness.md, the robustness atlas, from what `sideray stress` counts on every device that is there.

  script/tables/robustness.py [--program build/sideray] [--results DIR] [--full] [--cases A,B] [--without-gl] [--page docs/robustness.md]

Runs `sideray stress` for each column that DIR has no results of: Mesa's llvmpipe with each instruction set of Embree that
this processor has. --full takes every value and 96x54 pixels instead of the few of --quick: 15 minutes of one core or more instead of 3. --cases measures some alone.

Columns of other machines: `sideray stress --quick --shard 0/1 -o NVIDIA-H200` there, then that folder (its rows/ is enough) into DIR. Each
folder that is none of this machine's columns is shown beside them, under its name with spaces for dashes, and is not run.

--without-gl measures what rays alone do and writes that section alone; the rest of the page stays.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What somebody sees, why, what to choose, and the measures that tell: a case, and the variants that the choice is about
# ("" = those of the default).
SYMPTOMS = [
    ("Glass flickers at a distance", "panes are closer together than the tolerance of matching", "a surface id for each surface and "
     "`--diagnose match=id`, the default; `match=nearest` only where surfaces have no ids", ["match-distance", "match-gap"]),
    ("Glass or a shadow flickers at rest", "one random direction a pixel, new in each frame", "`--denoise on` and `--taa on` together, "
     "the defaults of sequences", ["settling"]),
    ("A pane shows the colours of the pane behind it", "the threshold on distances is wider than the gap", "`--diagnose match=id`; a larger near "
     "plane does not help", ["match-gap", "match-near", "match-incidence"]),
    ("The third pane, or a thin wall, is missing", "listing 50-1 adds distances up, and a ray that starts again misses or hits twice",
     "`--diagnose step=multihit`, the default, or `retrace`", ["layer-gap", "layer-count", "ray-layers"]),
    ("Panes in one plane fight", "no distance tells them apart", "`step=multihit`: they come in the order of their ids", ["coplanar"]),
    ("Layers are lost on scaled or mirrored objects", "distances in object space are compared with those in world space", "`step=multihit`",
     ["instance-scale"]),
    ("Things far from the origin jitter or lose layers", "floats have 24 bits", "nothing: positions are kept in double precision", ["world-offset"]),
    ("A plain floor has specks of shadow", "the depth at which the ray starts is rounded", "nothing: rays start beyond the error of the "
     "depth format; `shadow_bias_steps` for depth less exact than its format", ["self-shadow", "depth-format"]),
    ("Plants in the wind shadow themselves", "rays hit the plant at rest", "`--inexact restpose`, the default; `bounded` and `tmin` fail too",
     ["wind-gap"]),
    ("Things float: shadows are missing where they touch the ground", "the inexact test ignores hits close to the ray's start",
     "`--inexact restpose`, or `--diagnose inexact-target` so that the ground is tested exactly", ["contact"]),
    ("Leaves cast too much or too little shadow", "a texel of a shadow map is larger than a leaf", "`--shadows exact` or `inexact`",
     ["leaves"]),
    ("A shadow trails behind its caster", "denoising and anti-aliasing average over frames", "`--taa off` where ghosts matter more than edges",
     ["settling"]),
    ("Moving glass shows colours of its previous place", "a host takes layers a frame late", "`sideray_translucent_moving`", ["late-glass"]),
    ("A room glows behind a thin wall, or light trails behind a lamp or a door", "pixels share light that bounces, and reuse it over frames",
     "`--ambient bounce`, the default, whose rays test for occluders between; `ao` lacks the light of other surfaces", ["bounce"]),
    ("A mesh with broken triangles lets rays through", "degenerate or non-finite triangles", "nothing: these are dropped, the rest stays",
     ["broken-triangles"]),
]


ALONE = "rays-alone"
ALONE_HEAD = "## Without OpenGL"


def isas():
    flags = pathlib.Path("/proc/cpuinfo").read_text().split() if os.path.exists("/proc/cpuinfo") else []
    found = [name for name, flag in (("sse4.2", "sse4_2"), ("avx2", "avx2"), ("avx512", "avx512vl")) if flag in flags]
    return found or ["default"]


def columns():
    return [(f"llvmpipe, Embree {isa}", {"GALLIUM_DRIVER": "llvmpipe", "LIBGL_ALWAYS_SOFTWARE": "1", "SIDERAY_ISA": isa}) for isa in isas()]


def folder_of(column):
    return column.replace(", Embree ", "-").replace(" ", "-")


def brought(results, own):
    """The folders of other machines' results, by the names of their columns."""
    if not results.is_dir():
        return {}
    return {f.name.replace("-", " "): f for f in sorted(results.iterdir()) if (f / "rows").is_dir() and f.name not in own}


def restore(folder, full, cases):
    """The rows that another machine brought, and its device."""
    rows, devices = [], set()
    for kept in sorted((folder / "rows").glob("*.json")):
        content = json.loads(kept.read_text())
        if content["quick"] == full:
            sys.exit(f"{kept}: was measured {'with' if full else 'without'} --quick; run sideray stress "
                     f"{'without' if full else 'with'} it, or this script {'without' if full else 'with'} --full")
        if not cases or kept.stem in cases:
            rows += content["rows"]
            devices.add(content["device"])
    return judged(rows), "; ".join(sorted(devices))


def judged(rows):
    for row in rows:
        row["pass"] = row["value"] is not None and row["value"] <= row["bound"]
        row.pop("map", None)
    return rows


def defaults_of(rows):
    return {(row["name"], row["variant"]) for row in rows if row.get("default")}


def measure(program, folder, environment, full, cases):
    """The rows of one column and why cases ended without any; drawn where there are none."""
    environment = {**os.environ, **{k: v for k, v in environment.items() if v != "default"}, "SIDERAY_CACHE": "off"}
    listed = subprocess.run([program, "stress", "--list"], env=environment, capture_output=True, text=True, check=True).stdout
    rows, ended = [], {}
    for case in (line.split()[0] for line in listed.splitlines()):
        if cases and case not in cases:
            continue
        kept = folder / "rows" / f"{case}.json"
        if not kept.exists():
            command = [program, "stress", case, "-o", str(folder), "--threads", "1", "--shard", "0/1"] + ([] if full else ["--quick"])
            run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
            ended[case] = run.stderr.strip().splitlines()[-1:] if not kept.exists() else []
        if kept.exists():
            rows += json.loads(kept.read_text())["rows"]
    return judged(rows), {c: m[0] for c, m in ended.items() if m}


def fails(said):
    return said not in ("holds", "not run")


def grouped(rows):
    """{(case, measure, variant): rows}, in the order of the file."""
    table = {}
    for row in rows:
        table.setdefault((row["name"], row["measure"], row["variant"]), []).append(row)
    return table


def verdict(rows):
    if rows is None:
        return "not run"
    failed = [row for row in rows if not row["pass"]]
    if not failed:
        return "holds"
    return f"{len(failed)} of {len(rows)}, {max(row['value'] for row in failed):.3g}"


def merged(names, tables):
    """Columns whose every row is the same become one."""
    groups = []
    for name, table in zip(names, tables):
        for group in groups:
            if group[1] == table:
                group[0].append(name)
                break
        else:
            groups.append(([name], table))
    return groups


def title(names):
    first, *others = names
    return first + "".join(", " + name.split("Embree ")[-1] if "Embree" in name else " = " + name for name in others)


def symptom_lines(groups, defaults):
    rows_of, all_hold = [], True
    for seen, why, choose, cases in SYMPTOMS:
        held = []
        for names, table in groups:
            rows = [r for key, of in table.items() if key[0] in cases and (key[0], key[2]) in defaults for r in of]
            bad = sum(not r["pass"] for r in rows)
            missing = [case for case in cases if not any(key[0] == case for key in table)]
            answer = "" if not rows else "yes" if bad == 0 else f"**no**, {bad} of {len(rows)}"
            answer += ("; " if answer and missing else "") + (f"{', '.join(missing)} not run" if missing else "")
            held.append((names[0].split(',')[0], answer or "no variant is the default"))
        said = {answer for _, answer in held}
        together = said.pop() if len(said) == 1 else "; ".join(f"{name}: {answer}" for name, answer in held)
        all_hold = all_hold and together == "yes"
        rows_of.append((seen, why, choose, together, ", ".join(cases)))
    yield "The defaults hold in every row." if all_hold else "The defaults do not hold everywhere."
    yield ""
    yield "| what you see | because | choose | " + ("" if all_hold else "defaults hold | ") + "cases |"
    yield "|---|---|---|" + ("" if all_hold else "---|") + "---|"
    for seen, why, choose, together, cases in rows_of:
        yield f"| {seen} | {why} | {choose} | " + ("" if all_hold else f"{together} | ") + f"{cases} |"


def limit_of(bounds):
    limits = sorted({f"{b:.3g}" for b in bounds}, key=float)
    return limits[0] if len(limits) == 1 else f"{limits[0]} to {limits[-1]}"


def verdicts(key, groups):
    """Returns how a variant fails in each column, once where columns agree; empty where it fails nowhere."""
    columns = {}
    for names, table in groups:
        if key in table:
            columns.setdefault(verdict(table[key]), []).append(names[0].split(",")[0])
    if not any(map(fails, columns)):
        return ""
    everywhere = [names[0].split(",")[0] for names, _ in groups]
    return "; ".join(said if names == everywhere else f"{', '.join(names)}: {said}" for said, names in columns.items())


def counted(measured, bounds):
    """What is counted, and the bound where it is not 0. Most are shares."""
    limit = limit_of(bounds)
    return measured.removesuffix(", share") + (f" ({limit})" if limit != "0" else "")


def variant_name(variant):
    return f"`{variant.replace('--diagnose ', '')}`"


def case_lines(groups, defaults, bounds):
    """A row for each case and measure that some variant fails, and the measures that none fails."""
    yield "Shares; the bound is 0, or stands in brackets. A variant that fails has the number of values that fail, and the worst. All others hold."
    yield ""
    yield "| case | counted | fails |"
    yield "|---|---|---|"
    keys = list(dict.fromkeys(key for _, table in groups for key in table))
    unfailed = {}
    for case, measured in sorted(dict.fromkeys(key[:2] for key in keys), key=lambda pair: pair[0]):
        failing = []
        for key in (key for key in keys if key[:2] == (case, measured)):
            said = verdicts(key, groups)
            if said:
                failing.append(f"{variant_name(key[2])}{' (default)' if (case, key[2]) in defaults else ''}: {said}")
        what = counted(measured, bounds[case, measured])
        if failing:
            yield f"| {case} | {what} | {'<br>'.join(failing)} |"
        else:
            unfailed.setdefault(case, []).append(what)
    if unfailed:
        yield from ("", "No variant fails:", "", *(f"- {case}: {'; '.join(what)}" for case, what in unfailed.items()))
    yield ""


def other_machines(devices):
    if not devices:
        return ["There is no column of a hardware driver (NVIDIA, AMD, Intel): this page was made on a machine without one, and no",
                "results of another were brought to it."]
    return [f"Measured elsewhere, by the same cases: {'; '.join(devices.values())}."]


def page(groups, defaults, ended, command, size, devices):
    bounds = {}
    for _, table in groups:
        for key, rows in table.items():
            bounds.setdefault(key[:2], []).extend(row["bound"] for row in rows)
    lines = ["# Robustness atlas", "",
             "Where methods fail, and what to choose.",
             "", f"Written by `{command}` from [`sideray stress`](cli.md#stress), {size}.",
             "A case sweeps one value and counts errors against a closed form or an exact oracle; a method holds if every value is within the",
             "bound. NAME=VALUE is of `--diagnose`; listings are those of Ray Tracing Gems II, as printed.", "",
             f"Drivers: {'; '.join(title(names) for names, _ in groups)}.",
             *other_machines(devices), "", "## What you see, and what to choose", ""]
    lines += list(symptom_lines(groups, defaults))
    lines += ["", *SOFTPIPE, "", "## Counts", ""]
    lines += list(case_lines(groups, defaults, bounds))
    if ended:
        lines += ["## Cases that ended without counts", "", *[f"- {line}" for line in ended]]
    return "\n".join(lines).rstrip() + "\n"


def counts_of(text):
    """{(case, what is counted, variant): how it fails} of the page's table."""
    rows = re.findall(r"^\| ([\w-]+) \| ([^|]+) \| (`[^|]+) \|$", text[text.index("## Counts"):], re.MULTILINE)
    found = {}
    for case, what, cell in rows:
        for variant in cell.split("<br>"):
            name, said = re.fullmatch(r"(`[^`]+`)(?: \(default\))?: (.*)", variant).groups()
            found[case, re.sub(r" \([\d. to]+\)$", "", what), name] = said
    return found


def alone_lines(program, results, full, text):
    """Returns how rays alone differ from the page's counts."""
    environment = {"SIDERAY_GL": "none"}
    rows, ended = measure(program, results / ALONE, environment, full, [])
    listed = subprocess.run([program, "stress", "--list"], capture_output=True, text=True, check=True).stdout
    cases = [line.split()[0] for line in listed.splitlines()]
    meaningless = [case for case in cases if not any(row["name"] == case for row in rows) and case not in ended]
    table, defaults, others = grouped(rows), defaults_of(rows), counts_of(text)
    failing = sorted({case for (case, _, variant), of in table.items() if (case, variant) in defaults and fails(verdict(of))})
    differ = []
    for (case, measured, variant), of in table.items():
        said, other = verdict(of), others.get((case, counted(measured, [0]), variant_name(variant)), "holds")
        if said != other and (case, variant) not in defaults:
            differ.append(f"{variant_name(variant)} of {case} ({said})")
    yield ALONE_HEAD
    yield ""
    yield "With `--gl none` values have the same bits for each instruction set. In wind-gap and contact nothing is inexact, since rays hit the drawn"
    yield f"pose; {', '.join(meaningless)} do not apply, since no fragment looks up layers."
    yield f"The defaults {'fail in ' + ', '.join(failing) if failing else 'hold in all cases'}. Other methods fail as counted below" + (
        f", except {', '.join(differ)}." if differ else ".")
    yield ""
    if ended:
        yield "; ".join(f"{case}: {message}" for case, message in ended.items()) + "."
        yield ""


def with_section(text, lines):
    """The page with these lines in the place of the section, or before the counts."""
    section = "\n".join(lines) + "\n"
    begin = text.find(ALONE_HEAD)
    end = text.index("## Counts")
    return (text[:begin] if begin >= 0 else text[:end]) + section + text[end:]


SOFTPIPE = """**Do not use softpipe** (`GALLIUM_DRIVER=softpipe`). It has no `gl_PrimitiveID` without a geometry shader, so every opaque pixel
reads as empty, without an OpenGL error. `sideray` warns of it, and `sideray devices` names the driver.""".split("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build" / "sideray"))
    parser.add_argument("--results", default=str(ROOT / "build" / "robustness"))
    parser.add_argument("--page", default=str(ROOT / "docs" / "robustness.md"))
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--cases", default="")
    parser.add_argument("--without-gl", action="store_true")
    given = parser.parse_args()
    path = pathlib.Path(given.page)

    def completed(text):
        return with_section(text, alone_lines(given.program, pathlib.Path(given.results), given.full, text))

    if given.without_gl:
        return path.write_text(completed(path.read_text()))
    results, cases = pathlib.Path(given.results), [case for case in given.cases.split(",") if case]
    names, tables, defaults, ended, devices = [], [], set(), [], {}
    for name, environment in columns():
        rows, failed = measure(given.program, results / folder_of(name), environment, given.full, cases)
        names.append(name), tables.append(grouped(rows))
        defaults |= defaults_of(rows)
        ended += [f"{name}, {case}: {message}" for case, message in failed.items()]
    # A driver of another machine comes first: it is what most readers have.
    for name, folder in reversed(brought(results, {ALONE, *(folder_of(name) for name, _ in columns())}).items()):
        rows, devices[name] = restore(folder, given.full, cases)
        names.insert(0, name), tables.insert(0, grouped(rows))
        defaults |= defaults_of(rows)
    command = "script/tables/robustness.py" + (" --full" if given.full else "")
    size = "pictures of 96x54 pixels" if given.full else "`--quick`: few values, pictures of 48x27 pixels"
    return path.write_text(completed(page(merged(names, tables), defaults, ended, command, size, devices)))


if __name__ == "__main__":
    main()
