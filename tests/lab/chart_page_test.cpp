#include "lab/page/pages.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "lab/page/page_pictures.h"

namespace sideray::lab {
namespace {

scenes::Image noise(uint32_t width, uint32_t height, uint32_t seed) {
  std::mt19937 random(seed);
  scenes::Image image{width, height, {}, true};
  for (const char* name : {"R", "G", "B"}) {
    scenes::Plane plane{name, scenes::Plane::Type::half, {}, {}};
    for (size_t i = 0; i < size_t{width} * height; ++i)
      plane.values.push_back(static_cast<float>(random() % 1024) / 1023.0f);
    image.planes.push_back(std::move(plane));
  }
  return image;
}

TEST(ChartPage, DataCannotEndItsScript) {
  const std::string page = chart_page({{"points", {{{"label", "</script><b>\xff{{chart.js}}"}}}}});
  EXPECT_EQ(page.find("<b>"), std::string::npos);
  EXPECT_NE(page.find("\\u003c/script>\\u003cb>"), std::string::npos);
  EXPECT_NE(page.find("{{chart.js}}"), std::string::npos) << "data is not a template";
  EXPECT_NE(page.find("Chart.js v"), std::string::npos) << "the library is not in the page";
}

// Runs the page's scripts by a script of tests/lab.
void expect_script_passes(const char* script, const std::string& page) {
  const bool is_promised = std::getenv("SIDERAY_REQUIRE_CONTEXTS") != nullptr;  // script/test installs what tests need
  if (std::system("node --version >/dev/null 2>&1") != 0 && !is_promised) GTEST_SKIP() << "no node";
  const std::string path = testing::TempDir() + "sideray-page-" + std::to_string(getpid()) + ".html";
  std::ofstream(path) << page;
  EXPECT_EQ(std::system(("node '" SIDERAY_SOURCE_DIR "/tests/lab/" + std::string(script) + "' '" + path + "'").c_str()), 0);
  std::filesystem::remove(path);
}

// On rows of its own.
TEST(ChartPage, ChoosesScalesRowsAndTitle) {
  expect_script_passes("chart_page.js", chart_page({{"points", nlohmann::ordered_json::array()}}));
}

TEST(GoldenPage, ShowsWhatDiffersFirst) {
  expect_script_passes("golden_page.js", golden_page({{"pictures", nlohmann::ordered_json::array()}}));
}

TEST(PagePictures, SmallOnesAreExact) {
  const PageScale scale = page_scale(160, 90, 49);
  EXPECT_TRUE(scale.is_exact);
  EXPECT_EQ(scale.width, 160u);
  EXPECT_EQ(scale.height, 90u);
}

// Noise is the worst that can be asked of an encoder.
TEST(PagePictures, AllTogetherStayBelowTheLimit) {
  for (size_t pictures : {3, 49, 121}) {
    const PageScale scale = page_scale(1280, 720, pictures);
    EXPECT_FALSE(scale.is_exact);
    EXPECT_NEAR(static_cast<double>(scale.width) / scale.height, 16.0 / 9.0, 0.01);
    const std::string uri = page_picture(noise(1280, 720, 1), {}, scale);
    EXPECT_TRUE(uri.starts_with("data:image/jpeg;base64,"));
    EXPECT_LT(uri.size() * pictures, 9'000'000u) << pictures;
    EXPECT_GT(uri.size() * pictures, 500'000u) << pictures;
  }
}

TEST(PagePictures, AMapNeedsFinitePixels) {
  const PageScale scale = page_scale(16, 9, 3);
  const scenes::Image reference = noise(16, 9, 1);
  scenes::Image test = noise(16, 9, 2);
  const PagePicture page = page_picture(test, reference, {}, scale);
  ASSERT_TRUE(page.map);
  EXPECT_NE(*page.map, page.picture);
  EXPECT_NE(*page.map, *page_picture(reference, reference, {}, scale).map);
  test.planes[0].values[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(page_picture(test, reference, {}, scale).map);
}

}  // namespace
}  // namespace sideray::lab
