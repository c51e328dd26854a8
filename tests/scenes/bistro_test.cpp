// Tests that the bistro's glass is right for rays, and its size is small enough.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <map>
#include <set>

#include "scenes/builtin/builtin.h"
#include "scenes/support.h"

namespace sideray::scenes {
namespace {

bool is_translucent(const Material& m) {
  return m.desc.alpha_mode == SIDERAY_BLEND || m.desc.transmission > 0;
}

glm::vec3 position(const Mesh& mesh, size_t corner) {
  const float* p = &mesh.positions[3 * size_t{mesh.indices[corner]}];
  return {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f};  // + 0 makes -0 and 0 one point
}

class Bistro : public testing::TestWithParam<Settings> {
 protected:
  const Content content = generate("bistro", GetParam());
  const Material& material_of(const Object& object) const { return content.materials[object.material]; }
};

INSTANTIATE_TEST_SUITE_P(Parameters, Bistro,
                         testing::Values(Settings{}, Settings{{"seed", "7"}, {"tables", "8"}, {"bottles", "0"}},
                                         Settings{{"lamps", "1024"}}));

bool is_single_quad(const Mesh& mesh) {
  return mesh.indices.size() == 6 && mesh.positions.size() == 12;
}

// Each edge has two triangles, which run along it in opposite directions, and the faces look outward.
void expect_closed(const Mesh& mesh) {
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> edges;
  double volume = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    Point corners[3];
    glm::dvec3 p[3];
    for (size_t k = 0; k < 3; ++k) {
      p[k] = position(mesh, i + k);
      corners[k] = {position(mesh, i + k).x, position(mesh, i + k).y, position(mesh, i + k).z};
    }
    for (size_t k = 0; k < 3; ++k) ++edges[{corners[k], corners[(k + 1) % 3]}];
    volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6;
  }
  const auto wrong = std::count_if(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto back = edges.find({edge.first.second, edge.first.first});
    return edge.second != 1 || back == edges.end() || back->second != 1;
  });
  EXPECT_EQ(wrong, 0) << mesh.name;
  EXPECT_GT(volume, 0) << mesh.name;
}

TEST_P(Bistro, TranslucentIsClosedOrAMarkedSingleQuad) {
  std::set<uint32_t> checked;
  size_t objects = 0;
  for (const Object& object : content.objects) {
    if (!is_translucent(material_of(object))) continue;
    ++objects;
    const Mesh& mesh = content.meshes[object.mesh];
    if (is_single_quad(mesh)) {
      EXPECT_EQ(material_of(object).ray_traced, RayTraced::yes) << object.name;
      EXPECT_TRUE(material_of(object).desc.double_sided) << object.name;
    } else if (checked.insert(object.mesh).second) {
      expect_closed(mesh);
    }
  }
  EXPECT_GT(objects, 100u);
  EXPECT_GT(checked.size(), 15u);
}

TEST_P(Bistro, MeshesAreSound) {
  for (const Mesh& mesh : content.meshes) {
    ASSERT_FALSE(mesh.indices.empty()) << mesh.name;
    size_t degenerate = 0, skewed = 0, wrong_normals = 0;
    for (const float value : mesh.positions) ASSERT_TRUE(std::isfinite(value)) << mesh.name;
    for (const float value : mesh.uv0) ASSERT_TRUE(std::isfinite(value)) << mesh.name;
    for (size_t i = 0; i < mesh.normals.size(); i += 3) {
      const glm::vec3 n(mesh.normals[i], mesh.normals[i + 1], mesh.normals[i + 2]);
      wrong_normals += !(std::abs(glm::length(n) - 1.0f) < 1e-4f);
    }
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      ASSERT_LT(std::max({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]}), mesh.positions.size() / 3);
      const glm::dvec3 a = position(mesh, i), u = glm::dvec3(position(mesh, i + 1)) - a,
                       v = glm::dvec3(position(mesh, i + 2)) - a, n = glm::cross(u, v);
      // Thinner than a thousandth of its longest side is a needle that shading and rays disagree about.
      degenerate += !(glm::length(n) > 1e-3 * 1e-3 * std::max(glm::dot(u, u), glm::dot(v, v)));
      for (size_t k = 0; k < 3; ++k) {
        const float* normal = &mesh.normals[3 * size_t{mesh.indices[i + k]}];
        skewed += !(glm::dot(n, glm::dvec3(normal[0], normal[1], normal[2])) > 0);
      }
    }
    EXPECT_EQ(degenerate, 0u) << mesh.name;
    EXPECT_EQ(wrong_normals, 0u) << mesh.name;
    EXPECT_EQ(skewed, 0u) << mesh.name << ": normals that look away from their triangle";
  }
}

// Where a horizontal ray from the axis, between two of the lathe's columns, leaves or enters the mesh.
std::vector<double> crossings(const Mesh& mesh, double height) {
  const glm::dvec3 origin(0, height, 0), direction(std::cos(0.0413), 0, std::sin(0.0413));
  std::vector<double> found;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = position(mesh, i), u = glm::dvec3(position(mesh, i + 1)) - a,
                     v = glm::dvec3(position(mesh, i + 2)) - a, n = glm::cross(u, v);
    const double t = glm::dot(n, a - origin) / glm::dot(n, direction);
    const glm::dvec3 p = origin + t * direction - a;
    const double b = glm::dot(glm::cross(p, v), n) / glm::dot(n, n), c = glm::dot(glm::cross(u, p), n) / glm::dot(n, n);
    if (t > 0 && b >= 0 && c >= 0 && b + c < 1) found.push_back(t);
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST_P(Bistro, DrinksReachIntoTheirGlass) {
  std::set<uint32_t> checked;
  for (const Object& drink : content.objects) {
    if (!drink.name.starts_with("drink") || !checked.insert(drink.mesh).second) continue;
    const std::string suffix = drink.name.substr(5);
    const auto vessel = std::find_if(content.objects.begin(), content.objects.end(), [&](const Object& o) {
      return o.name == "glass" + suffix || o.name == "bottle" + suffix;
    });
    ASSERT_NE(vessel, content.objects.end()) << drink.name;
    const Mesh& inside = content.meshes[drink.mesh];
    double low = 1e9, high = -1e9;
    for (size_t i = 1; i < inside.positions.size(); i += 3) {
      low = std::min(low, double{inside.positions[i]});
      high = std::max(high, double{inside.positions[i]});
    }
    for (const double share : {0.2, 0.5, 0.9}) {
      const double height = low + share * (high - low);
      const std::vector<double> wall = crossings(content.meshes[vessel->mesh], height);
      const std::vector<double> liquid = crossings(inside, height);
      ASSERT_EQ(wall.size(), 2u) << vessel->name << " at " << height;
      ASSERT_EQ(liquid.size(), 1u) << drink.name << " at " << height;
      EXPECT_GT(liquid[0], wall[0]) << drink.name << ": a gap of air at " << height;
      EXPECT_LT(liquid[0], wall[1]) << drink.name << ": runs out at " << height;
    }
  }
  EXPECT_GT(checked.size(), 5u);
}

// A lamp's sphere that reaches through its frosted bulb would light around the glass.
TEST_P(Bistro, LampsLieInsideTheirBulbs) {
  size_t lamps = 0;
  for (const Object& bulb : content.objects) {
    const Mesh& mesh = content.meshes[bulb.mesh];
    if (mesh.name != "bulb") continue;
    const double* place = &bulb.world_from_object[9];
    for (const Light& lamp : content.lights) {
      const double* at = lamp.light.position;
      if (glm::distance(glm::dvec3(at[0], at[1], at[2]), glm::dvec3(place[0], place[1], place[2])) > 1e-3) continue;
      ++lamps;
      for (size_t corner = 0; corner < mesh.indices.size(); ++corner)
        ASSERT_GT(glm::length(position(mesh, corner)), lamp.light.radius) << lamp.name;
    }
  }
  EXPECT_EQ(lamps, 4u);
}

TEST_P(Bistro, NamesAreUnique) {
  std::set<std::string> materials, textures, nodes;
  for (const Material& material : content.materials)
    EXPECT_TRUE(materials.insert(material.name).second) << material.name;
  for (const Texture& texture : content.textures) EXPECT_TRUE(textures.insert(texture.name).second) << texture.name;
  for (const Object& object : content.objects) EXPECT_TRUE(nodes.insert(object.name).second) << object.name;
}

TEST_P(Bistro, StaysInItsBudgets) {
  size_t triangles = 0, bytes = 0;
  for (const Object& object : content.objects) triangles += content.meshes[object.mesh].indices.size() / 3;
  for (const Texture& texture : content.textures) {
    EXPECT_EQ(texture.rgba.size(), size_t{4} * texture.width * texture.height) << texture.name;
    EXPECT_LE(std::max(texture.width, texture.height), 1024u) << texture.name;
    bytes += texture.rgba.size();
  }
  EXPECT_LT(triangles, 400000u + 40u * (content.lights.size() - 8)) << "a small lamp has 36";
  EXPECT_LT(bytes, 30u << 20);
  EXPECT_EQ(content.lights.size(), GetParam().contains("lamps") ? 1024u : 8u);
  for (const Light& light : content.lights) EXPECT_GT(light.light.radius, 0.0f) << light.name;
}

// More lamps do not change existing ones, except for the brightness that the small ones share.
TEST(Builtin, TheBistrosLampsAreCounted) {
  const Content usual = generate("bistro", {});
  ASSERT_EQ(usual.lights.size(), 8u);
  const Content many = generate("bistro", {{"lamps", "40"}}), more = generate("bistro", {{"lamps", "1024"}});
  ASSERT_EQ(many.lights.size(), 40u);
  ASSERT_EQ(more.lights.size(), 1024u);
  for (size_t i = 0; i < many.lights.size(); ++i) {
    sideray_light a = many.lights[i].light, b = more.lights[i].light;
    if (i >= 8) std::copy_n(a.intensity, 3, b.intensity);
    EXPECT_EQ(std::memcmp(&a, &b, sizeof(a)), 0) << i;
    EXPECT_TRUE(i >= 8 || std::memcmp(&a, &usual.lights[i].light, sizeof(a)) == 0) << i;
  }
  double brightness = 0;
  for (size_t i = 8; i < more.lights.size(); ++i) brightness += double{more.lights[i].light.intensity[0]};
  EXPECT_NEAR(brightness, 12.0, 1e-3);
  const Content none = generate("bistro", {{"lamps", "0"}}), three = generate("bistro", {{"lamps", "3"}});
  EXPECT_TRUE(none.lights.empty());
  ASSERT_EQ(three.lights.size(), 3u);
  EXPECT_EQ(std::memcmp(&three.lights[2].light, &usual.lights[2].light, sizeof(sideray_light)), 0);
  EXPECT_EQ(none.objects.size(), usual.objects.size());
  EXPECT_THROW(generate("bistro", {{"lamps", "1025"}}), Error);
  EXPECT_THROW(generate("bistro", {{"lamps", "1.5"}}), Error);
}

TEST(Builtin, EmptyHasNothingTranslucent) {
  for (const Material& material : generate("empty", {}).materials) EXPECT_FALSE(is_translucent(material));
}

TEST(Builtin, TheSeedMovesWhatStandsOnTheTables) {
  const Content a = generate("bistro", {{"seed", "1"}}), b = generate("bistro", {{"seed", "2"}}),
                c = generate("bistro", {});
  const auto places = [](const Content& content) {
    std::map<std::string, std::pair<double, double>> found;
    for (const Object& o : content.objects)
      if (o.name.starts_with("glass1.")) found[o.name] = {o.world_from_object[9], o.world_from_object[11]};
    return found;
  };
  EXPECT_EQ(places(a), places(c));
  EXPECT_NE(places(a), places(b));
}

}  // namespace
}  // namespace sideray::scenes
