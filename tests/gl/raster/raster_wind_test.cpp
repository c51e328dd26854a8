// Wind in the rasterizer against meshes whose vertices were moved on the CPU by the same shaders/shading/wind.h.
#include <cmath>
#include <random>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"
#include "model/wind.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::gl::tests::raster_wind_test {
namespace {

constexpr double time_s = 1.55;
constexpr float phase = 0.37f;
constexpr uint32_t width = 96, height = 64;

struct Sheet {
  std::vector<glm::vec3> positions, normals;
  std::vector<uint32_t> indices;
};

// A bent sheet of 8 x 8 quads that stands on the origin, 2 high.
Sheet sheet() {
  constexpr uint32_t n = 8;
  Sheet s;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n;
      s.positions.emplace_back(1.6f * u - 0.8f, 2.0f * v, 0.3f * std::sin(4.0f * u));
      s.normals.emplace_back(0, 0, 1);
      if (x == n || y == n) continue;
      const uint32_t a = y * (n + 1) + x, b = a + n + 1;
      s.indices.insert(s.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  return s;
}

Sheet moved_on_cpu(Sheet s) {
  const sideray_wind_desc d = breeze();
  const shading::SrWind wind{{d.direction[0], d.direction[1], d.direction[2]},
                             d.amplitude,
                             d.height,
                             d.branch_amplitude,
                             d.leaf_amplitude,
                             d.wavelength};
  const glm::vec3 cycles = model::wind_phase({d}, time_s, phase);
  for (glm::vec3& p : s.positions) p += shading::sr_wind(wind, {cycles.x, cycles.y, cycles.z}, p);
  return s;
}

enum class Moved { no, by_shader, on_cpu };

uint32_t add_mesh(SceneBuilder& builder, const Sheet& s) {
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = static_cast<uint32_t>(s.positions.size());
  mesh.index_count = static_cast<uint32_t>(s.indices.size());
  mesh.indices = s.indices.data();
  mesh.positions.data = &s.positions[0].x;
  mesh.normals.data = &s.normals[0].x;
  return builder.scene.add_mesh(mesh, nullptr);
}

std::shared_ptr<const model::Snapshot> scene_of(Moved moved, sideray_alpha_mode mode) {
  SceneBuilder builder;
  sideray_material_desc leaf = plain_material();
  leaf.double_sided = 1;
  leaf.alpha_mode = mode;
  if (mode == SIDERAY_BLEND) leaf.base_color[3] = 0.5f;
  sideray_instance_desc d{};
  d.mesh = add_mesh(builder, moved == Moved::on_cpu ? moved_on_cpu(sheet()) : sheet());
  d.material = builder.material(leaf);
  const glm::dmat4 place =
      glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0.1, 0, -0.2)), 0.4, glm::dvec3(0, 1, 0));
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) d.world_from_object[3 * c + r] = place[c][r];
  d.surface_id = 5;
  d.visibility = SIDERAY_VISIBLE_ALL;
  // What sways throws no coloured shadow, and what was moved before would.
  if (mode == SIDERAY_BLEND) d.visibility &= ~uint32_t{SIDERAY_VISIBLE_SHADOW};
  if (moved == Moved::by_shader) {
    d.wind = builder.scene.add_wind(breeze());
    d.wind_phase = phase;
    builder.scene.set_time(time_s, time_s);
  }
  builder.scene.add_instances(&d, 1);
  // What the shadow falls on.
  builder.quad(builder.material(plain_material()),
               glm::scale(glm::rotate(glm::dmat4(1), -1.5707963, glm::dvec3(1, 0, 0)), glm::dvec3(4)), 6);
  sideray_light sun{};
  sun.type = SIDERAY_LIGHT_DIRECTIONAL;
  sun.direction[0] = 0.6f, sun.direction[1] = -0.64f, sun.direction[2] = -0.48f;
  for (float& c : sun.intensity) c = 2;
  builder.scene.set_lights(&sun, 1);
  return builder.commit();
}

struct Drawn {
  std::vector<double> distance;  // along the view axis, 0 = nothing
  std::vector<glm::uvec2> ids;
  std::vector<glm::vec4> color;
};

class RasterWind : public EveryContext {
 protected:
  Drawn draw(Moved moved, sideray_alpha_mode mode = SIDERAY_OPAQUE) {
    Rasterizer rasterizer(gl());
    rasterizer.set_scene(scene_of(moved, mode));
    rasterizer.resize(width, height);
    const RasterView view = rasterizer.make_view(camera_at({0.5, 2.5, 5}, {0, 1, 0}), glm::vec2(0));
    rasterizer.set_view(view);
    rasterizer.gbuffer();
    rasterizer.shadow_maps();
    rasterizer.light(true);
    rasterizer.translucency({});
    Drawn drawn;
    for (const auto& id : rasterizer.read_gbuffer().ids) drawn.ids.emplace_back(id.x, id.y);
    drawn.color = rasterizer.read_color();
    const std::vector<float> depth = rasterizer.read_depth();
    for (uint32_t i = 0; i < width * height; ++i) {
      const double x = (2.0 * (i % width) + 1) / width - 1, y = (2.0 * (i / width) + 1) / height - 1;
      const double z = view.zero_to_one_depth ? double{depth[i]} : 2.0 * double{depth[i]} - 1.0;
      const glm::dvec4 p = view.local_from_clip * glm::dvec4(x, y, z, 1);
      drawn.distance.push_back(drawn.ids[i].y == 0 ? 0 : -(view.view_from_local * (p / p.w)).z);
    }
    return drawn;
  }
};

size_t count_differing(const std::vector<glm::vec4>& a, const std::vector<glm::vec4>& b, float by) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += glm::length(a[i] - b[i]) > by;
  return count;
}

// Rounding moves vertices by less than 1e-5, so that a few end on another subpixel: pixels on outlines may turn, and
// distances differ by up to two subpixels' slope. A pixel is 0.08 wide here, and no slope is above 1.5.
TEST_P(RasterWind, the_shader_moves_vertices_as_the_cpu_does) {
  const Drawn still = draw(Moved::no), shader = draw(Moved::by_shader), cpu = draw(Moved::on_cpu);
  constexpr double bound = 0.08 * 1.5 * 2 / 256;
  size_t other_ids = 0, moved = 0, checked = 0;
  for (size_t i = 0; i < cpu.ids.size(); ++i) {
    moved += still.ids[i] != cpu.ids[i];
    other_ids += shader.ids[i] != cpu.ids[i];
    if (shader.ids[i] != cpu.ids[i]) continue;
    EXPECT_NEAR(shader.distance[i], cpu.distance[i], bound) << "pixel " << i;
    checked += cpu.ids[i].x == 5;
  }
  EXPECT_GT(moved, 200u) << "or the wind would not show";
  EXPECT_GT(checked, 300u);
  EXPECT_LE(other_ids, 4u);
}

TEST_P(RasterWind, shadows_move_along) {
  const Drawn still = draw(Moved::no), shader = draw(Moved::by_shader), cpu = draw(Moved::on_cpu);
  const auto floor_alone = [&](std::vector<glm::vec4> color) {
    for (size_t i = 0; i < color.size(); ++i)
      if (still.ids[i].x != 6 || cpu.ids[i].x != 6 || shader.ids[i].x != 6) color[i] = glm::vec4(0);
    return color;
  };
  EXPECT_GT(count_differing(floor_alone(still.color), floor_alone(cpu.color), 0.1f), 20u);
  EXPECT_LE(count_differing(floor_alone(shader.color), floor_alone(cpu.color), 0.1f), 4u);
}

TEST_P(RasterWind, translucent_surfaces_move_too) {
  const Drawn still = draw(Moved::no, SIDERAY_BLEND), shader = draw(Moved::by_shader, SIDERAY_BLEND),
              cpu = draw(Moved::on_cpu, SIDERAY_BLEND);
  EXPECT_GT(count_differing(still.color, cpu.color, 0.02f), 40u);
  EXPECT_LE(count_differing(shader.color, cpu.color, 0.02f), 8u);
}

// Side by side, with surface ids 1 to 4: two plants of a kind, one of another mesh, and a third of the first kind.
std::shared_ptr<const model::Snapshot> row_of_plants() {
  SceneBuilder builder;
  const uint32_t meshes[] = {add_mesh(builder, sheet()), add_mesh(builder, sheet())};
  const uint32_t leaf = builder.material(plain_material()), wind = builder.scene.add_wind(breeze());
  for (uint32_t i = 0; i < 4; ++i) {
    sideray_instance_desc d{};
    d.mesh = meshes[i == 2];
    d.material = leaf;
    d.world_from_object[0] = 0.5f, d.world_from_object[4] = d.world_from_object[8] = 1;
    d.world_from_object[9] = 1.2f * static_cast<float>(i) - 1.8f;
    d.surface_id = i + 1;
    d.visibility = SIDERAY_VISIBLE_ALL;
    d.wind = wind;
    d.wind_phase = 0.2f + 0.07f * static_cast<float>(i);
    builder.scene.add_instances(&d, 1);
  }
  builder.scene.set_time(time_s, time_s);
  return builder.commit();
}

struct Rest {
  std::vector<uint32_t> ids;
  std::vector<glm::vec4> offsets;
};

// As rt/poses/foliage.cpp poses them: the way is zero where rays hit the very surface that is drawn.
TEST_P(RasterWind, rest_offsets_tell_own_poses_from_shared_ones) {
  Rasterizer rasterizer(gl());
  rasterizer.set_scene(row_of_plants());
  rasterizer.resize(width, height);
  rasterizer.set_view(rasterizer.make_view(camera_at({0, 1.5, 5}, {0, 1, 0}), glm::vec2(0)));
  rasterizer.gbuffer();
  const auto rest = [&](uint32_t poses) {
    rasterizer.mark_inexact({.rest = true, .poses = poses});
    Rest r;
    r.offsets.resize(size_t{width} * height);
    gl().BindTexture(GL_TEXTURE_2D, rasterizer.rest_texture());
    gl().GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, r.offsets.data());
    for (const auto& id : rasterizer.read_gbuffer().ids) r.ids.push_back(id.x);
    return r;
  };
  const Rest shared = rest(2), all = rest(SIDERAY_POSES_ALL);
  size_t pixels[5] = {};
  for (size_t i = 0; i < shared.ids.size(); ++i) {
    const uint32_t id = shared.ids[i];
    ASSERT_LE(id, 4u);
    if (id == 0) continue;
    pixels[id] += glm::length(glm::vec3(shared.offsets[i])) > 0.001f;
    EXPECT_EQ(all.offsets[i], glm::vec4(0));
  }
  for (uint32_t id = 1; id <= 4; ++id) EXPECT_GT(pixels[id], 50u) << "plant " << id;
}

INSTANTIATE_TEST_SUITE_P(Contexts, RasterWind, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sideray::gl::tests::raster_wind_test
