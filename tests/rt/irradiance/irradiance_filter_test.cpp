// Tests that the filter of bounced light has the same bits for any split of the picture into rows.
#include "rt/irradiance/irradiance_filter.h"

#include <gtest/gtest.h>

#include <random>

#include "rt/base/view_rays.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::irradiance_filter_test {
namespace {

using namespace test;

constexpr uint32_t width = 70, height = 130, block = 7;  // the latter in cells

// A floor with a wall across it, seen from above, and cells with random light.
class FilteredRows : public testing::Test {
 protected:
  FilteredRows() {
    TestScene scene;
    scene.quad({0, 0, 0}, {4, 0, 0}, {0, 0, 4}, matt(0.5f));
    scene.quad({0.3, 0.5, 0}, {0, 0.5, 0}, {0, 0, 4}, matt(0.5f));
    scene.environment(glm::vec3(0.0f));
    scene_.set_scene(scene.commit());
    scene_.shading();
    const FrameCamera camera(request_.view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) depths_.push_back(static_cast<float>(depth_of(camera, {x, y})));
  }

  // Returns the depth of the floor along the camera's axis.
  static double depth_of(const FrameCamera& camera, glm::dvec2 pixel) {
    return -camera.origin_at(pixel).y / camera.ray_at(pixel).y;
  }

  // Cells have samples in a checkerboard of blocks, so that some pixels are lit from beside, and some not at all.
  static bool has_samples(uint32_t column, uint32_t row) { return (column / block + row / block) % 2 == 0; }

  // `most_near`: up to 1 / distance of occluders, so that walls are searched.
  IrradianceCells cells_with(uint32_t seed, float most_near) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> share(0.0f, 1.0f);
    const FrameCamera camera(request_.view, width, height);
    IrradianceCells cells;
    cells.fit(width, height);
    for (uint32_t row = 0; row < cells.rows; ++row)
      for (uint32_t column = 0; column < cells.columns; ++column) {
        const size_t cell = size_t{row} * cells.columns + column;
        const glm::dvec2 pixel(2 * column, 2 * row);
        const double depth = depth_of(camera, pixel);
        cells.places[cell] = {glm::vec3(camera.origin_at(pixel) + depth * camera.ray_at(pixel)), {0, 1, 0},
                              static_cast<float>(camera.breadth(depth)), 0.0f};
        cells.lights[cell] = {.light = {share(random), share(random), share(random)},
                              .open = share(random),
                              .nearness = 0.5f * share(random),
                              .most_near = most_near * share(random),
                              .samples = has_samples(column, row) ? 1.0f : 0.0f};
      }
    return cells;
  }

  void apply(IrradianceFilter& filter, const IrradianceCells& cells, PixelRows rows, IrradianceImage& image) {
    filter.apply({request_, cells, walls_, depths_}, rows, scene_, image);
  }

  TracedScene scene_{{2, ""}};
  IrradianceRequest request_ = [] {
    IrradianceRequest r;
    r.view = perspective({0, 6, 2}, {0, 0, 0}, 0.5, double{width} / height);
    r.width = width, r.height = height;
    r.denoise = true;
    return r;
  }();
  std::vector<float> depths_;
  CellWalls walls_;
};

TEST_F(FilteredRows, have_the_bits_of_the_whole_picture) {
  const IrradianceCells cells = cells_with(1, 4.0f), earlier = cells_with(2, 4.0f);
  IrradianceFilter whole, split;
  IrradianceImage expected, found, unused;
  apply(whole, cells, {0, height}, expected);
  apply(split, earlier, {0, height}, unused);  // leaves other values in the filter's memory
  for (const PixelRows rows : {PixelRows{64, 96}, PixelRows{0, 32}, PixelRows{96, height}, PixelRows{32, 64}})
    apply(split, cells, rows, found);
  EXPECT_EQ(found.light, expected.light);
  EXPECT_NE(unused.light, expected.light);
}

// A pixel takes light from cells up to two beside its own.
TEST_F(FilteredRows, are_lit_from_two_cells_beside) {
  IrradianceFilter filter;
  IrradianceImage image;
  apply(filter, cells_with(1, 0.0f), {0, height}, image);
  size_t lit[2] = {0, 0};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      bool expected = false;
      for (uint32_t v = std::max(y / 2, 2u) - 2; v <= std::min(y / 2 + 2, (height - 1) / 2); ++v)
        for (uint32_t u = std::max(x / 2, 2u) - 2; u <= std::min(x / 2 + 2, (width - 1) / 2); ++u)
          expected = expected || has_samples(u, v);
      const bool is_lit = image.light[4 * (size_t{y} * width + x) + 3] != 0;
      ASSERT_EQ(is_lit, expected) << x << ' ' << y;
      ++lit[is_lit];
    }
  EXPECT_GT(lit[0], 100u);
}

TEST_F(FilteredRows, keep_no_walls_of_an_earlier_picture) {
  const IrradianceCells with_walls = cells_with(1, 4.0f), open = cells_with(1, 0.0f);
  IrradianceFilter fresh, used;
  IrradianceImage expected, found, walled;
  apply(fresh, open, {0, height}, expected);
  apply(used, with_walls, {0, height}, walled);
  apply(used, open, {0, height}, found);
  EXPECT_EQ(found.light, expected.light);
  EXPECT_NE(walled.light, expected.light);
}

}  // namespace
}  // namespace sideray::rt::irradiance_filter_test
