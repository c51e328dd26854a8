// Tests KHR_materials_volume_scatter: the surface that it makes, materials without scattering, and broken files.
#include <gmock/gmock.h>

#include <cmath>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

// A body 1 thick, of extinction 1 / `distance`, whose surface lets light in straight or diffusely.
SmallGltf body(double distance, const char* lets_in, const json& scatter) {
  SmallGltf g;
  json& e = g.json["materials"][0]["extensions"];
  e["KHR_materials_volume_scatter"] = scatter;
  const double share = std::exp(-1.0);
  e["KHR_materials_volume"] = {
      {"thicknessFactor", 1}, {"attenuationDistance", distance}, {"attenuationColor", {share, share, share}}};
  if (std::string(lets_in) == "straight")
    e["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
  else
    e["KHR_materials_diffuse_transmission"] = {{"diffuseTransmissionFactor", 1}};
  g.primitive()["material"] = 0;
  return g;
}

sideray_material_desc desc_of(SmallGltf g) {
  return g.load().materials.at(0).desc;
}

TEST(Scattering, DenseBodiesHaveTheColourOfTheirDepth) {
  for (const char* lets_in : {"straight", "diffuse"}) {
    const sideray_material_desc d = desc_of(body(0.001, lets_in, {{"multiscatterColorFactor", {0.8, 0.4, 0.1}}}));
    EXPECT_NEAR(d.base_color[0], 0.8f, 0.01f) << lets_in;
    EXPECT_NEAR(d.base_color[1], 0.4f, 0.01f);
    EXPECT_NEAR(d.base_color[2], 0.1f, 0.01f);
    EXPECT_EQ(d.transmission, 0.0f);
    EXPECT_LT(d.diffuse_transmission, 0.01f);
  }
}

TEST(Scattering, ThinOnesLetLightThrough) {
  const json white = {{"multiscatterColorFactor", {1, 1, 1}}};
  const sideray_material_desc clear = desc_of(body(1e4, "straight", white));
  EXPECT_GT(clear.transmission, 0.999f);
  // A white slab loses no light: it reflects what it does not transmit.
  const sideray_material_desc d = desc_of(body(0.2, "straight", white));
  EXPECT_NEAR(d.transmission, std::exp(-5.0), 1e-4);
  EXPECT_NEAR(d.base_color[0], 1.0f, 0.01f);
  EXPECT_NEAR(d.diffuse_transmission_color[0], 1.0f, 0.01f);
  EXPECT_GT(d.diffuse_transmission, 0.1f);
  EXPECT_LT(d.diffuse_transmission, 0.5f);
  // Light that scatters ahead comes farther.
  const sideray_material_desc ahead =
      desc_of(body(0.2, "straight", {{"multiscatterColorFactor", {1, 1, 1}}, {"scatterAnisotropy", 0.8}}));
  EXPECT_GT(ahead.diffuse_transmission, 1.5f * d.diffuse_transmission);
}

TEST(Scattering, TheSizeInTheSceneCounts) {
  SmallGltf g = body(0.2, "straight", {{"multiscatterColorFactor", {0.9, 0.9, 0.9}}});
  g.json["nodes"].push_back({{"mesh", 0}, {"scale", {10, 10, 10}}});
  g.json["scenes"][0]["nodes"] = {0, 1};
  const Content content = g.load();
  ASSERT_EQ(content.materials.size(), 2u);
  EXPECT_GT(content.materials[content.objects[0].material].desc.diffuse_transmission,
            3.0f * content.materials[content.objects[1].material].desc.diffuse_transmission);
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("what 2 materials scatter inside is shown as diffuse light")));
}

TEST(Scattering, WithoutAVolumeNothingScatters) {
  SmallGltf g = body(0.2, "straight", {{"multiscatterColor", {1, 1, 1}}});
  g.json["materials"][0]["extensions"].erase("KHR_materials_volume");
  const Content content = g.load();
  EXPECT_EQ(content.materials[0].desc.transmission, 1.0f);
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("nothing scatters")));
}

TEST(Scattering, ItsTextureIsNamed) {
  const json scatter = {{"multiscatterColorFactor", {1, 1, 1}}, {"multiscatterColorTexture", {{"index", 0}}}};
  EXPECT_THAT(body(0.2, "straight", scatter).load().warnings,
              ElementsAre(HasSubstr("give the mean of its colours as multiscatterColorFactor"), HasSubstr("is shown as diffuse light")));
}

TEST(Scattering, BrokenValuesAreRefusedByName) {
  EXPECT_THAT(body(1, "straight", {{"multiscatterColorFactor", {2, 0, 0}}}).load_error(),
              HasSubstr("multiscatterColorFactor of material material0 is outside 0 to 1"));
  EXPECT_THAT(body(1, "straight", {{"multiscatterColorFactor", {1, 0}}}).load_error(), HasSubstr("list of 3 numbers"));
  EXPECT_THAT(body(1, "straight", {{"scatterAnisotropy", 1}}).load_error(),
              HasSubstr("scatterAnisotropy of material material0 is 1, outside -1 to 1"));
}

}  // namespace
}  // namespace sideray::scenes
