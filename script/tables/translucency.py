"""translucency.py DIR: the chart of script/translucency_table as a Markdown table."""
import json
import os
import sys

STAGES = ["gbuffer", "shadow_map", "mask", "readback", "trace", "denoise", "upload", "light", "composite",
          "total_frame"]
SHOWN = ("translucency", "layers", "cache-rate", "mask", "oit", "ray-traced")
# What a row does not say: the values that most rows share.
USUAL = {"cache-rate": "full", "mask": "count", "oit": "sorted", "ray-traced": "auto"}


def title(config):
    words = []
    for option in SHOWN:
        value = config.get(option)
        if value is None or value == USUAL.get(option):
            continue
        if option == "layers":
            words.append("%s %s" % (value, "events" if config["translucency"] == "raytraced" else "layers"))
        else:
            words.append(("mask %s" if option == "mask" else "%s") % value)
    return ", ".join(words)


def cells(name, stats, error, front):
    rays, layers = stats["rays"], stats.get("layers", {})
    return [name, *("%.1f" % stats["stages_ms"][stage] for stage in STAGES), "{:,}".format(rays["primary"]),
            "{:,}".format(rays["total"]), "{:,}".format(layers.get("missed", 0)) if "missed" in layers else "",
            "%.4f" % error["flip"], "%.4f" % error["hdr_flip"], front]


with open(os.path.join(sys.argv[1], "results.json"), encoding="utf-8") as stream:
    results = json.load(stream)
table = [["", *(stage.replace("_", " ") for stage in STAGES), "primary rays", "all rays", "missed", "FLIP", "HDR-FLIP",
          "front"]]
for row in results["rows"]:
    table.append(cells(title(row["config"]), row, row["error"], "*" if row["pareto"] else ""))
print("| " + " | ".join(table[0]) + " |")
print("|---" * len(table[0]) + "|")
for row in table[1:]:
    print("| " + " | ".join(row) + " |")
row = results["rows"][0]
print("\n%s, %s; reference of %d light samples, self-error %.4f." % (
    row["device"]["renderer"], row["config"]["size"], results["reference"]["light_samples"],
    results["reference"].get("self_error", float("nan"))))
