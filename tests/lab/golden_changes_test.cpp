// Tests which object is reported as changed, on pictures with known objects.
#include "lab/golden/changes.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

namespace sideray::lab::golden_changes_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr uint32_t width = 12, height = 8;

// Squares in front of a background whose distance is infinite.
struct Square {
  NamedObject object;
  uint32_t left, top, side;
  float distance, grey;
};

Square square(const std::string& name, uint32_t surface, uint32_t left, float distance, float grey = 0.5f) {
  return {{name, 1, 1, {surface}, std::to_string(left)}, left, 2, 3, distance, grey};
}

struct Drawn {
  scenes::Image picture{width, height, {}, true}, ids{width, height, {}, true};
  std::vector<NamedObject> objects;

  ShownPicture shown() const { return {picture, ids, objects}; }
  std::vector<float>& values(size_t plane) { return picture.planes[plane].values; }
};

Drawn draw(const std::vector<Square>& squares) {
  using Type = scenes::Plane::Type;
  constexpr size_t pixels = size_t{width} * height;
  Drawn drawn;
  for (const char* name : {"A", "B", "G", "R"})
    drawn.picture.planes.push_back({name, Type::half, std::vector<float>(pixels, 0.125f), {}});
  drawn.ids.planes.push_back({"first.Z", Type::half, std::vector<float>(pixels, std::numeric_limits<float>::infinity()), {}});
  drawn.ids.planes.push_back({"first.surface", Type::uint, {}, std::vector<uint32_t>(pixels, 0)});
  for (const Square& s : squares) {
    drawn.objects.push_back(s.object);
    for (uint32_t y = s.top; y < s.top + s.side; ++y)
      for (uint32_t x = s.left; x < s.left + s.side; ++x) {
        const size_t i = size_t{y} * width + x;
        if (drawn.ids.planes[0].values[i] <= s.distance) continue;
        drawn.ids.planes[0].values[i] = s.distance;
        drawn.ids.planes[1].uint_values[i] = s.object.surfaces[0];
        for (size_t k = 1; k < 4; ++k) drawn.values(k)[i] = s.grey;
      }
  }
  return drawn;
}

Differences between(const Drawn& now, const Drawn& reference, SceneNow scene = {}) {
  for (const NamedObject& object : now.objects)
    scene.objects[object.name] = std::max(scene.objects[object.name], object.of);
  scene.radiance = &now.picture;
  return differences(now.shown(), reference.shown(), scene, {});
}

std::vector<std::string> said(const Differences& differences) {
  std::vector<std::string> texts;
  for (const Change& change : differences.changes) texts.push_back(describe(change));
  return texts;
}

TEST(GoldenChanges, EqualPicturesHaveNone) {
  const Drawn drawn = draw({square("a", 1, 1, 5), square("b", 2, 6, 3)});
  const Differences none = between(drawn, drawn);
  EXPECT_TRUE(none.is_equal);
  EXPECT_THAT(none.changes, IsEmpty());
}

// Of three columns one is new in front and one is gone: the background that shows there has not moved.
TEST(GoldenChanges, TheObjectInFrontMovedNotWhatIsBehindIt) {
  const Drawn reference = draw({square("floor", 1, 0, 9), square("vase", 2, 4, 3)});
  const Drawn now = draw({square("floor", 1, 0, 9), square("vase", 2, 5, 3)});
  const Differences changes = between(now, reference);
  EXPECT_THAT(said(changes), ElementsAre("'vase' moved (6 pixels)"));
  EXPECT_FALSE(changes.has_same_ids);
  EXPECT_EQ(changes.pixels, 6u);
}

TEST(GoldenChanges, WhatIsUncoveredHasNotMoved) {
  const Drawn reference = draw({square("floor", 1, 3, 9), square("vase", 2, 4, 3)});
  const Drawn now = draw({square("floor", 1, 3, 9), square("vase", 2, 8, 3)});
  EXPECT_THAT(said(between(now, reference)), ElementsAre("'vase' moved (18 pixels)"));
}

TEST(GoldenChanges, ObjectsGoAndCome) {
  const Drawn with = draw({square("a", 1, 1, 5), square("b", 2, 6, 3)}), without = draw({square("a", 1, 1, 5)});
  EXPECT_THAT(said(between(without, with)), ElementsAre("'b' is missing (9 pixels)"));
  EXPECT_THAT(said(between(with, without)), ElementsAre("'b' appears (9 pixels)"));
  EXPECT_THAT(said(between(without, with, {{{"b", 1}}, true})), ElementsAre("'b' is out of sight (9 pixels)"));
}

// A third "tree" in front of the list shifts the numbers of the others.
TEST(GoldenChanges, EqualNamesAreToldByTheirPixelsWhereNumbersShift) {
  const auto tree = [](uint32_t surface, uint32_t left, uint32_t number, uint32_t of) {
    Square s = square("tree", surface, left, 4);
    s.object.number = number, s.object.of = of;
    return s;
  };
  const Drawn reference = draw({tree(1, 0, 1, 2), tree(2, 4, 2, 2)});
  const Drawn now = draw({tree(1, 8, 1, 3), tree(2, 0, 2, 3), tree(3, 4, 3, 3)});
  EXPECT_THAT(said(between(now, reference)), ElementsAre("'tree #1' appears (9 pixels)"));
  EXPECT_THAT(said(between(reference, now)), ElementsAre("'tree #1' is missing (9 pixels)"));
}

// It covers the same pixels all the same: a wall that slides along itself.
TEST(GoldenChanges, ADifferentPlaceIsAMoveWhereColoursChange) {
  const Drawn reference = draw({square("wall", 1, 1, 5)});
  Drawn now = draw({square("wall", 1, 1, 5, 0.25f)});
  const std::vector<std::string> look = said(between(now, reference));
  ASSERT_EQ(look.size(), 1u);
  EXPECT_THAT(look[0], testing::MatchesRegex("'wall' looks otherwise .FLIP 0.[0-9]+ over 9 pixels."));
  now.objects[0].place = "elsewhere";
  EXPECT_THAT(said(between(now, reference)), ElementsAre("'wall' moved (9 pixels)"));
}

// The moved object comes first, as the cause of other changes.
TEST(GoldenChanges, MovesStandBeforeLooks) {
  const Drawn reference = draw({square("floor", 1, 6, 9), square("vase", 2, 1, 3)});
  const Drawn now = draw({square("floor", 1, 6, 9, 0.25f), square("vase", 2, 2, 3)});
  const std::vector<std::string> texts = said(between(now, reference));
  ASSERT_EQ(texts.size(), 2u);
  EXPECT_EQ(texts[0], "'vase' moved (6 pixels)");
  EXPECT_TRUE(texts[1].starts_with("'floor' looks otherwise")) << texts[1];
}

void for_colours(Drawn& drawn, const std::function<float(float)>& change) {
  for (size_t k = 1; k < 4; ++k)
    for (float& v : drawn.values(k)) v = change(v);
}

TEST(GoldenChanges, OneFactorIsTheLight) {
  const Drawn reference = draw({square("a", 1, 1, 5), square("b", 2, 6, 3, 0.75f)});
  Drawn now = reference;
  for_colours(now, [](float v) { return 0.98f * v; });
  EXPECT_THAT(said(between(now, reference)), ElementsAre("the light is 0.98 times as bright everywhere"));
  // An offset is no factor, and neither is another light on one object.
  now = reference;
  for_colours(now, [](float v) { return v + 0.125f; });
  EXPECT_EQ(said(between(now, reference)).size(), 3u);
  now = draw({square("a", 1, 1, 5, 0.49f), square("b", 2, 6, 3, 0.75f)});
  EXPECT_EQ(said(between(now, reference)).size(), 1u);
  EXPECT_TRUE(said(between(now, reference))[0].starts_with("'a' looks otherwise"));
}

// Display values are no multiples of each other: every curve has a toe or a shoulder, and 8 bits.
TEST(GoldenChanges, TheLightIsFoundBehindEveryToneCurve) {
  Drawn reference = draw({square("a", 1, 1, 5), square("b", 2, 6, 3, 1.5f)});
  for (size_t k = 1; k < 4; ++k)
    for (size_t i = 0; i < width * height; ++i) reference.values(k)[i] *= 0.1f + 0.02f * static_cast<float>(i % 50);
  Drawn now = reference;
  for_colours(now, [](float v) { return 1.05f * v; });
  for (const scenes::Tonemap curve : {scenes::Tonemap::none, scenes::Tonemap::reinhard, scenes::Tonemap::aces,
                                      scenes::Tonemap::aces_filmic, scenes::Tonemap::pbr_neutral}) {
    const Display display{0.5f, curve};
    const auto shown = [&](const Drawn& drawn) {
      Drawn result = drawn;
      const std::vector<uint8_t> bytes = scenes::quantize(scenes::display_values(drawn.picture, 0.5f, curve));
      result.picture.linear = false;
      for (size_t i = 0; i < bytes.size(); ++i)  // planes are A, B, G, R
        result.values(3 - i % 3)[i / 3] = static_cast<float>(bytes[i]) / 255.0f;
      return result;
    };
    const Drawn then = shown(reference), later = shown(now);
    const Differences changes = differences(later.shown(), then.shown(), {{}, true, &now.picture}, display);
    ASSERT_EQ(changes.changes.size(), 1u) << static_cast<int>(curve);
    EXPECT_EQ(changes.changes[0].kind, ChangeKind::light);
    EXPECT_NEAR(changes.changes[0].factor, 1.05, 0.005) << static_cast<int>(curve);
  }
}

TEST(GoldenChanges, OtherCamerasAndChannelsAreNamed) {
  const Drawn reference = draw({square("a", 1, 1, 5)});
  EXPECT_THAT(said(between(reference, reference, {{}, false})), ElementsAre("the camera is another one"));
  Drawn now = reference;
  now.values(0)[5] = 0.5f;
  const Differences alpha = between(now, reference);
  EXPECT_FALSE(alpha.is_equal);
  EXPECT_EQ(alpha.flip, 0.0);
  EXPECT_THAT(said(alpha), ElementsAre("channels A differ (1 pixel)"));
}

// The least step of a float counts, and so do signs of 0 and numbers that are none.
TEST(GoldenChanges, EveryBitCounts) {
  Drawn reference = draw({square("a", 1, 1, 5)});
  reference.values(3)[0] = 0.0f;
  for (const float other : {-0.0f, std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::quiet_NaN()}) {
    Drawn now = reference;
    now.values(3)[0] = other;
    EXPECT_FALSE(is_same_image(now.picture, reference.picture)) << other;
    EXPECT_EQ(between(now, reference).pixels, 1u);
  }
  Drawn broken = reference;
  broken.values(3)[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(between(broken, broken).is_equal);
  EXPECT_EQ(between(broken, reference).flip, std::nullopt);
  EXPECT_THAT(said(between(broken, reference)), ElementsAre("the background looks otherwise (1 pixel)"));
}

TEST(GoldenChanges, TextsStayShort) {
  const std::vector<Change> many(5, {ChangeKind::moved, "a\nb", 1234567, {}, 1});
  EXPECT_EQ(describe(many, 2), "'a b' moved (1,234,567 pixels), 'a b' moved (1,234,567 pixels), 3 more");
  EXPECT_EQ(describe({}, 2), "");
}

}  // namespace
}  // namespace sideray::lab::golden_changes_test
