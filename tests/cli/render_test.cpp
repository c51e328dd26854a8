#include <cmath>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class Render : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }
  void render(const std::string& arguments) {
    const Outcome outcome = run("render " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.output, "");
  }
  void bench(const std::string& arguments) {
    const Outcome outcome = run("bench " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
  }
  json stats(const std::string& name) const { return json::parse(text_of(path(name))); }
};

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

void expect_no_null(const json& value) {
  EXPECT_FALSE(value.is_null());
  if (value.is_structured())
    for (const json& part : value) expect_no_null(part);
}

TEST_F(Render, EveryTranslucencyGivesAPicture) {
  for (const char* mode : {"off", "raster", "hybrid", "hybrid --layers 0", "raytraced", "raytraced --layers unlimited"})
    render("panes -o x.png --size 64x36 --translucency " + std::string(mode));
  const scenes::Image image = scenes::read_image(path("x.png"));
  EXPECT_EQ(image.width, 64u);
  EXPECT_EQ(image.height, 36u);
}

TEST_F(Render, StatsFollowTheSchema) {
  render("panes -o x.exr --size 64x36 --layers 3 --threads 1 --stats s.json");
  const json s = stats("s.json");
  expect_no_null(s);
  EXPECT_EQ(s["schema"], 1);
  EXPECT_EQ(keys(s["scene"]), (std::vector<std::string>{"instances", "materials", "translucent_objects", "triangles"}));
  EXPECT_EQ(s["scene"]["translucent_objects"], 4);
  EXPECT_EQ(keys(s["stages_ms"]), (std::vector<std::string>{"build", "denoise", "load", "total_frame", "trace",
                                                            "trace_ao", "trace_shadow", "update"}));
  for (const char* stage : {"load", "build", "trace", "total_frame"})
    EXPECT_GT(s["stages_ms"][stage].get<double>(), 0.0) << stage;
  for (const char* measured : {"p25", "p75", "repeats", "raw_frame"}) EXPECT_FALSE(s.contains(measured)) << measured;
  EXPECT_EQ(keys(s["device"]), (std::vector<std::string>{"embree", "gl", "isa", "renderer", "threads", "version"}));
  EXPECT_EQ(s["device"]["threads"], 1);
  EXPECT_EQ(s["config"]["layers"], 3);
  EXPECT_EQ(s["config"]["translucency"], "hybrid");
  EXPECT_EQ(s["config"]["shadows"], "inexact");
  EXPECT_EQ(s["config"]["poses"], 16);
  EXPECT_EQ(s["config"]["denoise"], "on");
  EXPECT_EQ(s["config"]["oit"], "sorted");
}

// The picture's counters equal those of its repeats, which draw the same frame.
TEST_F(Render, StatsAreOfTheFrameThatIsDrawn) {
  for (const char* mode : {"hybrid --shadows exact", "raytraced", "reference --light-samples 2"}) {
    const std::string scene = "panes --size 64x36 --translucency " + std::string(mode);
    render(scene + " -o x.exr --stats s.json");
    render(scene + " -o y.exr");
    EXPECT_EQ(text_of(path("x.exr")), text_of(path("y.exr"))) << mode;
    bench(scene + " -o y.exr --repeat 2 --json b.json");
    EXPECT_EQ(text_of(path("x.exr")), text_of(path("y.exr"))) << mode;
    const json drawn = stats("s.json"), timed = stats("b.json");
    for (const char* same : {"scene", "rays", "pixels"}) EXPECT_EQ(drawn[same], timed[same]) << mode << same;
    // A renderer's first picture uploads data that later ones reuse.
    for (const char* same : {"cache", "readback"}) EXPECT_EQ(drawn["bytes"][same], timed["bytes"][same]) << mode << same;
    for (const auto& [key, value] : drawn["layers"].items()) EXPECT_EQ(value, timed["layers"][key]) << mode << key;
    EXPECT_FALSE(drawn["layers"].contains("matched"));
  }
}

TEST_F(Render, CountersAgreeWithEachOther) {
  bench("panes --size 64x36 --layers 3 --repeat 1 --json s.json");
  const json s = stats("s.json");
  const json &rays = s["rays"], &layers = s["layers"], &pixels = s["pixels"];
  EXPECT_EQ(rays["total"].get<int64_t>(), rays["primary"].get<int64_t>() + rays["reflection"].get<int64_t>() +
                                              rays["shadow"].get<int64_t>() + rays["ao"].get<int64_t>() + rays["bounce"].get<int64_t>());
  EXPECT_EQ(pixels["total"], 64 * 36);
  // Four equal panes over about half the picture, of which three layers are asked for.
  EXPECT_GT(pixels["masked"].get<int>(), 64 * 36 / 4);
  EXPECT_NEAR(layers["requested"].get<double>(), 3.0 * pixels["masked"].get<double>(),
              0.1 * layers["requested"].get<double>());
  EXPECT_LE(layers["found"], layers["requested"]);
  EXPECT_FALSE(layers.contains("misassigned"));
}

TEST_F(Render, MatchersSteppersAndTheirCheck) {
  struct Case {
    const char* options;
    bool misassigns, loses;
  };
  // Panes are a fifteenth of their distance apart: a large threshold of listing 50-2 merges them, and listing 50-1
  // skips all but the first two. Whole pixels are off, since their fragments look nothing up.
  for (const Case& c : {Case{"", false, false}, Case{"--diagnose match=nearest", false, false},
                        Case{"--diagnose match=distance,match-threshold=0.1", true, false},
                        Case{"--diagnose step=retrace", false, false}, Case{"--diagnose step=listing", false, true}}) {
    render("'panes' -o x.exr --size 64x36 --layers 4 --diagnose whole-pixels=off,check --stats s.json " +
           std::string(c.options));
    const json layers = stats("s.json")["layers"];
    EXPECT_EQ(layers["misassigned"] > 0, c.misassigns) << c.options;
    EXPECT_EQ(layers["duplicated"], 0) << c.options;
    EXPECT_EQ(layers["found"] < layers["requested"].get<double>() * 0.9, c.loses) << c.options;
  }
}

TEST_F(Render, RasterHasNoLayers) {
  render("panes -o x.exr --size 32x18 --translucency raster --shadows map --ambient off --stats s.json");
  const json s = stats("s.json");
  EXPECT_FALSE(s.contains("layers"));
  EXPECT_FALSE(s.contains("bytes"));
  EXPECT_EQ(s["rays"]["total"], 0);
  for (const char* option : {"layers", "ray-traced", "mask", "cache-rate", "match", "step", "light-samples"})
    EXPECT_FALSE(s["config"].contains(option)) << option;
  EXPECT_EQ(s["config"]["oit"], "sorted");
}

TEST_F(Render, ConfigHasOnlyWhatTheModeUses) {
  render("panes -o x.exr --size 32x18 --translucency off --stats s.json");
  const json off = stats("s.json")["config"];
  for (const char* option : {"layers", "ray-traced", "mask", "oit"}) EXPECT_FALSE(off.contains(option)) << option;
  render("panes -o x.exr --size 32x18 --translucency raytraced --layers unlimited --stats s.json");
  const json raytraced = stats("s.json")["config"];
  for (const char* option : {"ray-traced", "cache-rate", "match", "oit", "light-samples", "bounces"})
    EXPECT_FALSE(raytraced.contains(option)) << option;
  EXPECT_EQ(raytraced["layers"], "unlimited");
  EXPECT_EQ(raytraced["mask"], "count");
  EXPECT_EQ(raytraced["refraction"], "on");
}

TEST_F(Render, AReferenceStatesItsOwnError) {
  render(
      "panes -o x.exr --size 32x18 --reference --samples 2 --light-samples 4 --seed 3 --shadows off --stats s.json "
      "--aov all");
  const json s = stats("s.json");
  EXPECT_EQ(s["reference"]["light_samples"], 4);
  EXPECT_EQ(s["reference"]["bounces"], 1);
  EXPECT_GT(s["reference"]["self_error"], 0.0);
  EXPECT_GT(s["reference"]["firefly_share"], 0.0);
  EXPECT_LE(s["reference"]["firefly_share"], 1.0);
  EXPECT_EQ(s["config"]["reference"], true);
  EXPECT_EQ(s["config"]["translucency"], "reference");
  EXPECT_FALSE(s["pixels"].contains("masked"));
  EXPECT_EQ(s["config"]["light-samples"], 4);
  EXPECT_EQ(s["config"]["shadows"], "off");
  EXPECT_EQ(s["rays"]["shadow"], 0);
  EXPECT_GE(s["rays"]["primary"], 2 * 2 * 32 * 18);  // opaque and translucent surfaces, at two positions
  EXPECT_GT(s["stages_ms"]["trace"], 0.0);
  EXPECT_EQ(s["stages_ms"]["trace"], s["stages_ms"]["total_frame"]);
  std::vector<std::string> names;
  for (const scenes::Plane& plane : scenes::read_image(path("x.exr")).planes) names.push_back(plane.name);
  for (const char* name : {"Z", "N.X", "albedo.G", "material.roughness", "id.surface", "id.primitive"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

TEST_F(Render, ReferencesFollowLightAsFarAsAsked) {
  const auto rays = [&](const std::string& options) {
    render("solids -o x.exr --size 16x9 --light-samples 2 --stats s.json " + options);
    return stats("s.json")["rays"]["total"].get<uint64_t>();
  };
  for (const std::string method : {"--reference", "--translucency reference"}) {
    const uint64_t once = rays(method);
    EXPECT_LT(once, rays(method + " --bounces 2"));
    EXPECT_EQ(stats("s.json")["reference"]["bounces"], 2);
    rays(method + " --bounces unlimited");
    EXPECT_EQ(stats("s.json")["reference"]["bounces"], "unlimited");
    EXPECT_EQ(stats("s.json")["config"]["bounces"], "unlimited");
  }
  const Outcome refused = run("render solids -o x.exr --bounces 2");
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.errors.find("bounces: only references follow light further"), std::string::npos) << refused.errors;
}

TEST_F(Render, OnlyTheLayersAsInTheReference) {
  bench("panes --size 32x18 --translucency reference --light-samples 4 --repeat 1 --json s.json");
  const json s = stats("s.json");
  EXPECT_EQ(s["reference"]["light_samples"], 4);
  EXPECT_GT(s["reference"]["self_error"], 0.0);
  EXPECT_EQ(s["config"]["translucency"], "reference");
  EXPECT_GT(s["layers"]["found"], 0);
  EXPECT_FALSE(s["pixels"].contains("masked"));
  EXPECT_EQ(s["repeats"], 1);
  EXPECT_GT(s["stages_ms"]["gbuffer"], 0.0);
  // The frame's total is the sum of its stages, since it is drawn once.
  double sum = 0;
  for (const auto& [stage, ms] : s["stages_ms"].items())
    if (stage != "load" && stage != "build" && stage != "total_frame" && stage != "kept_frame") sum += ms.get<double>();
  EXPECT_NEAR(s["stages_ms"]["total_frame"].get<double>(), sum, 1e-6);
}

TEST_F(Render, RefractionCountsWhereRaysAreComposited) {
  for (const char* mode : {"--translucency raytraced --layers unlimited", "--translucency reference --light-samples 1",
                           "--reference --light-samples 1"}) {
    double found[2];
    for (const bool on : {false, true}) {
      render(std::string("solids -o ") + (on ? "on" : "off") + ".exr --size 64x36 --stats s.json " + mode +
             (on ? "" : " --refraction off"));
      const json s = stats("s.json");
      EXPECT_EQ(s["config"]["refraction"], on ? "on" : "off");
      found[on] = s["layers"]["found"].get<double>();
    }
    EXPECT_GT(found[1], found[0]) << mode;  // total reflections are hit too
    const scenes::Image straight = scenes::read_image(path("off.exr")), bent = scenes::read_image(path("on.exr"));
    EXPECT_NE(straight.find("R")->values, bent.find("R")->values) << mode;
  }
}

TEST_F(Render, ConfigNamesEveryOptionOfTheMode) {
  render("panes -o x.exr --size 32x18 --stats s.json --aov Z,id.surface");
  const json config = stats("s.json")["config"];
  for (const char* option : {"size",         "camera",       "quality",
                             "gl",           "device",
                             "translucency", "ray-traced",
                             "layers",       "cache-rate",
                             "second-wave",
                             "match",        "match-threshold",
                             "step",         "mask",
                             "oit",          "shadows",
                             "whole-pixels", "ray-reuse",
                             "poses",        "cull-angle",
                             "reflections",  "ambient",
                             "denoise",      "taa",
                             "samples",
                             "fps",          "time",
                             "threads",      "seed",
                             "env",          "env-scale",
                             "env-rotate",   "exposure",
                             "tonemap",      "reference",
                             "aov",          "check"})
    EXPECT_TRUE(config.contains(option)) << option;
  EXPECT_EQ(config["size"], "32x18");
  EXPECT_EQ(config["aov"], "Z,id.surface");
}

TEST_F(Render, ConfigHasTheRayReuseThatWasUsed) {
  const auto used = [&](const std::string& options) {
    render("panes -o x.png --size 32x18 --stats s.json " + options);
    return stats("s.json");
  };
  const json by_default = used("");
  EXPECT_EQ(by_default["config"]["ray-reuse"], 0x1p-6);
  EXPECT_GT(by_default["layers"]["borrowed"], 0);
  EXPECT_EQ(used("--exposure 2")["config"]["ray-reuse"], 0x1p-8);
  EXPECT_EQ(used("--cache-rate quarter")["config"]["ray-reuse"], 0);
  const json off = used("--ray-reuse 0");
  EXPECT_EQ(off["config"]["ray-reuse"], 0);
  EXPECT_FALSE(off["layers"].contains("borrowed"));
}

TEST_F(Render, ConfigHasWhatAutoComesTo) {
  const auto used = [&](const std::string& options) {
    render(options + " -o x.png --size 32x18 --stats s.json");
    const json config = stats("s.json")["config"];
    return config["ambient"].get<std::string>() + " " + config["reflections"].get<std::string>();
  };
  EXPECT_EQ(used("empty"), "bounce on");
  EXPECT_EQ(used("empty --env none"), "bounce on");
  EXPECT_EQ(used("empty --env-scale 0.01"), "bounce on");
  EXPECT_EQ(used("panes"), "bounce off") << "nothing opaque is smooth";
  EXPECT_EQ(used("empty --ambient off --reflections off"), "off off");
  EXPECT_EQ(used("panes --env none --ambient ao --reflections on"), "ao on");
  EXPECT_EQ(used("empty --reference --light-samples 1"), "off off");
  EXPECT_EQ(used("empty --max-error 1"), "off off") << "errors are those to the light of one bounce";
}

TEST_F(Render, ExrHoldsWhatWasAskedFor) {
  render("panes -o x.exr --size 32x18 --layers 2 --aov Z,id.surface,layer1");
  const scenes::Image image = scenes::read_image(path("x.exr"));
  std::vector<std::string> names;
  for (const scenes::Plane& plane : image.planes) names.push_back(plane.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"A", "B", "G", "R", "Z", "id.surface", "layer1.B", "layer1.G", "layer1.R",
                                             "layer1.distance", "layer1.surface"}));
  EXPECT_EQ(image.find("R")->type, scenes::Plane::Type::half);
  EXPECT_EQ(image.find("Z")->type, scenes::Plane::Type::single);
  EXPECT_EQ(image.find("id.surface")->type, scenes::Plane::Type::uint);
  EXPECT_EQ(image.find("layer1.surface")->type, scenes::Plane::Type::uint);
}

TEST_F(Render, LayersZeroIsRaster) {
  render("panes -o a.exr --size 64x36 --layers 0");
  render("panes -o b.exr --size 64x36 --translucency raster");
  EXPECT_EQ(run("compare a.exr b.exr --fail-above 0 --metric relmse").exit_code, 0);
}

// With a budget that is spent before any ray, the jobs of a sequence take turns: of four frames, each traces in one.
TEST_F(Render, ABudgetThatIsSpentGoesOnInTurns) {
  render("panes -o b.####.exr --size 160x90 --frames 0-18 --budget 0.001 --stats b.json");
  std::istringstream lines(text_of(path("b.json")));
  std::string line;
  std::vector<uint64_t> late;
  while (std::getline(lines, line)) {
    const json frame = json::parse(line);
    EXPECT_GT(frame["rays"]["total"], 0);
    EXPECT_GT(frame["starved"], 0);
    late.push_back(frame["pixels"]["late"]);
  }
  ASSERT_EQ(late.size(), 19u);
  // From the third frame on the view counts as still, and continues at its first position: glass goes on in its turns,
  // and what is moved along to it in between may lose pixels.
  EXPECT_LT(late[18] + 100, late[3]);
  expect_refused("render panes -o c.exr --budget 5 --deadline 5", 2, "budget");
  expect_refused("render panes -o c.exr --budget 5 --max-ms 50", 2, "--max-ms");
  expect_refused("render panes -o c.exr --budget 0", 2, "--budget");
}

TEST_F(Render, ADeadlineThatHasPassedLeavesRaster) {
  render("panes -o a.exr --size 64x36 --ambient off --shadows map --deadline 0.001 --diagnose check --stats a.json");
  render("panes -o b.exr --size 64x36 --ambient off --shadows map --layers 0");
  EXPECT_EQ(run("compare a.exr b.exr --fail-above 0 --metric relmse").exit_code, 0);
  const json stats = json::parse(text_of(path("a.json")));
  EXPECT_GT(stats["pixels"]["masked"], 0);
  EXPECT_EQ(stats["pixels"]["late"], stats["pixels"]["masked"]);
  for (const char* key : {"older", "masks_older", "oldest_frames"}) EXPECT_EQ(stats["pixels"][key], 0) << key;
  EXPECT_EQ(stats["layers"]["matched"], 0);
  // A deadline makes chunks smaller, so that other pixels are donors and bounced light differs.
  render("panes -o c.exr --size 64x36 --ray-reuse 0 --ambient ao --deadline 1e6");
  render("panes -o d.exr --size 64x36 --ray-reuse 0 --ambient ao");
  EXPECT_EQ(text_of(path("c.exr")), text_of(path("d.exr")));
}

TEST_F(Render, ThreadsDoNotChangeTheBits) {
  render("panes -o a.exr --size 64x36 --threads 1");
  render("panes -o b.exr --size 64x36 --threads 2");
  EXPECT_EQ(text_of(path("a.exr")), text_of(path("b.exr")));
}

TEST_F(Render, ComparesInTheSameRun) {
  render("panes -o a.exr --size 64x36");
  const Outcome same = run("render panes -o b.exr --size 64x36 --compare a.exr");
  EXPECT_EQ(same.exit_code, 0) << same.errors;
  EXPECT_EQ(same.output, run("compare b.exr a.exr").output);
  EXPECT_NE(same.output.find("psnr            999.0"), std::string::npos) << same.output;
  const Outcome other = run("render panes -o b.exr --size 64x36 --translucency off --compare a.exr");
  EXPECT_EQ(other.exit_code, 0) << "a difference is no failure: " << other.errors;
  EXPECT_NE(other.output, same.output);
  EXPECT_EQ(run("render panes -o b.exr --size 32x18 --compare a.exr").exit_code, 2);
}

TEST_F(Render, ABuiltInSceneIsWhatMakeWrites) {
  ASSERT_EQ(run("make panes -o p.glb --set count=2").exit_code, 0);
  render("p.glb -o a.exr --size 64x36 --stats s.json");
  EXPECT_EQ(stats("s.json")["scene"]["translucent_objects"], 2);
  ASSERT_EQ(run("make panes -o q.glb").exit_code, 0);
  render("q.glb -o a.exr --size 64x36");
  render("panes -o b.exr --size 64x36");
  EXPECT_EQ(run("compare a.exr b.exr --fail-above 0.001").exit_code, 0);
}

// Plants in wind are written as instances, each with its phase and its index among the objects.
TEST_F(Render, AForestReadFromAFileIsTheSamePicture) {
  ASSERT_EQ(run("make forest -o f.glb --set count=300").exit_code, 0);
  const std::string view = " --size 64x36 --camera pond --time 1.3 --aov Z,N,id,shadow -o ";
  render("f.glb" + view + "a.exr");
  render("'forest?count=300'" + view + "b.exr");
  EXPECT_TRUE(text_of(path("a.exr")) == text_of(path("b.exr"))) << "to the last bit";
}

// Glass that is not drawn casts no shadow: the picture is the same without the panes, by every way of shadows.
TEST_F(Render, WithoutTranslucencyGlassThrowsNoShadows) {
  for (const char* shadows : {"exact", "map"})
    for (const char* translucency : {"off", "raster"}) {
      const std::string way = std::string(" --size 64x36 --ambient off --shadows ") + shadows + " --translucency " + translucency;
      render("'crossing?panes=0'" + way + " -o a.exr");
      render("'crossing?panes=9'" + way + " -o b.exr");
      EXPECT_EQ(text_of(path("a.exr")) == text_of(path("b.exr")), std::string(translucency) == "off") << way;
    }
}

// Raytraced translucency draws no sprites, so any shadow of them would show.
TEST_F(Render, SmokeThrowsNoShadows) {
  for (const char* shadows : {"exact", "map"}) {
    const std::string way = std::string(" --size 64x36 --translucency raytraced --shadows ") + shadows;
    render("'smoke?count=1'" + way + " -o a.exr");
    render("'smoke?count=3000'" + way + " -o b.exr");
    EXPECT_TRUE(text_of(path("a.exr")) == text_of(path("b.exr"))) << way;
  }
}

TEST_F(Render, JobsShareOptions) {
  std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png"},)"
                                   << R"( {"scene": "panes", "o": "b.png", "layers": 1, "size": "16x9"}])";
  render("--jobs jobs.json --size 32x18");
  EXPECT_EQ(scenes::read_image(path("a.png")).width, 32u);
  EXPECT_EQ(scenes::read_image(path("b.png")).width, 16u);
}

TEST_F(Render, ABadJobStopsAllBeforeTheFirst) {
  std::ofstream(path("jobs.json"))
      << R"([{"scene": "panes", "o": "a.png"}, {"scene": "panes", "o": "b.png", "lay": 1}])";
  expect_refused("render --jobs jobs.json", 2, "job 1");
  for (const char* second :
       {R"("scene": "nosuch", "o": "b.png")", R"("scene": "panes?count=999", "o": "b.png")",
        R"("scene": "panes", "o": "b.png", "camera": "nosuch")",
        R"("scene": "panes", "o": "b.png", "animation": "nosuch")",
        R"("scene": "panes", "o": "b.png", "env": "nosuch.hdr")", R"("scene": "panes", "o": "nosuch/b.png")"}) {
    std::ofstream(path("jobs.json")) << R"([{"scene": "panes", "o": "a.png"}, {)" << second << "}]";
    const Outcome outcome = run("render --jobs jobs.json --size 16x9");
    EXPECT_NE(outcome.exit_code, 0) << second;
    EXPECT_NE(outcome.errors.find("job 1"), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(path("a.png"))) << second;
  }
}

TEST_F(Render, AFilterThatIsOffTakesNoTime) {
  render("panes -o a.exr --size 16x9 --denoise off --reflections on --shadows exact --stats s.json");
  EXPECT_EQ(stats("s.json")["stages_ms"]["denoise"], 0);
}

TEST_F(Render, FreeCameraAndEnvironment) {
  render("panes -o a.exr --size 32x18 --eye -1,0.5,4 --target 0,0,0 --fov 30 --env none --stats s.json");
  const json config = stats("s.json")["config"];
  EXPECT_EQ(config["eye"], "-1,0.5,4");
  EXPECT_EQ(config["fov"], 30);
  EXPECT_FALSE(config.contains("camera"));
  EXPECT_EQ(config["env"], "none");
}

}  // namespace
}  // namespace sideray::cli_tests
