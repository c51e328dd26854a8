#include <cmath>
#include <set>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class Chart : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }
  Outcome chart(const std::string& arguments) { return chart(arguments, small); }
  Outcome chart(const std::string& arguments, const std::string& sizes) {
    const Outcome outcome = run("chart " + arguments + sizes);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
    return outcome;
  }
  json results(const std::string& folder) const { return json::parse(text_of(path(folder + "/results.json"))); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  const std::string small = " --size 32x18 --light-samples 4 --repeat 2";
  const std::string three = R"([{"translucency": "off"}, {"layers": 1, "ray-traced": "none"}, {"layers": 2}])";
};

size_t lines_of(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(Chart, ResultsFollowTheSchema) {
  write("s.json", three);
  chart("panes -o d --sweep s.json");
  const json r = results("d");
  EXPECT_EQ(r["schema"], 1);
  EXPECT_EQ(r["scene"], "panes");
  EXPECT_EQ(r["reference"]["image"], "images/reference.exr");
  EXPECT_EQ(r["reference"]["light_samples"], 4);
  EXPECT_GE(r["reference"]["self_error"], 0.0);
  EXPECT_EQ(scenes::read_image(path("d/images/reference.exr")).width, 32u);
  ASSERT_EQ(r["rows"].size(), 3u);
  bool any_on_the_front = false;
  for (const json& row : r["rows"]) {
    for (const char* key : {"schema", "scene", "config", "device", "stages_ms", "p25", "p75", "rays", "pixels",
                            "repeats", "error", "pareto", "image"})
      EXPECT_TRUE(row.contains(key)) << key;
    EXPECT_EQ(row["repeats"], 2);
    EXPECT_EQ(row["config"]["repeat"], 2);
    EXPECT_LE(row["p25"]["total_frame"], row["stages_ms"]["total_frame"]);
    EXPECT_LE(row["stages_ms"]["total_frame"], row["p75"]["total_frame"]);
    any_on_the_front = any_on_the_front || row["pareto"].get<bool>();
  }
  EXPECT_TRUE(any_on_the_front);
  EXPECT_EQ(lines_of(text_of(path("d/results.csv"))), 4u);
}

// A row of a chart has the values of render and compare, also after another selection of objects.
TEST_F(Chart, RowsAreWhatRenderDraws) {
  write("s.json", R"([{"layers": 2, "ray-traced": "none"}, {"layers": 2}, {"translucency": "raytraced"}])");
  chart("panes -o d --sweep s.json");
  const json rows = results("d")["rows"];
  const char* const options[] = {"--layers 2 --ray-traced none", "--layers 2", "--translucency raytraced"};
  for (size_t i = 0; i < 3; ++i) {
    SCOPED_TRACE(options[i]);
    const Outcome alone = run("bench panes -o x.exr --size 32x18 --repeat 1 --json x.json --ambient off --reflections off " +
                              std::string(options[i]));
    ASSERT_EQ(alone.exit_code, 0) << alone.errors;
    EXPECT_EQ(json::parse(run("compare x.exr d/images/reference.exr --json").output), rows[i]["error"]);
    const json stats = json::parse(text_of(path("x.json")));
    for (const char* group : {"rays", "pixels", "layers", "bytes"})
      EXPECT_EQ(stats.value(group, json()), rows[i].value(group, json())) << group;
    json config = rows[i]["config"];
    config["repeat"] = 1;
    EXPECT_EQ(config, stats["config"]);
    EXPECT_EQ(text_of(path("x.exr")), text_of(path(rows[i]["image"].get<std::string>().insert(0, "d/"))));
  }
  EXPECT_NE(rows[0]["error"], rows[1]["error"]);
}

TEST_F(Chart, TheDefaultListFitsTheScene) {
  const Outcome opaque = chart("empty -o d");
  EXPECT_EQ(results("d")["rows"].size(), 1u);
  EXPECT_EQ(results("d")["rows"][0]["config"]["translucency"], "raster");
  EXPECT_NE(opaque.output.find("no translucent object"), std::string::npos) << opaque.output;
}

// No two rows of a built-in list draw the same, and options that the scene has no use for are left out with a reason.
TEST_F(Chart, BuiltInListsHaveNoDoubles) {
  const Outcome outcome = chart("panes -o d --sweep all --shard 0/100");
  EXPECT_NE(outcome.output.find("left out: shadows: one pose"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("than a ray can hit, 4"), std::string::npos) << outcome.output;
  // Options of the whole chart leave fewer rows.
  chart("empty -o e --sweep shadows");
  const json rows = results("e")["rows"];
  std::set<std::string> configs;
  for (const json& row : rows) configs.insert(row["config"].dump());
  EXPECT_EQ(configs.size(), rows.size());
  EXPECT_GE(rows.size(), 6u);
  chart("empty -o f --sweep shadows --denoise off --ambient ao");
  EXPECT_LT(results("f")["rows"].size(), rows.size());
}

TEST_F(Chart, ResumeKeepsWhatIsMeasured) {
  write("s.json", three);
  chart("panes -o d --sweep s.json");
  const json first = results("d");
  fs::remove(path("d/index.html"));
  chart("panes -o d --sweep s.json --resume");
  EXPECT_EQ(results("d"), first);
  EXPECT_TRUE(fs::exists(path("d/index.html")));
  // Only missing or truncated rows are measured again.
  fs::remove(path("d/rows/0000.json"));
  fs::resize_file(path("d/rows/0002.json"), 100);
  chart("panes -o d --sweep s.json --resume");
  const json second = results("d");
  for (const char* kept : {"stages_ms", "p25", "p75", "error", "rays"})
    EXPECT_EQ(second["rows"][1][kept], first["rows"][1][kept]) << kept;
  for (size_t i : {0, 2}) {
    EXPECT_EQ(second["rows"][i]["error"], first["rows"][i]["error"]);
    EXPECT_NE(second["rows"][i]["stages_ms"], first["rows"][i]["stages_ms"]);
  }
  // A row whose picture is truncated is measured again too.
  fs::resize_file(path("d/images/0001.exr"), fs::file_size(path("d/images/0001.exr")) / 2);
  chart("panes -o d --sweep s.json --resume");
  EXPECT_EQ(results("d")["rows"][1]["error"], first["rows"][1]["error"]);
  EXPECT_NE(results("d")["rows"][1]["stages_ms"], first["rows"][1]["stages_ms"]);
  EXPECT_EQ(run("compare d/images/0001.exr d/images/reference.exr").exit_code, 0);
  // New rounds are added to existing ones; another configuration makes another row.
  write("s.json", R"([{"translucency": "off"}, {"layers": 1}, {"layers": 2}])");
  run("chart panes -o d --sweep s.json --resume --size 32x18 --light-samples 4 --repeat 3");
  const json third = results("d");
  for (const json& row : third["rows"]) EXPECT_EQ(row["repeats"], 3);
  EXPECT_NE(third["rows"][1]["config"]["ray-traced"], "none");
}

// An exact row has its own noise: with the reference's random numbers its error would be 0.
TEST_F(Chart, AnExactRowIsNotTheReference) {
  write("s.json", R"([{"reference": true}, {"reference": true, "seed": 1}])");
  chart("panes -o d --sweep s.json --seed 1");
  const json rows = results("d")["rows"];
  EXPECT_GT(rows[0]["error"]["relmse"], 0.0);
  EXPECT_EQ(rows[1]["error"]["relmse"], 0.0);
}

// Options of light transport for the whole chart apply to the reference too.
TEST_F(Chart, TheReferenceReflectsWhereTheChartDoes) {
  write("s.json", R"([{"translucency": "off"}])");
  const std::string scene = "'forest?count=20' --camera pond --sweep s.json";
  chart(scene + " -o d");
  chart(scene + " -o e --reflections on");
  const Outcome compared = run("compare e/images/reference.exr d/images/reference.exr --json");
  EXPECT_GT(json::parse(compared.output)["relmse"], 1e-4) << compared.output;
}

// `auto` approximations of bounced light would be errors against a reference of one bounce, so they are off.
TEST_F(Chart, AutoIsOffAgainstTheLightOfOneBounce) {
  write("s.json", R"([{"translucency": "off"}, {"translucency": "off", "ambient": "ao"}, {"ambient": "auto", "reflections": "on"}])");
  const auto used = [&](const std::string& options) {
    chart("empty -o d --sweep s.json " + options, " --size 16x9 --light-samples 1 --repeat 1");
    std::string list;
    const json rows = results("d")["rows"];
    for (const json& row : rows) {
      for (const char* name : {"ambient", "reflections"}) list += row["config"][name].get<std::string>() + " ";
      EXPECT_EQ(row["rays"]["ao"] > 0 || row["rays"]["bounce"] > 0, row["config"]["ambient"] != "off");
      EXPECT_EQ(row["rays"]["reflection"] > 0, row["config"]["reflections"] == "on");
    }
    fs::remove_all(path("d"));
    return list;
  };
  EXPECT_EQ(used(""), "off off ao off off on ");
  EXPECT_EQ(used("--bounces 1"), "off off ao off off on ");
  EXPECT_EQ(used("--bounces 2"), "bounce on ao on bounce on ");
  EXPECT_EQ(used("--env none --bounces 2"), "bounce on ao on bounce on ");
}

TEST_F(Chart, ShardsComeTogether) {
  write("s.json", three);
  const Outcome first = chart("panes -o d --sweep s.json --shard 1/2");
  for (const char* name : {"d/results.json", "d/index.html"}) EXPECT_FALSE(fs::exists(path(name))) << name;
  EXPECT_TRUE(fs::exists(path("d/rows/0001.json")));
  EXPECT_FALSE(fs::exists(path("d/rows/0000.json")));
  EXPECT_NE(first.output.find("missing"), std::string::npos) << first.output;
  chart("panes -o d --sweep s.json --shard 0/2");
  chart("panes -o whole --sweep s.json");
  const json parts = results("d"), whole = results("whole");
  ASSERT_EQ(parts["rows"].size(), 3u);
  EXPECT_EQ(parts["reference"], whole["reference"]);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(parts["rows"][i]["error"], whole["rows"][i]["error"]);
  EXPECT_TRUE(fs::exists(path("d/index.html")));
}

class ChartFrames : public Chart {
 protected:
  // Wind moves the forest: measures over time need motion.
  const std::string moving = "'forest?count=12' -o d --sweep s.json --frames 2-4 --samples 2";
  const std::string few = R"([{"shadows": "off", "taa": "off"}, {"shadows": "off"}])";
};

TEST_F(ChartFrames, RowsAreMeansOverFramesOfWhatRenderDraws) {
  write("s.json", few);
  chart(moving);
  const json r = results("d");
  EXPECT_EQ(r["frames"], (json{{"first", 2}, {"last", 4}, {"fps", 30.0}}));
  EXPECT_EQ(r["reference"]["image"], "images/reference.0004.exr");
  const char* const options[] = {"--taa off", ""};
  for (size_t i = 0; i < 2; ++i) {
    const Outcome drawn =
        run("render 'forest?count=12' --size 32x18 --shadows off --ambient off --reflections off --frames 2-4 -o f.#.exr "
            "--stats f.json " +
            std::string(options[i]));
    ASSERT_EQ(drawn.exit_code, 0) << drawn.errors;
    double flip = 0;
    for (const char* frame : {"2", "3", "4"})
      flip += json::parse(run("compare f." + std::string(frame) + ".exr d/images/reference.000" + frame + ".exr --json")
                              .output)["flip"]
                  .get<double>() /
              3;
    EXPECT_NEAR(r["rows"][i]["error"]["flip"], flip, 1e-9);
    EXPECT_EQ(text_of(path("f.4.exr")), text_of(path(r["rows"][i]["image"].get<std::string>().insert(0, "d/"))));
  }
}

TEST_F(ChartFrames, WhatShowsInTimeHasKeysOfItsOwn) {
  write("s.json", few);
  chart(moving + " --metric settle_time");
  const json rows = results("d")["rows"];
  for (const json& row : rows) {
    for (const char* name :
         {"flip", "flicker", "flicker_of_error", "warped_difference", "ghost", "ghost_half_life", "settle_time"})
      EXPECT_TRUE(row["error"][name].is_number()) << name;
    EXPECT_EQ(row["repeats"], 2);
  }
  // Without temporal anti-aliasing and masks a frame has no history.
  EXPECT_EQ(rows[0]["error"]["ghost"], 0);
  EXPECT_EQ(rows[0]["error"]["settle_time"], 0);
  EXPECT_GT(rows[1]["error"]["ghost"], 1.0 / 255);
  EXPECT_GT(rows[1]["error"]["ghost_half_life"], 0);
  EXPECT_LE(rows[1]["error"]["settle_time"], 40);
  EXPECT_TRUE(rows[0]["pareto"]) << "nothing settles earlier";
}

TEST_F(ChartFrames, ResumeKeepsFramesAndShardsComeTogether) {
  write("s.json", few);
  chart(moving + " --shard 1/2");
  const std::string second = text_of(path("d/images/reference.0003.exr"));
  fs::remove(path("d/images/reference.0003.exr"));
  const auto kept = fs::last_write_time(path("d/images/reference.0002.exr"));
  const auto motion = fs::last_write_time(path("d/images/motion.0004.exr"));
  chart(moving + " --shard 0/2");
  EXPECT_EQ(text_of(path("d/images/reference.0003.exr")), second);
  EXPECT_EQ(fs::last_write_time(path("d/images/reference.0002.exr")), kept);
  EXPECT_EQ(fs::last_write_time(path("d/images/motion.0004.exr")), motion);
  const json parts = results("d");
  fs::remove_all(path("d"));
  chart(moving);
  const json whole = results("d");
  EXPECT_EQ(parts["reference"], whole["reference"]);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(parts["rows"][i]["error"], whole["rows"][i]["error"]);
  chart(moving + " --resume");
  EXPECT_EQ(results("d"), whole);
}

// Returns the text between two marks.
std::string between(const std::string& text, const std::string& open, const std::string& close) {
  const size_t at = text.find(open);
  if (at == std::string::npos) return "";
  const size_t begin = at + open.size();
  return text.substr(begin, text.find(close, begin) - begin);
}

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_F(Chart, ThePageHoldsEverything) {
  write("s.json", R"([{"translucency": "off"}, {"layers": 2, "ray-traced": "*"}])");
  chart("panes -o 'a folder' --sweep s.json");
  const std::string page = text_of(path("a folder/index.html"));
  // The page fetches nothing: its only addresses are those in the library's notice.
  EXPECT_EQ(count_of(page, "http"),
            count_of(page, "https://www.chartjs.org") + count_of(page, "https://github.com/kurkle/"));
  EXPECT_EQ(count_of(page, "<script"), count_of(page, "</script>"));
  EXPECT_LT(page.size(), 1u << 20);
  const json data = json::parse(between(page, "id=\"data\">", "</script>"));
  EXPECT_EQ(data["results"], results("a folder"));
  EXPECT_EQ(data["command"],
            "sideray chart panes -o 'a folder' --sweep s.json --repeat 2 --size 32x18 --light-samples 4");
  ASSERT_EQ(data["points"].size(), 2u);
  EXPECT_EQ(data["points"][0]["label"], "translucency off");
  EXPECT_EQ(data["points"][1]["label"], "layers 2, ray-traced *");
  for (const json& point : data["points"]) {
    EXPECT_TRUE(point["picture"].get<std::string>().starts_with("data:image/png;base64,"));
    EXPECT_TRUE(point["map"].get<std::string>().starts_with("data:image/png;base64,"));
    EXPECT_NE(point["picture"], data["reference"]);
  }
  // The command of a row draws the row's picture.
  const std::string command = data["points"][1]["command"];
  const std::string drawn = text_of(path("a folder/images/0001.exr"));
  fs::remove(path("a folder/images/0001.exr"));
  ASSERT_TRUE(command.starts_with("sideray render panes "));
  EXPECT_EQ(run(command.substr(8)).exit_code, 0) << command;
  EXPECT_EQ(text_of(path("a folder/images/0001.exr")), drawn);
}

TEST_F(Chart, TheScriptOfThePageParses) {
  const bool is_promised = std::getenv("SIDERAY_REQUIRE_CONTEXTS") != nullptr;  // script/test installs what tests need
  if (std::system("node --version >/dev/null 2>&1") != 0 && !is_promised) GTEST_SKIP() << "no node";
  for (const char* name : {"lab/page/choices.js", "lab/page/chart.js", "lab/page/ledger.js"})
    EXPECT_EQ(std::system(("node --check '" SIDERAY_SOURCE_DIR "/" + std::string(name) + "'").c_str()), 0) << name;
}

class ChartUsage : public Program {};

TEST_F(ChartUsage, WrongUsageIsOneLine) {
  expect_refused("chart panes", 2, "-o DIR");
  expect_refused("chart -o d", 2, "no scene");
  expect_refused("chart panes -o d --repeat 0", 2, "--repeat");
  expect_refused("chart panes -o d --metric beauty", 2, "relmse_trimmed");
  expect_refused("chart panes -o d --size 10x20 --metric ssim", 2, "11x11");
  expect_refused("chart panes -o d --shard 2/2", 2, "--shard");
  expect_refused("chart panes -o d --metric flicker", 2, "--frames");
  expect_refused("chart panes -o d --frames 3-3", 2, "at least two frames");
  expect_refused("chart panes -o d --frames 0-3 --time 2", 2, "--time");
  expect_refused("chart panes -o d --fps 3", 2, "--fps");
  expect_refused("chart panes -o d --frames 0-3 --warm-up 3", 2, "warm-up");
  expect_refused("chart panes -o d --frames 0-3 --ledger", 2, "--ledger");
  expect_refused("chart panes -o d --shard 1", 2, "I/N");
  expect_refused("chart panes -o d --sweep nosuch.json", 1, "nosuch.json");
  expect_refused("chart nosuch.glb -o d", 1, "nosuch.glb");
  expect_refused("chart panes -o d --layers 99", 2, "--layers");
  expect_refused("chart panes -o d --aov Z", 2, "aov");
  std::ofstream(path("file")) << "x";
  expect_refused("chart panes -o file --size 16x16", 1, "file");
}

TEST_F(ChartUsage, ABadSweepNamesEntryAndOption) {
  const auto refused = [&](const std::string& sweep, int code, const std::string& says) {
    std::ofstream(path("s.json")) << sweep;
    expect_refused("chart panes -o d --sweep s.json", code, says);
  };
  refused("[{]", 2, "s.json: is not JSON");
  refused(R"([{"layers": 1, "layers": 2}])", 2, "s.json: \"layers\" is given twice");
  refused("{}", 2, "s.json: is not an array");
  refused("[]", 2, "no configuration");
  refused(R"([{}, 3])", 2, "s.json entry 1");
  refused(R"([{}, {"lay": 1}])", 2, "s.json entry 1: --lay");
  refused(R"([{"mask": "some"}])", 2, "s.json entry 0: --mask");
  refused(R"([{"mask": null}])", 2, "s.json entry 0: mask");
  refused(R"([{"mask": true}])", 2, "s.json entry 0: --mask");
  refused(R"([{"layers": 9}])", 2, "s.json entry 0: --layers");
  refused(R"([{"layers": 1.5}])", 2, "s.json entry 0: --layers");
  refused(R"([{}, {}, {"deadline": 0}])", 2, "s.json entry 2: --deadline");
  refused(R"([{"check": "maybe"}])", 2, "s.json entry 0: --diagnose check");
  refused(R"([{"size": "8x8"}])", 2, "s.json entry 0: --size is the same for the whole chart");
  refused(R"([{"samples": 4}])", 2, "s.json entry 0: --samples is the same for the whole chart");
  refused(R"([{"stats": "x.json"}])", 2, "s.json entry 0: --stats has no place");
  refused(R"([{"ray-traced": "nosuch*"}])", 2, "s.json entry 0: --ray-traced nosuch*");
}

}  // namespace
}  // namespace sideray::cli_tests
