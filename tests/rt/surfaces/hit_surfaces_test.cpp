// Surfaces of many hits in lanes against those of single hits, bit for bit, with every instruction set: materials with
// textures in all slots, wraps, filters and levels, mirrored and solid instances, colours, tangents, sprites.
#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <set>
#include <vector>

#include "model/material_slots.h"
#include "rt/poses/particle_quads.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/kernel_sets.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

class HitScenario {
 public:
  // `fixed`: in a scene of the fixed function.
  explicit HitScenario(bool fixed = false) : fixed_(fixed) {
    model::FixedDesc model{};
    model.desc.ambient[0] = model.desc.ambient[2] = 0.3f, model.desc.separate_specular = 1;
    if (fixed) scene_.scene.set_fixed_function(&model);
    for (int i = 0; i < 6; ++i) textures_.push_back(add_texture(i));
    for (int i = 0; i < 40; ++i) add_instance(i);
    sideray_particles_desc system{};
    system.size = sizeof(system);
    system.columns = system.rows = 1, system.lit = 1;
    const uint32_t particles = scene_.scene.add_particles(system);
    sideray_sprite sprite{{0.5, 0.2, -3}, 1.0f, 1.0f, 0.3f, {0.5f, 0.6f, 0.7f, 0.8f}, 0.0f};
    scene_.scene.set_sprites(particles, &sprite, 1);
    const std::shared_ptr<const model::Snapshot> committed = scene_.commit();
    shading = std::make_unique<ShadingScene>(
        with_sprite_quads(*committed, perspective({0, 0, 0}, {0, 0, -1}, 1.0, 1.0), 100));
    for (int i = 0; i < 20003; ++i) add_hit();
  }

  std::unique_ptr<ShadingScene> shading;
  std::vector<Hit> hits;
  std::vector<Ray> rays;
  std::vector<Cone> cones;

 private:
  float any() { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(random_); }
  float positive() { return std::abs(any()); }
  bool often() { return random_() % 2 == 0; }

  // Sizes that are no powers of two, down to a texel.
  uint32_t add_texture(int i) {
    const uint32_t widths[] = {64, 1, 37, 5, 128, 16}, heights[] = {64, 1, 20, 1, 32, 16};
    std::vector<uint8_t> texels(size_t{4} * widths[i] * heights[i]);
    for (uint8_t& t : texels) t = static_cast<uint8_t>(random_());
    return scene_.scene.add_texture(widths[i], heights[i], i % 2 ? SIDERAY_RGBA8 : SIDERAY_RGBA8_SRGB, texels.data());
  }

  sideray_texture_slot any_slot() {
    sideray_texture_slot slot = no_texture();
    slot.texture = textures_[random_() % textures_.size()];
    slot.uv_set = random_() % 2;
    slot.wrap_u = static_cast<sideray_wrap>(random_() % 3);
    slot.wrap_v = static_cast<sideray_wrap>(random_() % 3);
    slot.filter = static_cast<sideray_filter>(random_() % 3);
    for (float& m : slot.texture_from_uv) m = 3.0f * any();
    return slot;
  }

  sideray_material_desc any_material(bool volume) {
    sideray_material_desc m = blended({positive(), positive(), positive()}, positive());
    m.alpha_mode = static_cast<sideray_alpha_mode>(random_() % 3);
    const auto maybe = [&] { return often() ? 0.0f : positive(); };
    m.metallic = maybe(), m.roughness = maybe(), m.transmission = maybe(), m.specular = positive();
    m.ior = 1.0f + positive(), m.thickness = maybe();
    m.clearcoat = maybe(), m.clearcoat_roughness = maybe(), m.sheen_roughness = positive();
    m.diffuse_transmission = maybe();
    m.iridescence = maybe(), m.iridescence_ior = 1.0f + positive();
    m.iridescence_thickness_min = 900.0f * maybe(), m.iridescence_thickness_max = 900.0f * maybe();
    m.anisotropy = maybe(), m.anisotropy_rotation = any();
    m.unlit = random_() % 16 == 0;
    m.normal_scale = any(), m.clearcoat_normal_scale = any(), m.occlusion_strength = positive();
    if (often()) m.attenuation_distance = positive() + 0.1f;
    if (volume) m.transmission = 1.0f, m.thickness = 0.5f;
    for (int c = 0; c < 3; ++c) {
      m.attenuation_color[c] = positive() + 1e-3f;
      m.emissive[c] = maybe(), m.specular_color[c] = positive(), m.sheen_color[c] = maybe();
      m.diffuse_transmission_color[c] = positive();
    }
    if (random_() % 4 == 0) return m;
    const sideray_texture_slot shared = any_slot();
    for (const model::MaterialSlot& slot : model::material_slots)
      if (often()) m.*slot.slot = often() ? shared : any_slot();
    return m;
  }

  sideray_fixed_material any_fixed() {
    sideray_fixed_material m{};
    for (float(*color)[3] : {&m.ambient, &m.diffuse, &m.specular, &m.emission, &m.reflectance})
      for (float& c : *color) c = positive();
    m.shininess = 128.0f * positive();
    m.follows_color = static_cast<uint32_t>(random_() % 16);
    m.environment = static_cast<sideray_texture_environment>(random_() % 4);
    m.fresnel = often();
    return m;
  }

  void add_instance(int i) {
    constexpr uint32_t triangles = 4;
    const glm::vec3 corners[] = {{any(), any(), 1}, {-1, -1, any()}, {1, -1, any()}, {any(), 1, -1}};
    constexpr uint32_t faces[] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> uv0, uv1;
    std::vector<glm::vec4> colors, tangents;
    for (uint32_t v = 0; v < 3 * triangles; ++v) {
      positions.push_back(i % 5 == 0 ? corners[faces[v]] : glm::vec3(any(), any(), any()));
      // Some have no direction: the triangle's own takes their place.
      normals.push_back(i % 10 == 9 ? glm::vec3(0.0f) : glm::normalize(glm::vec3(any(), any(), any())));
      uv0.emplace_back(4.0f * any(), 4.0f * any());
      uv1.emplace_back(any(), any());
      colors.emplace_back(positive(), positive(), positive(), positive());
      tangents.emplace_back(glm::normalize(glm::vec3(any(), any(), any())), often() ? 1.0f : -1.0f);
    }
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = 3 * triangles;
    mesh.positions = {&positions[0].x, 0};
    if (i % 3 != 0) mesh.normals = {&normals[0].x, 0};
    mesh.uv0 = {&uv0[0].x, 0};
    mesh.uv1 = {&uv1[0].x, 0};
    if (i % 4 == 0) mesh.colors = {&colors[0].x, 0};
    if (i % 4 < 2) mesh.tangents = {&tangents[0].x, 0};
    sideray_instance_desc instance{};
    instance.mesh = scene_.scene.add_mesh(mesh, nullptr), instance.material = scene_.scene.add_material(any_material(i % 5 == 0));
    if (const sideray_fixed_material m = fixed_ ? any_fixed() : sideray_fixed_material{}; fixed_)
      scene_.scene.set_fixed_material(instance.material, &m);
    glm::dmat4 place = glm::translate(glm::dmat4(1.0), glm::dvec3(any(), any(), any()) * 10.0);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) place[c][r] += static_cast<double>(any());  // mirrored, now and then
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) instance.world_from_object[3 * c + r] = place[c][r];
    instance.surface_id = static_cast<uint32_t>(i + 1), instance.visibility = SIDERAY_VISIBLE_ALL;
    scene_.scene.add_instances(&instance, 1);
  }

  void add_hit() {
    Hit hit{};
    hit.instance = static_cast<uint32_t>(random_() % shading->snapshot->instances.size());
    hit.primitive = static_cast<uint32_t>(
        random_() % shading->snapshot->meshes[shading->snapshot->instances[hit.instance].mesh]->triangles.size());
    hit.u = positive();
    hit.v = positive() * (1.0f - hit.u);
    hit.front = often(), hit.distance = static_cast<double>(10.0f * positive());
    hits.push_back(hit);
    const glm::vec3 front = geometric_normal(*shading->snapshot, hit);
    // Some rays hit their triangle head-on, and some only touch it.
    glm::vec3 direction(any(), any(), any());
    if (random_() % 16 == 0) direction = front;
    if (random_() % 16 == 0) direction = glm::cross(front, direction);
    rays.push_back({glm::vec3(0.0f), 0.0f, glm::normalize(direction), 1e30f});
    cones.push_back({often() ? 0.0f : 0.1f * positive(), 0.1f * positive() * positive() * positive()});
  }

  const bool fixed_;
  std::mt19937 random_{5};
  TestScene scene_;
  std::vector<uint32_t> textures_;
};

template <typename T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// Broken normals make numbers that are none, whose sign compilers choose.
bool same_blend(const shading::SrBlend& a, const shading::SrBlend& b) {
  const auto same = [](float x, float y) { return same_bits(x, y) || (std::isnan(x) && std::isnan(y)); };
  return same(a.cover, b.cover) && same(a.through.x, b.through.x) && same(a.through.y, b.through.y) &&
         same(a.through.z, b.through.z);
}

void expect_same(const SurfacePoint& a, const SurfacePoint& b) {
  EXPECT_TRUE(same_bits(a.surface, b.surface));
  EXPECT_TRUE(same_bits(a.position, b.position));
  EXPECT_TRUE(same_bits(a.geometric_normal, b.geometric_normal));
  EXPECT_TRUE(same_bits(a.to_eye, b.to_eye));
  EXPECT_TRUE(same_bits(a.offset, b.offset));
  EXPECT_TRUE(same_bits(a.cone, b.cone));
  EXPECT_TRUE(same_bits(a.distortion, b.distortion));
  EXPECT_EQ(a.blend, b.blend);
  EXPECT_TRUE(same_blend(a.blended, b.blended));
  EXPECT_TRUE(a.hit.instance == b.hit.instance && a.hit.primitive == b.hit.primitive && a.hit.front == b.hit.front &&
              a.hit.distance == b.hit.distance);
  EXPECT_TRUE(a.key == b.key && a.answer == b.answer);
}

// `steps`: of the pixels, or null.
void expect_lanes_as_single_hits(const HitScenario& scenario, const PixelSteps* steps = nullptr) {
  const ShadingScene& scene = *scenario.shading;
  std::vector<HitPlace> places;
  for (size_t i = 0; i < scenario.hits.size(); ++i)
    places.push_back({&scenario.hits[i], &scenario.rays[i], scenario.cones[i]});
  const auto count = [&](auto has) { return std::ranges::count_if(scene.snapshot->instances, has); };
  EXPECT_GT(count([](const model::Instance& i) { return i.solid; }), 3);
  EXPECT_GT(count([](const model::Instance& i) { return i.mirrored; }), 3);
  EXPECT_EQ(count([](const model::Instance& i) { return i.sprites != 0; }), 1);
  for (const char* isa : kernel_sets()) {
    std::vector<SurfacePoint> points(places.size());
    make_surfaces(scene, shade_kernels(isa), places, points.data(), steps);
    std::set<uint32_t> seen;  // the diffuse colour tells materials, texels and vertex colours apart
    for (size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE(testing::Message() << isa << " hit " << i << " instance " << scenario.hits[i].instance);
      expect_same(points[i], surface_point(scene, scenario.hits[i], scenario.rays[i], scenario.cones[i], steps));
      seen.insert(std::bit_cast<uint32_t>(points[i].surface.diffuse.x));
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(seen.size(), 1000u);
  }
}

TEST(HitSurfaces, in_lanes_are_those_of_single_hits_bit_for_bit) {
  expect_lanes_as_single_hits(HitScenario());
}

TEST(HitSurfaces, read_textures_by_the_steps_of_pixels_in_lanes_too) {
  const PixelSteps steps{{1.1f, 0.1f, 0.2f}, {-0.1f, 0.9f, 0.3f}};
  expect_lanes_as_single_hits(HitScenario(), &steps);
}

TEST(HitSurfaces, of_the_fixed_function_are_so_too) {
  expect_lanes_as_single_hits(HitScenario(true));
}

// The batch makes the same of hits as of their points.
TEST(HitSurfaces, are_shaded_as_their_points_are) {
  const HitScenario scenario;
  const ShadingScene& scene = *scenario.shading;
  constexpr size_t count = 1001;  // not a multiple of the block
  std::vector<HitPlace> places;
  std::vector<SurfacePoint> points;
  for (size_t i = 0; i < count; ++i) {
    places.push_back({&scenario.hits[i], &scenario.rays[i], scenario.cones[i]});
    points.push_back(surface_point(scene, scenario.hits[i], scenario.rays[i], scenario.cones[i]));
  }
  SurfaceBatch of_hits, of_points;
  of_hits.begin(scene, kernel_sets().back());
  of_points.begin(scene, kernel_sets().back());
  of_hits.load(places);
  of_points.load(points);
  std::vector<glm::vec3> first(count), second(count);
  of_hits.finish(first.data());
  of_points.finish(second.data());
  EXPECT_EQ(std::memcmp(first.data(), second.data(), count * sizeof(glm::vec3)), 0);
  std::vector<shading::SrBlend> blends(count);
  of_hits.blend(places, blends.data());
  std::set<uint32_t> covers;
  for (size_t i = 0; i < count; ++i) {
    EXPECT_TRUE(same_blend(blends[i], blend_of(points[i]))) << i;
    covers.insert(std::bit_cast<uint32_t>(blends[i].cover));
  }
  EXPECT_GT(covers.size(), 10u);
}

}  // namespace
}  // namespace sideray::rt
