// Tests variants of materials: which materials are shown, and refusals.
#include <gmock/gmock.h>
#include <sideray/scenes.h>

#include <sideray/scenes.hpp>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* name = "KHR_materials_variants";

// Two primitives: the first red, which "green" and "blue" change; the second, red too, which none changes.
struct Wardrobe : SmallGltf {
  Wardrobe() {
    json["extensionsUsed"] = {name};
    json["extensions"][name]["variants"] = {{{"name", "green"}}, {{"name", "blue"}}, {{"extras", 1}}};
    for (const std::vector<double>& color : {std::vector<double>{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}})
      json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorFactor", color}}}});
    primitive()["material"] = 0;
    json["meshes"][0]["primitives"].push_back(primitive());
    mappings() = {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1, 2}}}};
  }
  nlohmann::json& mappings() { return primitive()["extensions"][name]["mappings"]; }
  Content load_variant(const std::string& variant) {
    const ScratchFolder folder;
    return load_file(write(folder), {.animation = "", .variant = variant});
  }
  std::string error_of(const std::string& variant) {
    return message_of([&] { load_variant(variant); });
  }
};

std::vector<uint32_t> materials_of(const Content& content) {
  std::vector<uint32_t> materials;
  for (const Object& object : content.objects) materials.push_back(object.material);
  return materials;
}

TEST(Variants, PrimitivesHaveTheMaterialsOfTheVariant) {
  Wardrobe g;
  EXPECT_THAT(materials_of(g.load_variant("")), ElementsAre(0, 0));
  EXPECT_THAT(materials_of(g.load_variant("green")), ElementsAre(1, 0));
  EXPECT_THAT(materials_of(g.load_variant("blue")), ElementsAre(2, 0));
  EXPECT_THAT(materials_of(g.load_variant("variant2")), ElementsAre(2, 0)) << "the name of one without a name";
  EXPECT_THAT(g.load().warnings, IsEmpty());
}

TEST(Variants, TheFirstMappingOfAVariantCounts) {
  Wardrobe g;
  g.mappings().push_back({{"material", 0}, {"variants", {0}}});
  EXPECT_THAT(materials_of(g.load_variant("green")), ElementsAre(1, 0));
}

TEST(Variants, AnUnknownNameIsRefusedWithThoseThatThereAre) {
  Wardrobe g;
  EXPECT_THAT(g.error_of("teal"), AllOf(HasSubstr("no variant teal"), HasSubstr("choose one of green, blue, variant2")));
  EXPECT_THROW(g.load_variant("teal"), UnknownVariant);
  EXPECT_THROW(load("panes", {.animation = "", .variant = "teal"}), UnknownVariant);
  SmallGltf none;
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { load_file(none.write(folder), {.animation = "", .variant = "teal"}); }), HasSubstr("the scene has none"));
}

// A material that only another variant shows may be broken: nothing shown has it.
TEST(Variants, WhatIsNotShownMayBeBroken) {
  Wardrobe g;
  g.json["materials"][1]["pbrMetallicRoughness"]["metallicFactor"] = 7;
  EXPECT_THAT(materials_of(g.load_variant("blue")), ElementsAre(2, 0));
  EXPECT_THAT(g.error_of("green"), HasSubstr("metallicFactor of material material1 is 7"));
}

TEST(Variants, BrokenListsAreRefusedByName) {
  const auto refused = [](auto&& change) {
    Wardrobe g;
    change(g);
    return g.error_of("green");
  };
  EXPECT_THAT(refused([](Wardrobe& g) { g.mappings()[0]["material"] = 9; }),
              HasSubstr("KHR_materials_variants of mesh tri uses material 9, and there are 3"));
  EXPECT_THAT(refused([](Wardrobe& g) { g.mappings()[0].erase("material"); }), HasSubstr("uses material -1"));
  EXPECT_THAT(refused([](Wardrobe& g) { g.mappings()[0]["variants"] = {5}; }),
              HasSubstr("uses variant 5, and there are 3"));
  EXPECT_THAT(refused([](Wardrobe& g) { g.mappings()[0]["variants"] = "all"; }), HasSubstr("lists no variants"));
  EXPECT_THAT(refused([](Wardrobe& g) { g.mappings() = {1, 2}; }),
              HasSubstr("mappings of KHR_materials_variants of mesh tri is not a list of objects"));
  EXPECT_THAT(refused([](Wardrobe& g) { g.json["extensions"][name]["variants"] = 3; }),
              HasSubstr("variants of KHR_materials_variants is not a list of objects"));
}

TEST(Variants, InfoAndTheInterfaceListThem) {
  Wardrobe g;
  EXPECT_THAT(info_text(g.load()), HasSubstr("variants of materials\n  green\n  blue\n  variant2\n"));
  EXPECT_EQ(json::parse(info_json(g.load()))["variants"], json({"green", "blue", "variant2"}));
  const ScratchFolder folder;
  sideray_load_options options = sideray_load_defaults();
  options.variant = "blue";
  const std::string path = g.write(folder);
  EXPECT_THAT(sideray::Content::load(path, options).value().variants(), ElementsAre("green", "blue", "variant2"));
  options.variant = "teal";
  EXPECT_THAT(sideray::Content::load(path, options).error().message, HasSubstr("no variant teal"));
}

}  // namespace
}  // namespace sideray::scenes
