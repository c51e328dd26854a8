#include "lab/stress/stress_page.h"

#include <gtest/gtest.h>

namespace sideray::lab {
namespace {

StressRow row_of(const std::string& variant, bool is_default, double value) {
  StressRow row;
  row.name = "gap", row.variant = variant, row.is_default = is_default;
  row.parameters = {{"gap", value}};
  row.measure = "lost";
  row.value = value, row.bound = 0.5;
  row.map = {2, 1, {0, 1}};
  return row;
}

const std::vector<StressCase> cases{{"gap", "whether gaps count", nullptr}};

// What the exit code of `sideray stress` goes by.
TEST(Stress, OnlyDefaultsBeyondTheirBoundFailARun) {
  EXPECT_TRUE(failing_defaults({}).empty());
  EXPECT_TRUE(failing_defaults({row_of("listing", false, 1.0), row_of("ours", true, 0.5)}).empty());
  const std::vector<StressRow> rows{row_of("listing", false, 1.0), row_of("ours", true, 0.5),
                                    row_of("ours", true, 0.6)};
  const std::vector<const StressRow*> failing = failing_defaults(rows);
  ASSERT_EQ(failing.size(), 1u);
  EXPECT_EQ(failing[0], &rows[2]);
}

TEST(Stress, ThePageSaysWhereDefaultsFail) {
  const std::string good = stress_page(cases, {row_of("listing", false, 1.0), row_of("ours", true, 0.25)}, "a device");
  EXPECT_NE(good.find("Defaults pass all of their 1 rows"), std::string::npos);
  const std::string bad = stress_page(cases, {row_of("ours", true, 0.25), row_of("ours", true, 0.75)}, "a device");
  EXPECT_NE(bad.find("Defaults fail 1 of their 2 rows"), std::string::npos);
  EXPECT_NE(bad.find("gap 0.75: lost is 0.75, bound 0.5"), std::string::npos) << bad;
}

TEST(Stress, ThePageNeedsNoFileBesideIt) {
  const std::string page = stress_page(cases, {row_of("ours", true, 0.25)}, "a device");
  EXPECT_NE(page.find("<img src=\"data:image/png;base64,"), std::string::npos);
  EXPECT_EQ(page.find("src=\"maps"), std::string::npos);
}

}  // namespace
}  // namespace sideray::lab
