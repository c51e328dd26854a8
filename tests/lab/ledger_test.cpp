#include "lab/chart/ledger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <sideray/sideray.hpp>

namespace sideray::lab::ledger_test {
namespace {

using scenes::Image;
using Values = std::function<double(size_t pixel, size_t colour)>;

constexpr uint32_t width = 16, height = 9;

Image image_of(const Values& values, uint32_t columns = width) {
  Image image{columns, height, {}, true};
  for (size_t c = 0; c < 3; ++c) {
    scenes::Plane plane{std::string(1, "RGB"[c]), scenes::Plane::Type::half, {}, {}};
    for (size_t i = 0; i < size_t{columns} * height; ++i) plane.values.push_back(static_cast<float>(values(i, c)));
    image.planes.push_back(std::move(plane));
  }
  return image;
}

// Multiples of 2^-10 below 1, as halfs hold them.
double truth(size_t i, size_t c) {
  return static_cast<double>((i * 37 + c * 11) % 700) / 1024.0;
}
double left_half(size_t i, size_t) {
  return i % width < width / 2 ? 0.125 : 0.0;
}
double right_half(size_t i, size_t) {
  return i % width < width / 2 ? 0.0 : 0.25;
}

double sum_of_shares(const Ledger& ledger) {
  double sum = 0;
  for (const LedgerTerm* term : parts(ledger)) sum += term->share.value();
  return sum;
}

// Two shortcuts that have no pixel in common: each has its share of the squares, and nothing is left.
TEST(Ledger, ShortcutsApartHaveTheirShareOfTheSquares) {
  const auto both = [](size_t i, size_t c) { return truth(i, c) + left_half(i, c) + right_half(i, c); };
  const auto left = [](size_t i, size_t c) { return truth(i, c) + left_half(i, c); };
  const auto right = [](size_t i, size_t c) { return truth(i, c) + right_half(i, c); };
  const std::vector<LedgerPicture> without{{"right", image_of(left)}, {"left", image_of(right)}};
  const std::vector<LedgerPicture> chain{{"rest", image_of(truth)}};
  const Ledger ledger = make_ledger(image_of(both), without, chain, image_of(truth));
  EXPECT_DOUBLE_EQ(ledger.effects[0].share.value(), 0.8);  // 0.25^2 of 0.25^2 + 0.125^2
  EXPECT_DOUBLE_EQ(ledger.effects[1].share.value(), 0.2);
  EXPECT_EQ(ledger.interaction.share.value(), 0.0);
  EXPECT_EQ(ledger.interaction.mean_absolute, 0.0);
  EXPECT_EQ(ledger.residuals[0].mean_absolute, 0.0);
  EXPECT_DOUBLE_EQ(ledger.effects[0].mean, 0.125);
  EXPECT_DOUBLE_EQ(ledger.total.mean_absolute, (0.125 + 0.25) / 2);
}

// Where one shortcut hides the other, the interaction says by how much: 1 + 1 - 1 of a whole.
TEST(Ledger, HiddenShortcutsAreInTheInteraction) {
  const auto half = [](size_t i, size_t c) { return truth(i, c) + 0.5; };
  const std::vector<LedgerPicture> hidden{{"a", image_of(half)}, {"b", image_of(half)}};
  const std::vector<LedgerPicture> chain{{"rest", image_of(truth)}};
  const Ledger either = make_ledger(image_of(half), hidden, chain, image_of(truth));
  EXPECT_EQ(either.effects[0].share.value(), 0.0);
  EXPECT_EQ(either.effects[1].share.value(), 0.0);
  EXPECT_DOUBLE_EQ(either.interaction.share.value(), 1.0);

  const std::vector<LedgerPicture> needed{{"a", image_of(truth)}, {"b", image_of(truth)}};
  const Ledger both = make_ledger(image_of(half), needed, chain, image_of(truth));
  EXPECT_DOUBLE_EQ(both.effects[0].share.value(), 1.0);
  EXPECT_DOUBLE_EQ(both.effects[1].share.value(), 1.0);
  EXPECT_DOUBLE_EQ(both.interaction.share.value(), -1.0);
}

// An effect against the error counts below 0: switching it off alone makes the picture worse.
TEST(Ledger, AnEffectThatHidesAnErrorIsNegative) {
  const auto picture = [](size_t i, size_t c) { return truth(i, c) + 0.25; };
  const auto worse = [](size_t i, size_t c) { return truth(i, c) + 0.5; };
  const std::vector<LedgerPicture> without{{"a", image_of(worse)}};
  const std::vector<LedgerPicture> chain{{"rest", image_of(worse)}};
  const Ledger ledger = make_ledger(image_of(picture), without, chain, image_of(truth));
  EXPECT_DOUBLE_EQ(ledger.effects[0].share.value(), -1.0);
  EXPECT_DOUBLE_EQ(ledger.residuals[0].share.value(), 2.0);
}

// Whatever the pictures are: every pixel of the layers, the shares and the relmse add up.
TEST(Ledger, PartsAddUpToTheTotal) {
  const auto odd = [](size_t seed) {
    return [seed](size_t i, size_t c) {
      return static_cast<double>((i * i * (seed + 3) + 7 * c * seed + seed) % 2047) / 2048.0;
    };
  };
  const std::vector<LedgerPicture> without{{"a", image_of(odd(1))}, {"b", image_of(odd(2))}, {"c", image_of(odd(3))}};
  const std::vector<LedgerPicture> chain{{"first", image_of(odd(4))}, {"second", image_of(odd(5))}};
  const Image picture = image_of(odd(6)), reference = image_of(odd(7));
  const Ledger ledger = make_ledger(picture, without, chain, reference);
  EXPECT_NEAR(sum_of_shares(ledger), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(ledger.total.share.value(), 1.0);
  double relmse = 0, mean = 0;
  for (const LedgerTerm* term : parts(ledger)) relmse += term->relmse, mean += term->mean;
  EXPECT_NEAR(relmse, ledger.total.relmse, 1e-12 * ledger.total.relmse);
  EXPECT_NEAR(mean, ledger.total.mean, 1e-12);
  double expected = 0;
  for (size_t i = 0; i < size_t{width} * height; ++i)
    for (size_t c = 0; c < 3; ++c) {
      const double r = odd(7)(i, c), error = odd(6)(i, c) - r;
      expected += error * error / (r * r + 0.01);
      float sum = 0;  // these values are exact in floats too
      for (const LedgerTerm* term : parts(ledger)) sum += term->rgb[3 * i + c];
      ASSERT_EQ(sum, ledger.total.rgb[3 * i + c]);
      ASSERT_EQ(sum, static_cast<float>(error));
    }
  EXPECT_NEAR(ledger.total.relmse, expected / (3.0 * width * height), 1e-12);
}

TEST(Ledger, NoErrorHasNoShares) {
  const std::vector<LedgerPicture> chain{{"rest", image_of(truth)}};
  const Ledger ledger = make_ledger(image_of(truth), {}, chain, image_of(truth));
  EXPECT_FALSE(ledger.total.share);
  EXPECT_FALSE(to_json(ledger.interaction).contains("share"));
  EXPECT_EQ(largest_shown(ledger), 0.0);
  EXPECT_EQ(signed_colours(ledger.total, 0.0), std::vector<uint8_t>(size_t{3} * width * height, 255));
}

TEST(Ledger, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
  Image broken = image_of(left_half);
  broken.planes[1].values[5] = std::numeric_limits<float>::infinity();
  broken.planes[2].values[5] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<LedgerPicture> without{{"a", broken}};
  const std::vector<LedgerPicture> chain{{"rest", image_of(truth)}};
  const Ledger ledger = make_ledger(image_of(right_half), without, chain, image_of(truth));
  EXPECT_EQ(ledger.nonfinite, 1u);
  EXPECT_NEAR(sum_of_shares(ledger), 1.0, 1e-12);
  EXPECT_EQ(ledger.total.rgb[15], 0.0f);
}

TEST(Ledger, PicturesOfOtherSizesAreRefused) {
  const std::vector<LedgerPicture> without{{"culling", image_of(truth, width + 1)}};
  try {
    make_ledger(image_of(truth), without, {}, image_of(truth));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("culling"), std::string::npos) << error.what();
  }
}

// Marked pixels are taken out of the last residual, and of nothing else.
TEST(Ledger, PixelsApartHaveAResidualOfTheirOwn) {
  const auto error = [](size_t i, size_t c) { return truth(i, c) + left_half(i, c) + right_half(i, c); };
  const std::vector<LedgerPicture> chain{{"first", image_of(error)}, {"last", image_of(error)}};
  std::vector<uint8_t> apart(size_t{width} * height);
  for (size_t i = 0; i < apart.size(); ++i) apart[i] = right_half(i, 0) > 0;
  const Ledger ledger = make_ledger(image_of(error), {}, chain, image_of(truth), apart);
  ASSERT_EQ(ledger.residuals.size(), 3u);
  EXPECT_EQ(ledger.residuals[0].mean_absolute, 0.0);
  EXPECT_DOUBLE_EQ(ledger.residuals[1].mean, 0.0625);
  EXPECT_EQ(ledger.residuals[2].name, "visibility");
  EXPECT_DOUBLE_EQ(ledger.residuals[2].mean, 0.125);
  EXPECT_EQ(ledger.interaction.mean_absolute, 0.0);
}

TEST(Ledger, LayersAreNamed) {
  const std::vector<LedgerPicture> without{{"bias", image_of(left_half)}};
  const std::vector<LedgerPicture> chain{{"opaque", image_of(right_half)}};
  const Ledger ledger = make_ledger(image_of(truth), without, chain, image_of(truth));
  const Image layers = layers_of(ledger);
  EXPECT_EQ(layers.planes.size(), 12u);
  ASSERT_NE(layers.find("bias.G"), nullptr);
  EXPECT_EQ(layers.find("bias.G")->values[3], ledger.effects[0].rgb[10]);
  for (const char* name : {"total.R", "interaction.B", "residual.opaque.R"})
    EXPECT_NE(layers.find(name), nullptr) << name;
}

// Red is too bright, blue too dark.
TEST(Ledger, ColoursSayTheSign) {
  const auto picture = [](size_t i, size_t c) { return truth(i, c) + right_half(i, c) - left_half(i, c); };
  const std::vector<LedgerPicture> chain{{"rest", image_of(truth)}};
  const Ledger ledger = make_ledger(image_of(picture), {}, chain, image_of(truth));
  EXPECT_DOUBLE_EQ(largest_shown(ledger), 0.75);
  const std::vector<uint8_t> colours = signed_colours(ledger.total, largest_shown(ledger));
  EXPECT_LT(colours[0], colours[2]);
  EXPECT_GT(colours[3 * (width - 1)], colours[3 * (width - 1) + 2]);
}

}  // namespace
}  // namespace sideray::lab::ledger_test
