# %% [markdown]
# # Time against error
# A scene is drawn in several ways and compared with its reference: chart.py [SCENE] [WIDTH HEIGHT] [CHART.png]
# Run it whole, or cell by cell in an editor that knows `# %%`. matplotlib is optional: without it the table is all.

# %%
import sys

import sideray

words = sys.argv[1:] if "ipykernel" not in sys.modules else []
scene = sideray.load(words[0] if words else "panes")
size = (int(words[1]), int(words[2])) if len(words) > 2 else (320, 180)
renderer = sideray.Renderer()
print("drawn by", renderer.device["renderer"])

# %% [markdown]
# ## The reference
# Everything by rays, with light and surroundings sampled. `picture` shows itself in a notebook.

# %%
reference = renderer.render(scene, size, reference=True, light_samples=16)
reference

# %% [markdown]
# ## The ways to draw it
# Options are those of the command line. The reference is that of one bounce, which has neither ambient occlusion nor, on what is
# opaque, mirrors.

# %%
ways = {
    "off": {"translucency": "off"},
    "raster": {"translucency": "raster"},
    "hybrid, 1 layer": {"layers": 1},
    "hybrid, 4 layers": {"layers": 4},
    "hybrid, quarter rate": {"layers": 4, "cache_rate": "quarter"},
    "raytraced, 4 surfaces": {"translucency": "raytraced", "layers": 4},
}
points = {}
for name, options in ways.items():
    picture = renderer.render(scene, size, repeat=3, ambient=False, reflections=False, **options)
    milliseconds = picture.times["total_frame"][1]
    points[name] = milliseconds, sideray.compare(picture, reference)["flip"]
    print(f"{name:24}{points[name][0]:9.2f} ms   FLIP {points[name][1]:.4f}")

# %% [markdown]
# ## The chart

# %%
try:
    import matplotlib

    if "ipykernel" not in sys.modules:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit(print("matplotlib is not installed: no chart (Debian: python3-matplotlib)", file=sys.stderr))

figure, axes = plt.subplots(figsize=(7, 4.5))
for name, (milliseconds, error) in points.items():
    axes.scatter(milliseconds, error, label=name)
axes.set(xlabel="milliseconds a frame", ylabel="mean FLIP against the reference", xscale="log", ylim=(0, None),
         title=f"{words[0] if words else 'panes'}, {size[0]}x{size[1]}")
axes.legend()
figure.tight_layout()
figure.savefig(words[3] if len(words) > 3 else "chart.png", dpi=120)
