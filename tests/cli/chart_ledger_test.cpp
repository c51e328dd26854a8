#include <cmath>
#include <set>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class ChartLedger : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
    std::ofstream(path("one.json")) << "[{}]";
  }

  json ledger(const std::string& arguments) {
    const Outcome outcome =
        run("chart " + arguments + " -o d --sweep one.json --ledger --size 32x18 --light-samples 8 --repeat 1");
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    printed_ = outcome.output;
    return json::parse(text_of(path("d/ledger.json")));
  }

  std::string printed_;
};

const json& term(const json& ledger, const std::string& name) {
  for (const json& t : ledger["terms"])
    if (t["name"] == name) return t;
  static const json none;
  ADD_FAILURE() << "no term " << name;
  return none;
}

std::set<std::string> names(const json& list) {
  std::set<std::string> result;
  for (const json& entry : list) result.insert(entry["name"]);
  return result;
}

// With a reference of more bounces the light that no method computes is a separate term, and the others are unchanged.
TEST_F(ChartLedger, LightThatNoMethodComputesIsToldApart) {
  const json plain = ledger("solids --translucency raster --shadows map --denoise off"),
             l = ledger("solids --translucency raster --shadows map --denoise off --bounces 2");
  const json& bounces = term(l, "bounces");
  EXPECT_EQ(bounces["kind"], "residual");
  EXPECT_EQ(bounces["options"], (json{{"reference", "true"}, {"bounces", "1"}}));
  EXPECT_GT(bounces["mean_absolute"].get<double>(), 0.0);
  EXPECT_EQ(l["reference"]["bounces"], 2);
  EXPECT_FALSE(plain["reference"].contains("bounces"));
  EXPECT_FALSE(names(plain["terms"]).contains("bounces"));
  double shares = 0;
  for (const json& t : l["terms"]) shares += t["share"].get<double>();
  EXPECT_NEAR(shares, 1.0, 1e-9);
  for (const char* name : {"samples", "opaque", "visibility"})
    EXPECT_NEAR(term(l, name)["mean"].get<double>(), term(plain, name)["mean"].get<double>(), 1e-9) << name;
  // The last step begins where the others end: at the reference of one bounce, as in the plain chart.
  const Outcome same = run("render solids --reference --size 32x18 --light-samples 8 -o one.exr");
  EXPECT_EQ(same.exit_code, 0);
  const Outcome apart = run("compare one.exr d/" + bounces["image"].get<std::string>() + " --json");
  EXPECT_EQ(json::parse(apart.output)["relmse"], 0.0) << apart.output;
}

TEST_F(ChartLedger, PartsAddUpAndAreTheRowsError) {
  const json l = ledger("panes --layers 1");
  double shares = 0, relmse = 0;
  for (const json& t : l["terms"]) {
    shares += t["share"].get<double>();
    relmse += t["relmse"].get<double>();
    for (const char* key : {"name", "kind", "what", "mean", "mean_absolute"}) EXPECT_TRUE(t.contains(key)) << key;
    if (!t.contains("image")) continue;
    EXPECT_TRUE(fs::exists(path("d/" + t["image"].get<std::string>())));
  }
  EXPECT_NEAR(shares, 1.0, 1e-9);
  EXPECT_NEAR(relmse, l["total"]["relmse"].get<double>(), 1e-9 * relmse);
  // The ledger's picture and error are those of the row.
  const json row = json::parse(text_of(path("d/results.json")))["rows"][0];
  EXPECT_EQ(l["error"], row["error"]);
  EXPECT_NEAR(relmse, row["error"]["relmse"].get<double>(), 1e-9 * relmse);
  const Outcome again =
      run("compare d/" + term(l, "layers")["image"].get<std::string>() + " d/images/reference.exr --json");
  EXPECT_EQ(json::parse(again.output), term(l, "layers")["error"]);

  const scenes::Image layers = scenes::read_image(path("d/ledger.exr"));
  const auto value = [&](const std::string& channel, size_t i) {
    const scenes::Plane* plane = layers.find(channel);
    EXPECT_NE(plane, nullptr) << channel;
    return plane ? double{plane->values[i]} : 0.0;
  };
  for (size_t i = 0; i < size_t{32} * 18; i += 7) {
    double sum = 0, size = 0;
    for (const json& t : l["terms"]) {
      const std::string prefix = t["kind"] == "residual" ? "residual." : "";
      const double part = value(prefix + t["name"].get<std::string>() + ".G", i);
      sum += part, size += std::abs(part);
    }
    EXPECT_NEAR(sum, value("total.G", i), 1e-6 * size);
  }
}

// One of eight panes has a layer. No other term has a considerable effect there.
TEST_F(ChartLedger, DroppedLayersDominateWherePanesHaveOne) {
  const json l = ledger("'panes?count=8' --layers 1");
  const double dropped = term(l, "layers")["share"].get<double>();
  EXPECT_GT(dropped, 0.1);
  for (const json& t : l["terms"]) {
    if (t["kind"] == "residual" || t["name"] == "layers") continue;
    EXPECT_LT(std::abs(t["share"].get<double>()), 0.1 * dropped) << t["name"];
  }
  EXPECT_LT(term(l, "layers")["error"]["relmse"], l["error"]["relmse"]);
  EXPECT_NE(printed_.find("interaction"), std::string::npos) << printed_;
  // Eight layers drop none of eight panes.
  const json whole = ledger("'panes?count=8' --layers 8");
  EXPECT_FALSE(names(whole["terms"]).contains("layers"));
  EXPECT_TRUE(names(whole["absent"]).contains("layers"));
  EXPECT_LT(whole["error"]["relmse"], l["error"]["relmse"]);
}

TEST_F(ChartLedger, WhatIsNotDrawnIsMostOfTheError) {
  const json l = ledger("panes --translucency off");
  EXPECT_GT(term(l, "off")["share"], 0.9);
}

TEST_F(ChartLedger, EveryShortcutThatWasAskedForIsNamed) {
  const json l = ledger(
      "panes --layers 2 --cache-rate quarter --diagnose second-wave=off,match=distance,step=listing "
      "--shadows map --ambient ao --denoise off --cull-angle 1");
  for (const char* name : {"layers", "rate", "second-wave", "match", "step", "order", "shadow-maps",
                           "ambient", "noise", "culling", "mask"})
    EXPECT_TRUE(names(l["terms"]).contains(name)) << name;
  EXPECT_FALSE(names(l["terms"]).contains("denoise"));
}

// Options of layers do not matter where no object has one.
TEST_F(ChartLedger, WithoutLayersThereAreNoneToSwitch) {
  const json l = ledger("panes --ray-traced none --cache-rate quarter");
  EXPECT_TRUE(names(l["terms"]).contains("raster"));
  EXPECT_FALSE(names(l["terms"]).contains("rate"));
}

TEST_F(ChartLedger, AnOpaqueSceneHasNoLayersToLose) {
  const json l = ledger("empty");
  EXPECT_TRUE(names(l["absent"]).contains("translucency"));
  for (const char* name : {"layers", "order", "match", "cache", "samples"})
    EXPECT_FALSE(names(l["terms"]).contains(name)) << name;
  for (const char* name : {"opaque", "visibility"}) EXPECT_TRUE(names(l["terms"]).contains(name)) << name;
}

// The reference has the requested light: if shadows are off, it has none either.
TEST_F(ChartLedger, TheReferenceHasTheSameLight) {
  const json l = ledger("empty --shadows off");
  EXPECT_EQ(l["reference"]["image"], "images/ledger-reference.exr");
  EXPECT_LT(l["error"]["relmse"], json::parse(text_of(path("d/results.json")))["rows"][0]["error"]["relmse"]);
}

TEST_F(ChartLedger, ThePageShowsIt) {
  ledger("panes --layers 1");
  const std::string page = text_of(path("d/index.html"));
  EXPECT_NE(page.find("\"inseparable\""), std::string::npos);
  EXPECT_NE(page.find("ledger-bars"), std::string::npos);
  EXPECT_EQ(page.find("{{ledger.js}}"), std::string::npos);
}

TEST_F(ChartLedger, AChartWithoutRemovesThatOfAnother) {
  ledger("panes --layers 1");
  std::ofstream(path("d/rows/0001.json")) << "{}";
  std::ofstream(path("d/images/0001.exr")) << "";
  const std::string chart = "chart empty -o d --sweep one.json --size 32x18 --light-samples 1 --repeat 1";
  ASSERT_EQ(run(chart + " --resume").exit_code, 0);
  EXPECT_TRUE(fs::exists(path("d/rows/0001.json")));
  ASSERT_EQ(run(chart).exit_code, 0);
  for (const char* left :
       {"d/ledger.json", "d/ledger.exr", "d/images/ledger-reference.exr", "d/rows/0001.json", "d/images/0001.exr"})
    EXPECT_FALSE(fs::exists(path(left))) << left;
  EXPECT_TRUE(fs::exists(path("d/images/0000.exr")));
}

}  // namespace
}  // namespace sideray::cli_tests
