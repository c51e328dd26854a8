// Tests that in `sideray stress` known failures fail and the defaults do not.
#include <algorithm>
#include <set>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class StressByRays : public Program {
 protected:
  json results(const std::string& folder) const { return json::parse(text_of(path(folder + "/results.json"))); }
};

class Stress : public StressByRays {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }
};

struct Failed {
  const char *name, *variant, *measure;
};

bool matches(const json& row, const Failed& failed) {
  return row["name"] == failed.name && row["variant"] == failed.variant &&
         row["measure"].get<std::string>().find(failed.measure) != std::string::npos;
}

// The cases that do not take seconds, as those of budgets and of light that bounces do. That of fragments needs OpenGL.
const std::string quick_cases =
    "stress layer-gap coplanar layer-count instance-scale world-offset match-gap wind-gap contact self-shadow leaves settling "
    "depth-format ray-layers broken-triangles late-glass ";

TEST_F(StressByRays, KeepsTheBoundsOfDefaults) {
  const Outcome outcome = run(quick_cases + "--quick --gl none -o d");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors << outcome.output;
  EXPECT_EQ(outcome.errors, "sideray: warning: stress: without OpenGL no fragment looks for layers: match-gap left out\n");
  std::set<std::string> names;
  const json r = results("d");
  for (const json& row : r["cases"]) names.insert(row["name"]);
  EXPECT_EQ(names.size(), 14u);
  EXPECT_FALSE(names.contains("match-gap"));
}

using SlowStressByRays = StressByRays;

TEST_F(SlowStressByRays, KeepsTheBoundsOfLightThatBounces) {
  const Outcome outcome = run("stress bounce --quick --gl none -o d");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors << outcome.output;
  EXPECT_FALSE(results("d")["cases"].empty());
}

TEST_F(Stress, QuickSweepsShowWhatIsKnownToFail) {
  const Outcome outcome = run(quick_cases + "match-distance match-incidence match-near --quick -o d");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors << outcome.output;
  const json r = results("d");
  EXPECT_EQ(r["schema"], 1);
  for (const json& row : r["cases"]) {
    std::set<std::string> keys;
    for (const auto& [key, value] : row.items()) keys.insert(key);
    EXPECT_EQ(keys, (std::set<std::string>{"name", "variant", "parameters", "measure", "value", "bound", "pass"}));
    EXPECT_EQ(row["pass"].get<bool>(), row["value"].get<double>() <= row["bound"].get<double>()) << row;
  }
  for (const Failed& failed : {Failed{"layer-gap", "--diagnose step=listing", "lost"},
                               {"coplanar", "--diagnose step=listing", "lost"},
                               {"match-gap", "--diagnose match=distance,match-threshold=0.01", "another surface"},
                               {"match-distance", "--diagnose match=distance,match-threshold=0.001", "another surface"},
                               {"wind-gap", "--inexact tmin --poses rest", "in false shadow"},
                               {"wind-gap", "--shadows exact --poses rest", "in false shadow"},
                               {"contact", "--inexact tmin --poses rest", "that are lit"},
                               {"contact", "origin moved by u B (no option) --poses rest", "hit distance"},
                               {"leaves", "--shadows map, cards of two triangles", "above their centre"},
                               {"settling", "--denoise off --taa off", "flicker"},
                               {"ray-layers", "one ray a surface, t_near as in listing 50-1", "lost"},
                               {"depth-format", "256 ulps along the normal", "the floor they start from"}})
    EXPECT_TRUE(std::any_of(r["cases"].begin(), r["cases"].end(),
                            [&](const json& row) { return matches(row, failed) && !row["pass"].get<bool>(); }))
        << failed.name << ", " << failed.variant;
  // Rates of random failures are those of their closed forms.
  size_t closed_forms = 0;
  for (const json& row : r["cases"]) {
    if (row["measure"].get<std::string>().find("closed form") == std::string::npos) continue;
    ++closed_forms;
    EXPECT_TRUE(row["pass"].get<bool>()) << row;
  }
  EXPECT_GT(closed_forms, 0u);
}

using SlowStress = Stress;

TEST_F(SlowStress, QuickSweepsOfAllCasesKeepTheirBounds) {
  const Outcome outcome = run("stress --quick -o d");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const json r = results("d");
  const Failed failed{"bounce", "--ambient ao", "FLIP to paths"};
  EXPECT_TRUE(std::any_of(r["cases"].begin(), r["cases"].end(),
                          [&](const json& row) { return matches(row, failed) && !row["pass"].get<bool>(); }));
}

TEST_F(Stress, WritesMapsAndAPageOfWhatWasChosen) {
  const Outcome outcome = run("stress coplanar contact --quick -o a/b");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("--diagnose step=listing"), std::string::npos);
  std::set<std::string> names;
  const json r = results("a/b");
  for (const json& row : r["cases"]) names.insert(row["name"].get<std::string>());
  EXPECT_EQ(names, (std::set<std::string>{"coplanar", "contact"}));
  for (const std::string& name : names)
    EXPECT_GT(scenes::read_image(path("a/b/maps/" + name + ".png")).width, 100u) << name;
  const std::string page = text_of(path("a/b/index.html"));
  for (const std::string& name : names) EXPECT_NE(page.find("failure map of " + name), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  EXPECT_EQ(page.find("maps/"), std::string::npos) << "the page needs a file beside it";
  EXPECT_EQ(page.find("world-offset"), std::string::npos);
  EXPECT_EQ(run("stress coplanar contact --quick --threads 1 -o again").exit_code, 0);
  EXPECT_EQ(results("again"), r) << "for any thread count";
}

class StressUsage : public Program {};

TEST_F(StressUsage, WrongUsageIsOneLine) {
  expect_refused("stress", 2, "-o DIR");
  expect_refused("stress nosuch -o d", 2, "--list");
  expect_refused("stress -o d --threads 0", 2, "--threads");
  expect_refused("stress -o d --gl metal", 2, "--gl");
  std::ofstream(path("file")) << "x";
  expect_refused("stress coplanar -o file", 1, "file");
}

TEST_F(StressUsage, ListsItsCases) {
  const Outcome outcome = run("stress --list");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("coplanar"), std::string::npos);
}

}  // namespace
}  // namespace sideray::cli_tests
