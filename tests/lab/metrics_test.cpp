#include "lab/metrics/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>

#include "scenes/base/files.h"

namespace sideray::lab {
namespace {

using scenes::Image;
using scenes::Plane;

Image image_of(uint32_t width, uint32_t height, bool linear,
               const std::function<float(uint32_t x, uint32_t y, int channel)>& value) {
  Image image{width, height, {}, linear};
  for (int k = 0; k < 3; ++k) {
    Plane plane{std::string(1, "RGB"[k]), Plane::Type::half, {}, {}};
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) plane.values.push_back(value(x, y, k));
    image.planes.push_back(std::move(plane));
  }
  return image;
}

Image constant(uint32_t width, uint32_t height, bool linear, float level) {
  return image_of(width, height, linear, [=](uint32_t, uint32_t, int) { return level; });
}

// Values of independent implementations: tests/lab/data/expected.json names the pair and the metrics.
TEST(Metrics, AgreeWithIndependentImplementations) {
  const std::string folder = SIDERAY_SOURCE_DIR "/tests/lab/data/";
  std::ifstream file(folder + "expected.json");
  const nlohmann::json expected = nlohmann::json::parse(file);
  ASSERT_EQ(expected.size(), 5u);
  for (const auto& [pair, values] : expected.items()) {
    SCOPED_TRACE(pair);
    const std::string separator = " against ";
    const size_t at = pair.find(separator);
    const Image test = scenes::read_image(folder + pair.substr(0, at));
    const Image reference = scenes::read_image(folder + pair.substr(at + separator.size()));
    const nlohmann::json measured = to_json(compare(test, reference).metrics);
    for (const auto& [name, value] : values.items()) {
      if (name == "ppd") continue;
      const std::string key = name == "ssim_valid_window" ? "ssim" : name;
      ASSERT_TRUE(measured.contains(key)) << key;
      // The FLIP values are given to six decimals; their authors compute in float as well.
      const double tolerance = key == "flip" || key == "hdr_flip" ? 2e-5 : 1e-6;
      EXPECT_NEAR(measured[key].get<double>(), value.get<double>(),
                  tolerance * std::max(1.0, std::abs(value.get<double>())))
          << key;
    }
  }
}

// gray.png: 16x16 pixels of one channel, (13 x + 7 y) mod 256.
uint8_t gray_level(uint32_t x, uint32_t y) {
  return static_cast<uint8_t>((x * 13 + y * 7) % 256);
}

TEST(Metrics, AGrayPngIsItsColours) {
  const Image gray = scenes::read_image(SIDERAY_SOURCE_DIR "/tests/lab/data/gray.png");
  const Image colours = image_of(
      16, 16, false, [](uint32_t x, uint32_t y, int) { return static_cast<float>(gray_level(x, y)) / 255.0f; });
  EXPECT_EQ(*compare(gray, colours).metrics.psnr, 999.0);
}

TEST(Metrics, AlphaDoesNotCount) {
  std::vector<uint8_t> rgba;
  for (uint32_t y = 0; y < 16; ++y)
    for (uint32_t x = 0; x < 16; ++x) {
      rgba.insert(rgba.end(), 3, gray_level(x, y));
      rgba.push_back(static_cast<uint8_t>(16 * x));
    }
  const std::string path = testing::TempDir() + "sideray_metrics_alpha.png";
  scenes::write_file(path, scenes::encode_png(16, 16, 4, rgba, path));
  const Image test = scenes::read_image(path);
  std::remove(path.c_str());
  EXPECT_EQ(*compare(test, scenes::read_image(SIDERAY_SOURCE_DIR "/tests/lab/data/gray.png")).metrics.psnr, 999.0);
  Image clear = constant(16, 16, true, 1.0f), solid = clear;
  clear.planes.push_back({"A", Plane::Type::half, std::vector<float>(256, 0.0f), {}});
  solid.planes.push_back({"A", Plane::Type::half, std::vector<float>(256, std::nanf("")), {}});
  EXPECT_EQ(compare(clear, solid).metrics.nonfinite, 0u);
  EXPECT_EQ(*compare(clear, solid).metrics.relmse, 0.0);
}

// A linear image against its own PNG: only the rounding to 8 bits is left, at most half a step.
TEST(Metrics, ALinearImageAgainstItsPng) {
  const Image linear = image_of(40, 24, true, [](uint32_t x, uint32_t y, int k) {
    return static_cast<float>((x * 37 + y * 101 + static_cast<uint32_t>(k) * 59) % 257) / 256.0f;
  });
  const Display display{0.0f, scenes::Tonemap::none};
  const std::vector<uint8_t> bytes = scenes::quantize(scenes::display_values(linear, 0, scenes::Tonemap::none));
  const Image png = image_of(40, 24, false, [&](uint32_t x, uint32_t y, int k) {
    return static_cast<float>(bytes[3 * (y * 40 + x) + static_cast<uint32_t>(k)]) / 255.0f;
  });
  const Metrics m = compare(png, linear, display).metrics;
  EXPECT_GE(*m.psnr, -20 * std::log10(0.5 / 255));
  EXPECT_LT(*m.psnr, 999.0);
  EXPECT_FALSE(m.hdr_flip);
  EXPECT_FALSE(m.relmse) << "it needs linear values on both sides";
}

TEST(Metrics, IdenticalImages) {
  for (bool linear : {false, true}) {
    const Image image = image_of(32, 20, linear, [](uint32_t x, uint32_t y, int k) {
      return static_cast<float>((x * 7 + y * 3 + static_cast<uint32_t>(k) * 5) % 11) / 11.0f;
    });
    const Metrics m = compare(image, image).metrics;
    EXPECT_EQ(*m.flip, 0.0);
    EXPECT_EQ(*m.relmse, 0.0);
    EXPECT_EQ(*m.relmse_trimmed, 0.0);
    EXPECT_EQ(*m.psnr, 999.0);
    EXPECT_DOUBLE_EQ(*m.ssim, 1.0);
    EXPECT_EQ(m.hdr_flip.has_value(), linear);
    if (linear) {
      EXPECT_EQ(*m.hdr_flip, 0.0);
    }
    EXPECT_EQ(m.nonfinite, 0u);
  }
}

TEST(Metrics, PsnrOfAKnownDifference) {
  const Metrics m = compare(constant(16, 16, false, 0.5f), constant(16, 16, false, 0.75f)).metrics;
  EXPECT_NEAR(*m.psnr, -10.0 * std::log10(0.0625), 1e-12);
}

TEST(Metrics, RelmseOfAKnownDifference) {
  // (3 - 2)^2 / (2^2 + 0.01) everywhere: trimming changes nothing.
  const Metrics m = compare(constant(40, 30, true, 3.0f), constant(40, 30, true, 2.0f)).metrics;
  EXPECT_NEAR(*m.relmse, 1.0 / 4.01, 1e-12);
  EXPECT_NEAR(*m.relmse_trimmed, 1.0 / 4.01, 1e-12);
}

TEST(Metrics, TrimmingDropsTheLargestThousandth) {
  // 40 x 25 x 3 = 3000 terms: exactly the three of the one wrong pixel go.
  const Image reference = constant(40, 25, true, 1.0f);
  const Image test =
      image_of(40, 25, true, [](uint32_t x, uint32_t y, int) { return x == 7 && y == 9 ? 100.0f : 1.0f; });
  const Metrics m = compare(test, reference).metrics;
  EXPECT_NEAR(*m.relmse, 3 * 99.0 * 99.0 / 1.01 / 3000, 1e-9);
  EXPECT_EQ(*m.relmse_trimmed, 0.0);
}

TEST(Metrics, SsimOfTwoLevels) {
  // Without variance only the luminance term is left.
  const Metrics m = compare(constant(16, 16, false, 0.25f), constant(16, 16, false, 0.75f)).metrics;
  const double c1 = 1e-4;
  EXPECT_NEAR(*m.ssim, (2 * 0.25 * 0.75 + c1) / (0.25 * 0.25 + 0.75 * 0.75 + c1), 1e-9);
}

TEST(Metrics, SsimIsAbsentBelowOneWindow) {
  EXPECT_FALSE(compare(constant(10, 30, false, 0), constant(10, 30, false, 1)).metrics.ssim.has_value());
  EXPECT_TRUE(compare(constant(11, 11, false, 0), constant(11, 11, false, 1)).metrics.ssim.has_value());
}

TEST(Metrics, FlipOfBlackAgainstWhiteIsOneInTheMiddle) {
  // |L| differs by 100: far beyond the knee; no features. (paper, 2020, section 4: maximum is between green and blue)
  const Comparison c = compare(constant(64, 64, false, 0), constant(64, 64, false, 1));
  EXPECT_GT(*c.metrics.flip, 0.95);
  EXPECT_LE(*c.metrics.flip, 1.0);
  const Image green = image_of(8, 8, false, [](uint32_t, uint32_t, int k) { return k == 1 ? 1.0f : 0.0f; });
  const Image blue = image_of(8, 8, false, [](uint32_t, uint32_t, int k) { return k == 2 ? 1.0f : 0.0f; });
  EXPECT_NEAR(*compare(green, blue).metrics.flip, 1.0, 1e-4);
}

TEST(Metrics, NonFinitePixelsAreCountedAndHideTheRest) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const Image reference =
      image_of(16, 16, true, [=](uint32_t x, uint32_t y, int k) { return x == 1 && y == 2 && k == 0 ? nan : 1.0f; });
  const Image test =
      image_of(16, 16, true, [=](uint32_t x, uint32_t y, int) { return x == 5 && y == 5 ? -inf : 1.0f; });
  const Metrics m = compare(test, reference).metrics;
  EXPECT_EQ(m.nonfinite, 2u);
  EXPECT_EQ(to_json(m), nlohmann::ordered_json({{"nonfinite", 2}}));
}

TEST(Metrics, DifferentSizesAreRefused) {
  try {
    (void)compare(constant(4, 4, false, 0), constant(4, 5, false, 0));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("4x4 against 4x5"), std::string::npos);
  }
}

TEST(Metrics, ExposureReachesTheDisplayMetrics) {
  const Image dim = constant(16, 16, true, 0.1f), bright = constant(16, 16, true, 0.2f);
  EXPECT_GT(*compare(dim, bright, {2.0f, scenes::Tonemap::none}).metrics.flip,
            *compare(dim, bright, {-6.0f, scenes::Tonemap::none}).metrics.flip);
}

TEST(FalseColours, LightnessRises) {
  std::vector<float> ramp;
  for (int i = 0; i <= 100; ++i) ramp.push_back(static_cast<float>(i) / 100.0f);
  const std::vector<uint8_t> rgb = false_colours(ramp);
  ASSERT_EQ(rgb.size(), 303u);
  double last = -1;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const double luma = 0.2126 * rgb[i] + 0.7152 * rgb[i + 1] + 0.0722 * rgb[i + 2];
    EXPECT_GE(luma, last);
    last = luma;
  }
}

}  // namespace
}  // namespace sideray::lab
