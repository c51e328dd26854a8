// The options of `render`, in the order of docs/cli.md.
#include "cli/options/render_table.h"

#include "cli/options/comparison.h"

namespace sideray::cli {
namespace {

using Kind = Option::Kind;
using Values = std::vector<std::string>;

Option value(const char* name, const char* placeholder, const char* used, const char* help) {
  return {name, Kind::value, placeholder, {}, used, true, help};
}

// A file or a way of running: not a property of the picture.
Option outside_config(Option option) {
  option.in_config = false;
  return option;
}

Option flag(const char* name, const char* help) {
  return {name, Kind::flag, "", {}, "", true, help};
}

Option choice(const char* name, Values values, const char* used, const char* help) {
  return {name, Kind::choice, "", std::move(values), used, true, help};
}

std::vector<Option> table() {
  std::vector<Option> t;
  t.push_back(outside_config(value("o", "IMAGE", "", "the picture to write, .exr or .png")));
  t.push_back(value("size", "WxH", "1280x720", "pixels"));
  t.push_back(value("camera", "NAME-OR-INDEX", "", "camera of the file; the first one, else the scene is framed"));
  t.push_back(value("eye", "X,Y,Z", "", "a camera here, with --target"));
  t.push_back(value("target", "X,Y,Z", "", "the point it looks at"));
  t.push_back(value("fov", "DEG", "", "its vertical angle of view [45]"));
  t.push_back(choice("gl", {"auto", "egl", "osmesa"}, "auto", "how to reach OpenGL"));
  t.push_back(value("device", "ID", "", "an id from sideray devices"));
  t.push_back(choice("translucency", {"raster", "raytraced", "hybrid", "reference", "off"}, "hybrid",
                     "how translucent surfaces are drawn"));
  t.push_back(
      value("ray-traced", "auto|all|none|GLOB,...|largest:K", "auto", "which objects have layers, hybrid only"));
  t.push_back(value("layers", "N|auto|unlimited", "", "hybrid: 0 to 8 [auto]; raytraced: 1 to 64 or unlimited [2]"));
  t.push_back(
      value("layer-threshold", "E", "0", "radiance that a pixel may be off by for rays of layers that are left out"));
  t.push_back(choice("cache-rate", {"full", "checkerboard", "interleaved", "quarter", "temporal4", "temporal8"}, "full",
                     "which masked pixels are traced"));
  t.push_back(choice("second-wave", {"on", "off"}, "on", "trace what the first rays missed"));
  t.push_back(choice("radiance-format", {"rgba16f", "rgb9e5"}, "rgba16f", "of the layer cache"));
  t.push_back(choice("match", {"id", "nearest", "distance"}, "id", "how a fragment finds its layer"));
  t.push_back(value("match-threshold", "T", "0.001", "match distance: below which share of the distance"));
  t.push_back(choice("step", {"multihit", "retrace", "listing"}, "multihit", "how rays find layers"));
  t.push_back(choice("mask", {"none", "stencil", "count"}, "count", "which pixels to trace"));
  t.push_back(choice("refraction", {"on", "off"}, "off",
                     "solids bend the rays that pass through them; raytraced and reference"));
  t.push_back(choice("rt-particles", {"on", "off"}, "off", "rays meet particles"));
  t.push_back(
      choice("oit", {"sorted", "weighted", "front", "abuffer", "peel"}, "sorted", "order of raster translucency"));
  t.push_back(choice("shadows", {"map", "exact", "inexact", "off"}, "inexact", "shadows on opaque pixels"));
  t.push_back(choice("inexact", {"tmin", "bounded", "restpose"}, "restpose", "which inexact shadows"));
  t.push_back(value("inexact-bias", "B", "0.5", "world units that inexact shadow rays skip at most"));
  t.push_back(choice("inexact-target", {"model", "bit", "stencil"}, "stencil", "what inexact shadows apply to"));
  t.push_back(choice("foliage", {"static", "shared", "unique"}, "shared", "poses of moving foliage"));
  t.push_back(value("shared-copies", "K", "1", "simulations per species"));
  t.push_back(value("unique-cap", "N|none", "256", "most unique poses"));
  t.push_back(value("cull-angle", "DEG", "1", "what looks smaller is not traced"));
  t.push_back(choice("reflections", {"on", "off"}, "off", "reflection rays on opaque surfaces"));
  t.push_back(choice("ao", {"on", "off"}, "off", "ambient occlusion rays on opaque surfaces"));
  t.push_back(choice("denoise", {"on", "off"}, "on", "filter shadows, occlusion and what rough layers reflect"));
  t.push_back(choice("denoise-on", {"auto", "cpu", "gpu"}, "auto", "where shadows and occlusion are filtered"));
  t.push_back(choice("taa", {"on", "off"}, "", "temporal anti-aliasing of a sequence [on]"));
  t.push_back(value("samples", "N", "1", "camera positions per pixel, averaged"));
  t.push_back(value("light-samples", "M", "64", "reference: light and microfacet samples per position"));
  t.push_back(outside_config(value("frames", "A-B", "", "a sequence, with name.####.exr as -o")));
  t.push_back(value("fps", "F", "30", "frames per second of a sequence"));
  t.push_back(value("time", "T", "0", "seconds of a single frame; animations loop"));
  t.push_back(value("animation", "NAME|all", "", "which animation plays [the first]"));
  t.push_back(value("threads", "N", "", "tracing threads [all]"));
  t.push_back(value("seed", "N", "1", "of the random numbers"));
  t.push_back(value("deadline", "MS", "", "rays that have not begun by then are given up"));
  t.push_back(value("max-ms", "X", "", "the most accurate configuration whose frame is predicted to take so long"));
  t.push_back(value("max-error", "E", "", "the cheapest configuration with this mean FLIP, on a reduced frame"));
  t.push_back(value("env", "sky|none|FILE", "sky", "surroundings: a lat-long .exr or .hdr"));
  t.push_back(value("env-scale", "S", "1", "factor on its radiance"));
  t.push_back(value("env-rotate", "DEG", "0", "counter-clockwise about +Y, seen from above"));
  t.push_back(value("exposure", "EV", "0", "stops, PNG only"));
  t.push_back(choice("tonemap", {"none", "reinhard", "aces", "pbr-neutral"}, "pbr-neutral", "PNG only"));
  t.push_back(flag("reference", "everything by rays, exact and unlimited"));
  t.push_back(value("aov", "LIST", "", "more channels, or all; .exr only"));
  t.push_back(outside_config(value("stats", "FILE", "", "write times and counters as JSON")));
  t.push_back(flag("check", "with --stats, hybrid only: count layers that are wrong against all surfaces by rays"));
  t.push_back(value("repeat", "N", "1", "frames timed after one untimed, with --stats"));
  t.push_back(outside_config(value("jobs", "FILE.json", "", "many renders in one process")));
  t.push_back(outside_config(value("shard", "I/N", "", "the I-th of N blocks of the frames, from 0")));
  t.push_back(outside_config(flag("resume", "skip what exists")));
  t.push_back(outside_config(value("warm-up", "F", "16", "temporal methods: unwritten frames before a block")));
  t.push_back(outside_config(value("compare", "REF", "", "metrics of the picture against this one")));
  for (Option& option : comparison_options()) t.push_back(outside_config(std::move(option)));
  return t;
}

}  // namespace

const std::vector<Option>& render_table() {
  static const std::vector<Option> options = table();
  return options;
}

}  // namespace sideray::cli
