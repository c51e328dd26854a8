#include "cli/program.h"

namespace sideray::cli_tests::bench_test {
namespace {

using nlohmann::json;

class Bench : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }
  // Returns the printed text.
  std::string bench(const std::string& arguments) {
    const Outcome outcome = run("bench " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    return outcome.output;
  }
  json read(const std::string& name) const { return json::parse(text_of(path(name))); }
};

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

TEST_F(Bench, EveryStageIsTimed) {
  const std::string table = bench("panes --size 64x36 --layers 3 --threads 1 --repeat 3 --json s.json");
  const json s = read("s.json");
  EXPECT_EQ(s["repeats"], 3);
  EXPECT_EQ(s["config"]["repeat"], 3);
  const std::vector<std::string> stages{"build", "composite", "denoise",      "gbuffer",    "kept_frame", "light",
                                        "load",  "mask",      "readback",     "shadow_map", "total_frame",
                                        "trace", "trace_ao",  "trace_shadow", "update",     "upload"};
  for (const char* part : {"stages_ms", "p25", "p75"}) {
    EXPECT_EQ(keys(s[part]), stages);
    for (const json& ms : s[part]) EXPECT_GE(ms.get<double>(), 0.0);
  }
  for (const std::string& stage : stages) {
    EXPECT_LE(s["p25"][stage], s["p75"][stage]) << stage;
    EXPECT_EQ(table.find("\n" + stage + " ") != std::string::npos, s["stages_ms"][stage] > 0.0) << stage << table;
  }
  for (const char* stage : {"load", "gbuffer", "mask", "trace", "composite", "total_frame"})
    EXPECT_GT(s["stages_ms"][stage].get<double>(), 0.0) << stage;
  EXPECT_GT(s["layers"]["matched"], 0);
  EXPECT_EQ(files(), std::vector<std::string>{"s.json"}) << "no picture was asked for";
}

TEST_F(Bench, RawFramesMeasureTheStagesOfRays) {
  const json s = json::parse(bench("panes --size 64x36 --threads 1 --repeat 1 --json -")), raw = s["raw_frame"];
  EXPECT_GT(raw["ms"], 0.0);
  EXPECT_EQ(raw["triangles"], s["scene"]["triangles"]);
  EXPECT_EQ(raw["flat"], true);
  const std::vector<std::string> stages{"denoise", "trace", "trace_ao", "trace_shadow", "upload"};
  EXPECT_EQ(keys(raw["stages"]), stages);
  for (const std::string& stage : stages)
    EXPECT_DOUBLE_EQ(raw["stages"][stage].get<double>() * raw["ms"].get<double>(), s["stages_ms"][stage]) << stage;
  EXPECT_DOUBLE_EQ(raw["total"].get<double>() * raw["ms"].get<double>(), s["stages_ms"]["total_frame"]);
  EXPECT_GT(raw["stages"]["trace"], 0.0);
  EXPECT_NE(bench("panes --size 64x36 --repeat 1").find("\nraw frame "), std::string::npos);
  const std::string raster =
      bench("panes --size 64x36 --translucency raster --shadows map --ambient off --repeat 1 --json s.json");
  EXPECT_EQ(raster.find("raw frame"), std::string::npos) << raster;
  EXPECT_FALSE(read("s.json").contains("raw_frame"));
}

TEST_F(Bench, ASequenceIsTimedFrameByFrame) {
  const std::string sequence = "smoke --size 32x18 --frames 3-5 ";
  const std::string table = bench(sequence + "--repeat 2 --json s.jsonl -o b.#.exr");
  EXPECT_NE(table.find("\ntotal_frame "), std::string::npos) << table;
  std::istringstream lines(text_of(path("s.jsonl")));
  uint32_t frame = 3;
  for (std::string line; std::getline(lines, line); ++frame) {
    EXPECT_EQ(json::parse(line)["frame"], frame);
    EXPECT_EQ(json::parse(line)["repeats"], 2);
  }
  EXPECT_EQ(frame, 6u);
  ASSERT_EQ(run("render " + sequence + "-o r.#.exr").exit_code, 0);
  for (const char* n : {"3", "4", "5"})
    EXPECT_EQ(text_of(path("b." + std::string(n) + ".exr")), text_of(path("r." + std::string(n) + ".exr"))) << n;
}

}  // namespace
}  // namespace sideray::cli_tests::bench_test
