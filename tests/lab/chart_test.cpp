#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <sideray/sideray.hpp>

#include "lab/chart/chart_results.h"
#include "lab/chart/configurations.h"
#include "lab/chart/pareto.h"

namespace sideray::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string refusal(const nlohmann::json& list) {
  try {
    parse_configurations(list, "f.json", "entry");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Configurations, ValuesBecomeText) {
  const auto list = parse_configurations(nlohmann::json::parse(R"([{}, {"layers": 4, "mask": "count", "check": true,
                                                                       "inexact-bias": 0.5, "resume": false}])"),
                                         "f.json", "entry");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_TRUE(list[0].empty());
  EXPECT_EQ(list[1],
            (Configuration{
                {"layers", "4"}, {"mask", "count"}, {"check", "true"}, {"inexact-bias", "0.5"}, {"resume", "false"}}));
}

TEST(Configurations, ErrorsNameFileEntryAndOption) {
  EXPECT_THAT(refusal({{"layers", 4}}), HasSubstr("f.json: is not an array"));
  EXPECT_THAT(refusal(nlohmann::json::array({nlohmann::json::object(), 3})), HasSubstr("f.json entry 1: is not"));
  EXPECT_THAT(refusal(nlohmann::json::parse(R"([{"mask": null}])")), HasSubstr("f.json entry 0: mask is neither"));
  EXPECT_THAT(refusal(nlohmann::json::parse(R"([{"mask": ["count"]}])")), HasSubstr("f.json entry 0: mask is neither"));
}

TEST(Pareto, KeepsWhatNothingBeats) {
  const std::vector<CostAndError> points{{1, 5.0}, {2, 3.0}, {3, 4.0}, {4, 1.0}, {5, 1.0}, {2, 6.0}};
  EXPECT_THAT(pareto_front(points), ElementsAre(true, true, false, true, false, false));
}

TEST(Pareto, EqualPointsAreBothOnTheFront) {
  const std::vector<CostAndError> points{{1, 2.0}, {1, 2.0}, {1, 3.0}, {2, 2.0}};
  EXPECT_THAT(pareto_front(points), ElementsAre(true, true, false, false));
}

TEST(Pareto, WhatHasNoErrorIsNeitherOnItNorBeats) {
  const std::vector<CostAndError> points{{1, {}}, {2, 2.0}};
  EXPECT_THAT(pareto_front(points), ElementsAre(false, true));
  EXPECT_TRUE(pareto_front({}).empty());
}

// Against the definition, pair by pair, over points with many ties.
TEST(Pareto, AgreesWithTheDefinition) {
  std::vector<CostAndError> points;
  for (uint32_t i = 0; i < 200; ++i)
    points.push_back({static_cast<double>(i * 7919 % 13), static_cast<double>(i * 104729 % 11)});
  const std::vector<bool> front = pareto_front(points);
  for (size_t i = 0; i < points.size(); ++i) {
    bool beaten = false;
    for (const CostAndError& other : points)
      beaten = beaten || (other.cost < points[i].cost && *other.error <= *points[i].error) ||
               (other.cost <= points[i].cost && *other.error < *points[i].error);
    EXPECT_EQ(front[i], !beaten) << i;
  }
}

TEST(Quartiles, InterpolateBetweenOrderStatistics) {
  const Quartiles q = quartiles({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(q.p25, 1.75);
  EXPECT_DOUBLE_EQ(q.median, 2.5);
  EXPECT_DOUBLE_EQ(q.p75, 3.25);
  EXPECT_DOUBLE_EQ(quartiles({7}).p25, 7);
  EXPECT_DOUBLE_EQ(quartiles({}).median, 0);
}

Json round_of(double frame_ms, const std::string& mask) {
  return {{"schema", 1},
          {"config", {{"size", "8x8"}, {"mask", mask}, {"repeat", 1}}},
          {"stages_ms", {{"trace", frame_ms / 2}, {"total_frame", frame_ms}}},
          {"p25", {{"trace", 0}, {"total_frame", 0}}},
          {"p75", {{"trace", 0}, {"total_frame", 0}}},
          {"rays", {{"total", 12}}},
          {"repeats", 1}};
}

ChartRow row_of(std::vector<double> frame_ms, const std::string& mask, Json error) {
  ChartRow row{{{"options", {{"mask", mask}}}}, {}, std::move(error), "images/" + mask + ".exr", {}};
  for (double ms : frame_ms) row.add_round(round_of(ms, mask));
  return row;
}

TEST(ChartRow, ComesBackFromItsFile) {
  const ChartRow row = row_of({3, 1, 2}, "count", {{"flip", 0.25}});
  const std::optional<ChartRow> back = parse_row(to_json(row).dump(), row.made_with);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->rounds(), 3u);
  EXPECT_EQ(to_json(*back), to_json(row));
}

Json frame_of(double ms, uint64_t rays) {
  Json frame = round_of(ms, "count");
  frame["config"]["time"] = rays;
  frame["rays"]["total"] = rays;
  return frame;
}

// Costs of a sequence are medians over its frames: the first one, which has no past, is one among them.
TEST(ChartRow, OfASequenceHoldsMediansOverFrames) {
  ChartRow row{{}, {}, {{"flip", 0.25}}, "images/x.exr", {}};
  row.add_round(std::vector<Json>{frame_of(90, 900), frame_of(10, 30), frame_of(20, 10), frame_of(30, 20)});
  EXPECT_EQ(row.rounds(), 1u);
  EXPECT_EQ(row.stats["rays"]["total"], 20) << "of four the lower in the middle";
  EXPECT_EQ(row.stats["config"]["time"], 20) << "what is not counted is the last frame's";
  row.add_round(std::vector<Json>{frame_of(80, 900), frame_of(11, 30), frame_of(21, 10), frame_of(31, 20)});
  EXPECT_EQ(row.rounds(), 2u);
  const std::optional<ChartRow> back = parse_row(to_json(row).dump(), row.made_with);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->frames, 4u);
  EXPECT_EQ(back->rounds(), 2u);
  const std::vector<ChartRow> rows{row};
  const Json results = results_json("panes", {}, rows, "flip");
  EXPECT_EQ(results["rows"][0]["stages_ms"]["total_frame"], 25.5);
  EXPECT_EQ(results["rows"][0]["repeats"], 2);
}

TEST(ChartRow, OfSomethingElseIsNotTaken) {
  const ChartRow row = row_of({1}, "count", {{"flip", 0.25}});
  const std::string text = to_json(row).dump();
  EXPECT_FALSE(parse_row(text, {{"options", {{"mask", "none"}}}}));
  for (size_t length = 0; length < text.size(); ++length)
    EXPECT_FALSE(parse_row(text.substr(0, length), row.made_with));
  EXPECT_FALSE(parse_row("[]", row.made_with));
  EXPECT_FALSE(parse_row(R"({"schema": 2})", row.made_with));
}

const std::vector<ChartRow>& three_rows() {
  static const std::vector<ChartRow> rows{row_of({10, 12, 11}, "none", {{"flip", 0.2}, {"psnr", 20}}),
                                          row_of({30, 20, 40}, "st,\"encil", {{"flip", 0.1}, {"psnr", 30}}),
                                          row_of({50, 50, 50}, "count", {{"flip", 0.1}, {"psnr", 35}})};
  return rows;
}

TEST(ChartResults, HoldMediansAndTheFront) {
  const Json results = results_json("panes", {"images/reference.exr", 64, 1e-4}, three_rows(), "flip");
  EXPECT_EQ(results["schema"], 1);
  EXPECT_EQ(results["scene"], "panes");
  EXPECT_EQ(results["reference"],
            (Json{{"image", "images/reference.exr"}, {"light_samples", 64}, {"self_error", 1e-4}}));
  ASSERT_EQ(results["rows"].size(), 3u);
  const Json& first = results["rows"][0];
  EXPECT_EQ(first["stages_ms"]["total_frame"], 11);
  EXPECT_EQ(first["p25"]["total_frame"], 10.5);
  EXPECT_EQ(first["p75"]["total_frame"], 11.5);
  EXPECT_EQ(first["stages_ms"]["trace"], 5.5);
  EXPECT_EQ(first["repeats"], 3);
  EXPECT_EQ(first["config"]["repeat"], 3);
  EXPECT_EQ(first["error"]["flip"], 0.2);
  EXPECT_EQ(first["image"], "images/none.exr");
  EXPECT_EQ(first["pareto"], true);
  EXPECT_EQ(results["rows"][1]["pareto"], true);
  EXPECT_EQ(results["rows"][2]["pareto"], false);
}

TEST(ChartResults, WhatTheReferenceLacksIsAbsent) {
  const Json results = results_json("panes", {"images/reference.exr", 1, {}}, three_rows(), "flip");
  EXPECT_EQ(results["reference"], (Json{{"image", "images/reference.exr"}, {"light_samples", 1}}));
}

TEST(ChartResults, LargerIsBetterForSomeMetrics) {
  const Json results = results_json("panes", {}, three_rows(), "psnr");
  for (const Json& row : results["rows"]) EXPECT_EQ(row["pareto"], true);
}

TEST(ChartResults, TheTableHasOneLineARowAndWhatDiffers) {
  std::istringstream csv(results_csv(results_json("panes", {}, three_rows(), "flip")));
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) lines.push_back(line);
  EXPECT_THAT(lines,
              ElementsAre("index,mask,trace_ms,trace_p25,trace_p75,total_frame_ms,total_frame_p25,total_frame_p75,"
                          "rays.total,flip,psnr,pareto,image",
                          "0,none,5.5,5.25,5.75,11.0,10.5,11.5,12,0.2,20,true,images/none.exr",
                          "1,\"st,\"\"encil\",15.0,12.5,17.5,30.0,25.0,35.0,12,0.1,30,true,"
                          "\"images/st,\"\"encil.exr\"",
                          "2,count,25.0,25.0,25.0,50.0,50.0,50.0,12,0.1,35,false,images/count.exr"));
}

}  // namespace
}  // namespace sideray::lab
