// Which meshes have an inside.
#include "model/solid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sideray::model {
namespace {

// The cube -1..1, a triangle's corners each on their own, as flat normals need them.
Mesh cube(float size = 1.0f, glm::vec3 center = glm::vec3(0)) {
  Mesh mesh;
  const auto corner = [&](uint32_t i) {
    return center + size * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  };
  const uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : faces)
    for (const auto& t : {glm::uvec3(f[0], f[1], f[2]), glm::uvec3(f[0], f[2], f[3])}) {
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (int k = 0; k < 3; ++k) mesh.positions.push_back(corner(t[k]));
      mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
  for (const glm::vec3 p : mesh.positions) mesh.bounds.add(p);
  return mesh;
}

TEST(Solid, ACubeOfSeparateTrianglesIsClosed) {
  EXPECT_TRUE(is_closed(cube()));
  EXPECT_TRUE(is_closed(cube(1e-3f)));
  EXPECT_TRUE(is_closed(cube(1e4f)));
  EXPECT_TRUE(is_closed(cube(1.0f, {1e4f, -1e4f, 1e4f})));
}

TEST(Solid, CornersThatRoundingSeparatesAreOne) {
  Mesh mesh = cube();
  for (size_t i = 0; i < mesh.positions.size(); ++i) mesh.positions[i] += 2e-6f * std::sin(static_cast<float>(i));
  EXPECT_TRUE(is_closed(mesh));
  for (size_t i = 0; i < mesh.positions.size(); ++i) mesh.positions[i] += 2e-3f * std::sin(static_cast<float>(i));
  EXPECT_FALSE(is_closed(mesh));
}

TEST(Solid, AHoleOrAFlippedTriangleOpensIt) {
  for (size_t i = 0; i < cube().triangles.size(); ++i) {
    Mesh hole = cube(), flipped = cube();
    hole.triangles.erase(hole.triangles.begin() + static_cast<ptrdiff_t>(i));
    std::swap(flipped.triangles[i].x, flipped.triangles[i].y);
    EXPECT_FALSE(is_closed(hole));
    EXPECT_FALSE(is_closed(flipped));
  }
  Mesh quad = cube();
  quad.triangles.resize(2);
  EXPECT_FALSE(is_closed(quad));
  EXPECT_FALSE(is_closed(Mesh{}));
}

}  // namespace
}  // namespace sideray::model
