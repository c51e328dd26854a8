// The orders of translucent fragments against lists sorted in double precision: planes that are hit by arithmetic,
// their colours known.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"
#include "gl/targets/order_targets.h"
#include "model/failure.h"

namespace sideray::gl::tests::raster_order_test {
namespace {

constexpr uint32_t width = 96, height = 64;
constexpr glm::dvec4 wall(0.25, 0.5, 0.75, 1);
constexpr double wall_z = -3;

struct Pane {
  glm::dmat4 world_from_object;
  glm::dvec4 color;
  sideray_blend_mode blend;
  uint32_t surface_id;
};

// dst = added + dst * through, alpha the fourth channel.
struct Layer {
  double depth;
  glm::dvec4 added, through;
};

Layer layer_of(const Pane& pane, double depth) {
  const glm::dvec3 c(pane.color);
  const double a = pane.color.w;
  glm::dvec3 added = c * a, through(1 - a);
  if (pane.blend == SIDERAY_BLEND_PREMULTIPLIED) added = c;
  if (pane.blend == SIDERAY_BLEND_ADDITIVE) through = glm::dvec3(1);
  if (pane.blend == SIDERAY_BLEND_MULTIPLY) added = glm::dvec3(0), through = glm::dvec3(1 - a) + c * a;
  const double mean = (through.x + through.y + through.z) / 3;
  return {depth, {added, 1 - mean}, {through, mean}};
}

struct Truth {
  glm::dvec4 color{0};
  size_t layers = 0;
  // Nothing that rounding may decide: no edge within a pixel, no depths that nearly meet without being the same.
  bool certain = true;
};

Truth truth_at(const std::vector<Pane>& panes, const RasterView& view, glm::dvec4 behind, uint32_t x, uint32_t y) {
  const glm::dvec4 p = view.local_from_clip * glm::dvec4((2.0 * x + 1) / width - 1, (2.0 * y + 1) / height - 1, 0.5, 1);
  const glm::dvec3 eye(view.eye), ray = glm::dvec3(p / p.w) - eye;
  const double to_wall = (wall_z - eye.z) / ray.z;
  std::vector<Layer> layers;
  Truth truth;
  for (const Pane& pane : panes) {
    const glm::dmat4 m = glm::inverse(pane.world_from_object);
    const glm::dvec3 o(m * glm::dvec4(eye, 1)), d(m * glm::dvec4(ray, 0));
    const double t = -o.z / d.z, u = o.x + t * d.x, v = o.y + t * d.y;
    // A pixel is 0.05 units of a quad that faces the eye; vertices snap to 1/256 of it.
    const double margin = 0.002 / std::max(std::abs(d.z) / glm::length(d), 0.01);
    const double edge = std::max(std::abs(u), std::abs(v));
    truth.certain &= std::abs(edge - 1) > margin && std::abs(t / to_wall - 1) > 1e-4;
    if (edge < 1 && t > 0 && t < to_wall) layers.push_back(layer_of(pane, t));
  }
  // Stable: equally deep panes keep the order of their ids, which is that of `panes`.
  std::stable_sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.depth < b.depth; });
  for (size_t i = 1; i < layers.size(); ++i) {
    const double gap = layers[i].depth - layers[i - 1].depth;
    truth.certain &= gap == 0 || gap > 1e-4 * layers[i].depth;
  }
  truth.layers = layers.size();
  truth.color = behind;
  for (auto i = layers.rbegin(); i != layers.rend(); ++i) truth.color = i->added + truth.color * i->through;
  return truth;
}

class RasterOrder : public EveryContext {
 protected:
  void SetUp() override {
    EveryContext::SetUp();
    if (context) rasterizer = std::make_unique<Rasterizer>(gl());
  }
  void TearDown() override {
    rasterizer.reset();
    EveryContext::TearDown();
  }

  void set_panes(std::vector<Pane> added) {
    panes = std::move(added);
    SceneBuilder builder;
    builder.quad(builder.material(unlit(glm::vec4(wall))), {0, 0, wall_z}, 9, 1000);
    for (const Pane& pane : panes) {
      sideray_material_desc d = unlit(glm::vec4(pane.color), SIDERAY_BLEND);
      d.blend_mode = pane.blend;
      d.double_sided = 1;
      builder.quad(builder.material(d), pane.world_from_object, pane.surface_id);
    }
    snapshot = builder.commit();
  }

  std::vector<glm::vec4> draw(Translucency pass) {
    rasterizer->set_scene(snapshot);
    rasterizer->resize(width, height);
    view = rasterizer->make_view(camera_at({0.3, 0.2, 5}), {});
    rasterizer->set_view(view);
    rasterizer->gbuffer();
    rasterizer->light(false);
    opaque = rasterizer->read_color();
    rasterizer->translucency(pass);
    return rasterizer->read_color();
  }
  std::vector<glm::vec4> draw(sideray_oit oit) {
    Translucency pass;
    pass.oit = oit;
    return draw(pass);
  }

  Truth truth_of(uint32_t x, uint32_t y) const { return truth_at(panes, view, opaque[size_t{y} * width + x], x, y); }

  struct Error {
    double rmse = 0, most = 0;
    size_t pixels = 0, deepest = 0;
  };
  // Over the pixels that are certain and have panes.
  Error error_of(const std::vector<glm::vec4>& colors) const {
    Error error;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Truth truth = truth_of(x, y);
        if (!truth.certain || truth.layers == 0) continue;
        const glm::dvec4 off = glm::dvec4(colors[size_t{y} * width + x]) - truth.color;
        ++error.pixels;
        error.deepest = std::max(error.deepest, truth.layers);
        error.rmse += glm::dot(off, off) / 4;
        for (int c = 0; c < 4; ++c) error.most = std::max(error.most, std::abs(off[c]));
      }
    error.rmse = std::sqrt(error.rmse / static_cast<double>(error.pixels));
    return error;
  }

  std::vector<Pane> panes;
  std::shared_ptr<const model::Snapshot> snapshot;
  RasterView view;
  std::vector<glm::vec4> opaque;
  std::unique_ptr<Rasterizer> rasterizer;
};

// The colour buffer holds single floats: what is left is their rounding.
constexpr double exact = 1e-5;
constexpr sideray_oit every_exact_order[] = {SIDERAY_OIT_PEEL, SIDERAY_OIT_ABUFFER};

constexpr sideray_blend_mode every_blend[] = {SIDERAY_BLEND_ALPHA, SIDERAY_BLEND_PREMULTIPLIED, SIDERAY_BLEND_ADDITIVE,
                                              SIDERAY_BLEND_MULTIPLY};

// Panes about one middle, each turned its own way: every pair crosses.
std::vector<Pane> crossing_panes(uint32_t count) {
  std::vector<Pane> result;
  for (uint32_t i = 0; i < count; ++i) {
    glm::dmat4 m = glm::rotate(glm::dmat4(1), 0.9 * i, glm::normalize(glm::dvec3(0.4, 1, 0.1 * i)));
    m = glm::rotate(m, 0.7 * i, glm::dvec3(1, 0, 0));
    result.push_back({glm::scale(m, glm::dvec3(1.7)),
                      {0.5 + 0.4 * std::sin(2.0 * i), 0.5 + 0.4 * std::sin(3.0 * i + 1), 0.4, 0.3 + 0.05 * (i % 5)},
                      every_blend[i % 4],
                      i + 1});
  }
  return result;
}

TEST_P(RasterOrder, exact_orders_are_the_sorted_lists_where_panes_cross) {
  set_panes(crossing_panes(9));
  const Error sorted = error_of(draw(SIDERAY_OIT_SORTED));
  EXPECT_GT(sorted.pixels, 1000u);
  EXPECT_GE(sorted.deepest, 7u);
  EXPECT_GT(sorted.rmse, 0.03) << "a scene that sorted objects draw rightly proves nothing";
  for (const sideray_oit oit : every_exact_order) {
    if (oit == SIDERAY_OIT_ABUFFER && !gl().storage_buffers) continue;
    EXPECT_LT(error_of(draw(oit)).most, exact) << "oit " << oit;
  }
}

// Each over the next around a ring: no order of whole objects is right.
TEST_P(RasterOrder, exact_orders_draw_rings_that_no_sorting_can) {
  std::vector<Pane> ring;
  for (uint32_t i = 0; i < 4; ++i) {
    const double turn = 1.5707963267948966 * i;
    glm::dmat4 m = glm::rotate(glm::dmat4(1), turn, glm::dvec3(0, 0, 1));
    m = glm::rotate(glm::translate(m, glm::dvec3(0, 1, 0)), 0.3, glm::dvec3(0, 1, 0));
    ring.push_back({glm::scale(m, glm::dvec3(1.7, 0.5, 1)),
                    {i & 1 ? 0.9 : 0.1, i & 2 ? 0.8 : 0.1, 0.3, 0.6},
                    SIDERAY_BLEND_ALPHA,
                    i + 1});
  }
  set_panes(ring);
  const Error sorted = error_of(draw(SIDERAY_OIT_SORTED));
  EXPECT_EQ(sorted.deepest, 2u);
  EXPECT_GT(sorted.most, 0.1);
  for (const sideray_oit oit : every_exact_order) {
    if (oit == SIDERAY_OIT_ABUFFER && !gl().storage_buffers) continue;
    EXPECT_LT(error_of(draw(oit)).most, exact) << "oit " << oit;
  }
}

TEST_P(RasterOrder, a_lone_surface_is_exact_in_every_order_and_blend_mode) {
  for (const sideray_blend_mode blend : every_blend)
    for (const double alpha : {0.0, 0.02, 0.5, 1.0}) {
      set_panes({{glm::scale(glm::dmat4(1), glm::dvec3(1.5)), {0.7, 0.2, 0.4, alpha}, blend, 1}});
      for (const sideray_oit oit : {SIDERAY_OIT_SORTED, SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL}) {
        if (oit == SIDERAY_OIT_ABUFFER && !gl().storage_buffers) continue;
        // Alpha below 1/255 is no fragment, whatever it would add.
        std::vector<Pane> seen;
        if (alpha > 0) seen = panes;
        const std::vector<glm::vec4> colors = draw(oit);
        panes.swap(seen);
        const glm::vec4 middle = colors[size_t{height / 2} * width + width / 2];
        const Truth truth = truth_of(width / 2, height / 2);
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(middle[c], truth.color[c], exact) << "oit " << oit << " blend " << blend << " alpha " << alpha;
        panes.swap(seen);
      }
    }
}

TEST_P(RasterOrder, coplanar_fragments_are_all_there_the_smaller_id_in_front) {
  std::vector<Pane> same;
  for (uint32_t i = 0; i < 5; ++i)
    same.push_back({glm::scale(glm::rotate(glm::dmat4(1), 0.4, glm::dvec3(0, 1, 0)), glm::dvec3(1.5)),
                    {i == 0, i == 1, i > 1, 0.3 + 0.1 * i},
                    i == 3 ? SIDERAY_BLEND_MULTIPLY : SIDERAY_BLEND_ALPHA,
                    i + 1});
  set_panes(same);
  for (const sideray_oit oit : {SIDERAY_OIT_SORTED, SIDERAY_OIT_PEEL, SIDERAY_OIT_ABUFFER}) {
    if (oit == SIDERAY_OIT_ABUFFER && !gl().storage_buffers) continue;
    const Error error = error_of(draw(oit));
    EXPECT_EQ(error.deepest, 5u);
    EXPECT_LT(error.most, exact) << "oit " << oit;
  }
}

TEST_P(RasterOrder, bright_surfaces_and_many_of_them_overflow_nothing) {
  std::vector<Pane> bright;
  for (uint32_t i = 0; i < 40; ++i)
    bright.push_back({glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(1.5)), glm::dvec3(0, 0, -0.05 * i)),
                      {6e4, 5e4, 4e4, 0.5},
                      SIDERAY_BLEND_ALPHA,
                      i + 1});
  set_panes(bright);
  for (const sideray_oit oit : {SIDERAY_OIT_SORTED, SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL}) {
    if (oit == SIDERAY_OIT_ABUFFER && !gl().storage_buffers) continue;
    const glm::vec4 middle = draw(oit)[size_t{height / 2} * width + width / 2];
    EXPECT_NEAR(middle.x / 6e4f, 1, 1e-4) << oit;
    EXPECT_NEAR(middle.z / 4e4f, 1, 1e-4) << oit;
  }
}

TEST_P(RasterOrder, lists_that_do_not_fit_are_drawn_in_bands) {
  if (!gl().storage_buffers) GTEST_SKIP() << "no lists before OpenGL 4.3";
  set_panes(crossing_panes(9));
  const std::vector<glm::vec4> at_once = draw(SIDERAY_OIT_ABUFFER);
  rasterizer = std::make_unique<Rasterizer>(gl());
  Translucency pass;
  pass.oit = SIDERAY_OIT_ABUFFER;
  // Room for three rows in which every pixel has all layers.
  pass.most_list_bytes = 3 * 9 * width * FragmentLists::node_bytes;
  const std::vector<glm::vec4> in_bands = draw(pass);
  EXPECT_LT(error_of(in_bands).most, exact);
  EXPECT_EQ(std::memcmp(at_once.data(), in_bands.data(), at_once.size() * sizeof(glm::vec4)), 0);
  pass.most_list_bytes = 10 * FragmentLists::node_bytes;
  try {
    draw(pass);
    FAIL() << "a row needs more nodes than there may be";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_OUT_OF_MEMORY);
    EXPECT_NE(std::string(failure.what()).find("take peel"), std::string::npos) << failure.what();
  }
}

TEST_P(RasterOrder, lists_are_refused_where_the_driver_has_no_storage_buffers) {
  set_panes(crossing_panes(2));
  Functions old = gl();
  old.version = 41;
  old.storage_buffers = false;
  rasterizer = std::make_unique<Rasterizer>(old);
  try {
    draw(SIDERAY_OIT_ABUFFER);
    FAIL() << "drawn without what it needs";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    EXPECT_NE(std::string(failure.what()).find("OpenGL 4.1"), std::string::npos) << failure.what();
    EXPECT_NE(std::string(failure.what()).find("take peel"), std::string::npos) << failure.what();
  }
  EXPECT_LT(error_of(draw(SIDERAY_OIT_PEEL)).most, exact);
  rasterizer.reset();
}

TEST_P(RasterOrder, peeling_is_refused_where_the_driver_has_too_few_texture_units) {
  set_panes(crossing_panes(2));
  Functions few = gl();
  few.texture_units = 16;
  rasterizer = std::make_unique<Rasterizer>(few);
  try {
    draw(SIDERAY_OIT_PEEL);
    FAIL() << "drawn without what it needs";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    EXPECT_NE(std::string(failure.what()).find("16 texture units, 28 are needed"), std::string::npos);
  }
  rasterizer.reset();
}

INSTANTIATE_TEST_SUITE_P(Gl, RasterOrder, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& param_info) { return param_info.param; });

}  // namespace
}  // namespace sideray::gl::tests::raster_order_test
