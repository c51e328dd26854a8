// Tests lines and points of files as meshes: their modes, and broken files.
#include <gmock/gmock.h>

#include <cmath>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Four vertices.
SmallGltf with_mode(int mode) {
  SmallGltf g;
  g.primitive()["attributes"]["POSITION"] =
      g.add(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 5126, "VEC3", 4);
  g.primitive()["mode"] = mode;
  return g;
}

void expect_taken(const Content& content) {
  Scene scene = Scene::create().value();
  EXPECT_EQ(message_of([&] { fill(scene, content, std::vector<bool>(content.objects.size(), false)); }), "");
}

TEST(Thin, ModesBecomeLinesAndPoints) {
  const auto mesh_of = [](int mode) {
    const Content content = with_mode(mode).load();
    EXPECT_THAT(content.warnings, IsEmpty());
    expect_taken(content);
    return content.meshes.at(0);
  };
  EXPECT_EQ(mesh_of(0).topology, SIDERAY_POINTS);
  EXPECT_THAT(mesh_of(0).indices, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(mesh_of(1).topology, SIDERAY_LINES);
  EXPECT_THAT(mesh_of(1).indices, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(mesh_of(2).indices, ElementsAre(0, 1, 1, 2, 2, 3, 3, 0));
  EXPECT_THAT(mesh_of(3).indices, ElementsAre(0, 1, 1, 2, 2, 3));
  EXPECT_EQ(mesh_of(4).topology, SIDERAY_TRIANGLES);
}

TEST(Thin, OddEndsAndBrokenPositionsAreLeftOut) {
  SmallGltf odd = with_mode(1);
  odd.primitive()["indices"] = odd.add(std::vector<uint32_t>{0, 1, 2}, 5125, "SCALAR", 3);
  EXPECT_THAT(odd.load().meshes.at(0).indices, ElementsAre(0, 1));
  SmallGltf outside = with_mode(0);
  outside.primitive()["indices"] = outside.add(std::vector<uint32_t>{9}, 5125, "SCALAR", 1);
  EXPECT_THAT(outside.load_error(), HasSubstr("mesh tri uses vertex 9, and there are 4"));
  SmallGltf broken = with_mode(3);
  broken.primitive()["attributes"]["POSITION"] =
      broken.add(std::vector<float>{0, 0, 0, NAN, 0, 0, 1, 1, 0, 0, 1, 0}, 5126, "VEC3", 4);
  const Content content = broken.load();
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("2 of 3 lines have positions that are not finite")));
  expect_taken(content);
  SmallGltf lone = with_mode(3);
  lone.primitive()["indices"] = lone.add(std::vector<uint32_t>{1}, 5125, "SCALAR", 1);
  EXPECT_THAT(lone.load().warnings, ElementsAre(HasSubstr("it has no lines; left out")));
  EXPECT_THAT(with_mode(9).load().warnings, ElementsAre(HasSubstr("its mode 9 is unknown; left out")));
}

TEST(Thin, TranslucentMaterialsAreNamed) {
  SmallGltf g = with_mode(1);
  g.json["materials"] = {{{"alphaMode", "BLEND"}}};
  g.primitive()["material"] = 0;
  const Content content = g.load();
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("its material is translucent, and its lines are drawn opaque")));
  EXPECT_THAT(select_ray_traced(content, "all", {}, 1, 1), ElementsAre(false));
  EXPECT_THAT(info_text(content), HasSubstr("2 lines, 0 points"));
}

// Morph targets and files written again keep what they are.
TEST(Thin, TheyMoveAndAreWritten) {
  SmallGltf g = with_mode(2);
  const size_t target = g.add(std::vector<float>{0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 4);
  const size_t times = g.add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
  const size_t weights = g.add(std::vector<float>{0, 1}, 5126, "SCALAR", 2);
  g.primitive()["targets"] = {{{"POSITION", target}}};
  g.json["animations"] = {{{"samplers", {{{"input", times}, {"output", weights}}}},
                           {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  Content content = g.load();
  Scene scene = Scene::create().value();
  fill(scene, content, {false});
  pose(content, 0.5);
  EXPECT_EQ(content.meshes[0].topology, SIDERAY_LINES);
  EXPECT_EQ(content.meshes[0].positions[3], 2.0f);
  EXPECT_EQ(message_of([&] { move(scene, content); }), "");
  const ScratchFolder folder;
  write_glb(folder / "again.glb", content);
  const Content again = load_file(folder / "again.glb");
  EXPECT_EQ(again.meshes.at(0).topology, SIDERAY_LINES);
  EXPECT_EQ(again.meshes[0].indices, content.meshes[0].indices);
}

}  // namespace
}  // namespace sideray::scenes
