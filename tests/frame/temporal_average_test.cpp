// Tests temporal anti-aliasing and motion through the public interface: a straight edge against its exact coverage,
// ghosts, and options that must not change a picture.
#include <algorithm>
#include <array>
#include <cmath>

#include "frame/frame.h"

namespace sideray::tests::temporal_average_test {
namespace {

constexpr uint32_t width = 48, height = 32;
constexpr float dark = 0.1f, bright = 1.0f;

// One world unit is one pixel, the origin is the middle of the picture.
sideray_camera pixel_camera(double x = 0, double y = 0) {
  sideray_camera camera{};
  camera.size = sizeof(camera);
  camera.world_from_camera[0] = camera.world_from_camera[4] = camera.world_from_camera[8] = 1;
  camera.world_from_camera[9] = x, camera.world_from_camera[10] = y, camera.world_from_camera[11] = 50;
  camera.orthographic = 1;
  camera.half_height = 0.5f * height;
  camera.z_near = 1, camera.z_far = 100;
  return camera;
}

// A dark wall and a bright card a little before it, both unlit.
class Cards {
 public:
  Cards() : scene_(Scene::create().value()), renderer_(Renderer::create().value()) {
    const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 4, mesh.index_count = 6;
    mesh.positions.data = positions;
    mesh.indices = indices;
    const sideray_mesh quad = scene_.add_mesh(mesh);
    const float values[] = {dark, bright};
    for (uint32_t i = 0; i < 2; ++i) {
      sideray_material_desc material = sideray_material_defaults();
      material.unlit = 1;
      for (int c = 0; c < 3; ++c) material.base_color[c] = values[i];
      sideray_instance_desc instance{};
      for (int axis = 0; axis < 3; ++axis) instance.world_from_object[4 * axis] = 1;
      instance.visibility = SIDERAY_VISIBLE_ALL;
      instance.mesh = quad;
      instance.material = scene_.add_material(material);
      instance.surface_id = i + 1;
      scene_.add_instances({&instance, 1});
    }
    place(1, 0, 0, 0, 0, 500);
    options.picture.width = width;
    options.picture.height = height;
    options.translucency->method = SIDERAY_TRANSLUCENCY_RASTER;
    options.picture.taa = 1;
  }

  void place(sideray_instance instance, double x, double y, double z, double angle, double size) {
    const double c = size * std::cos(angle), s = size * std::sin(angle);
    const double columns[12] = {c, s, 0, -s, c, 0, 0, 0, 1, x, y, z};
    scene_.move_instance(instance, columns);
    scene_.commit();
  }

  // Draws the next picture of a sequence; returns channels, top row first.
  std::map<std::string, std::vector<float>> draw(const sideray_camera& camera = pixel_camera()) {
    const Picture picture = renderer_.render(scene_, camera, options).value();
    options.picture.continues = 1;
    std::map<std::string, std::vector<float>> planes;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const auto* values = static_cast<const float*>(picture.channel(i).values);
      planes[picture.channel(i).name].assign(values, values + size_t{width} * height);
    }
    return planes;
  }

 private:
  Scene scene_;
  Renderer renderer_;

 public:
  RenderOptions options;
};

// The card's edge: what is at dot(normal, p) <= offset is bright.
constexpr double angle = 0.4, offset = 1.3;
void place_edge(Cards& cards) {
  const double size = 300;
  cards.place(2, (offset - size) * std::cos(angle), (offset - size) * std::sin(angle), 1, angle, size);
}

// Returns the covered share of pixel (x, row), by clipping its square at the edge.
double coverage(uint32_t x, uint32_t row) {
  const double left = x - 0.5 * width, low = 0.5 * height - 1.0 - row;
  const double corners[4][2] = {{left, low}, {left + 1, low}, {left + 1, low + 1}, {left, low + 1}};
  std::vector<std::array<double, 2>> inside;
  const auto depth = [](const double* p) { return offset - std::cos(angle) * p[0] - std::sin(angle) * p[1]; };
  for (int i = 0; i < 4; ++i) {
    const double *a = corners[i], *b = corners[(i + 1) % 4];
    const double da = depth(a), db = depth(b);
    if (da >= 0) inside.push_back({a[0], a[1]});
    if ((da < 0) == (db < 0)) continue;
    const double t = da / (da - db);
    inside.push_back({a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])});
  }
  double area = 0;
  for (size_t i = 0; i < inside.size(); ++i) {
    const auto &p = inside[i], &q = inside[(i + 1) % inside.size()];
    area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
  }
  return area;
}

double error_of(const std::vector<float>& picture) {
  double sum = 0;
  for (uint32_t row = 0; row < height; ++row)
    for (uint32_t x = 0; x < width; ++x) {
      const double expected = double{dark} + coverage(x, row) * (double{bright} - double{dark});
      const double difference = double{picture[row * width + x]} - expected;
      sum += difference * difference;
    }
  return std::sqrt(sum / (width * height));
}

double mean_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum / static_cast<double>(a.size());
}

TEST(TemporalAverage, AStillEdgeConvergesToItsCoverage) {
  Cards cards;
  place_edge(cards);
  const double alone = error_of(cards.draw().at("R"));
  std::vector<float> picture;
  for (int frame = 1; frame < 16; ++frame) picture = cards.draw().at("R");
  EXPECT_LT(error_of(picture), 0.35 * alone);
  double changes = 0;
  for (int frame = 0; frame < 8; ++frame) {
    const std::vector<float> next = cards.draw().at("R");
    changes += mean_difference(picture, next) / 8;
    picture = next;
  }
  cards.options.picture.taa = cards.options.picture.continues = 0;
  std::vector<float> exact(size_t{width} * height);
  for (uint32_t i = 0; i < exact.size(); ++i)
    exact[i] = static_cast<float>(double{dark} + coverage(i % width, i / width) * (double{bright} - double{dark}));
  // A pixel of coverage p changes by a tenth of 2 p (1 - p) in the mean, a thirtieth over all p; alone it is a fourth
  // off.
  EXPECT_LT(changes, 0.2 * mean_difference(cards.draw().at("R"), exact)) << "a still camera's pictures are steady";
}

// The edge moves 1.5 pixels a frame: repeated filtering of the history costs less sharpness than edges gain.
TEST(TemporalAverage, AMovingEdgeIsBetterThanWithoutItsPast) {
  Cards cards;
  place_edge(cards);
  std::vector<float> picture;
  for (int before_last = 23; before_last >= 0; --before_last)
    picture = cards.draw(pixel_camera(before_last * 1.37, before_last * 0.61)).at("R");
  const double average = error_of(picture);
  cards.options.picture.taa = cards.options.picture.continues = 0;
  EXPECT_LT(average, 0.8 * error_of(cards.draw().at("R")));
}

// The card is so near the wall that depth does not show its disappearance.
TEST(TemporalAverage, NothingIsLeftOfABrightCardThatWent) {
  Cards cards;
  std::vector<float> before, after;
  cards.place(2, 0, 0, 0.1, 0.3, 6);
  for (int frame = 0; frame < 10; ++frame) before = cards.draw().at("R");
  cards.place(2, 1000, 0, 0.1, 0.3, 6);
  for (int frame = 0; frame < 4; ++frame) after = cards.draw().at("R");
  double was = 0, is_left = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    was += double{before[i]} - double{dark};
    is_left += std::abs(double{after[i]} - double{dark});
  }
  EXPECT_GT(was, 100.0);
  EXPECT_LT(is_left, 0.01 * was) << "a half-life of four frames would leave a half";
}

TEST(TemporalAverage, TheFirstPictureAndThatBehindACutAreThoseDrawnAlone) {
  Cards cards;
  place_edge(cards);
  const auto first = cards.draw().at("R");
  for (int frame = 0; frame < 3; ++frame) cards.draw();
  cards.options.picture.continues = 0;
  const auto behind_cut = cards.draw().at("R");
  cards.options.picture.taa = cards.options.picture.continues = 0;
  const auto alone = cards.draw().at("R");
  EXPECT_EQ(first, alone);
  EXPECT_EQ(behind_cut, alone);
}

TEST(TemporalAverage, TimingAFrameChangesNoPicture) {
  Cards plain, timed;
  place_edge(plain), place_edge(timed);
  timed.options.picture.repeats = 3;
  for (int frame = 0; frame < 4; ++frame) EXPECT_EQ(plain.draw().at("R"), timed.draw().at("R")) << frame;
}

// Rows of pictures go down, and what a camera passes goes the other way.
TEST(Motion, OfACameraThatMoves) {
  Cards cards;
  place_edge(cards);
  cards.options.picture.taa = 0;
  cards.options.picture.aovs = SIDERAY_AOV_MOTION;
  const auto first = cards.draw(pixel_camera(0, 0));
  for (const char* channel : {"motion.X", "motion.Y"})
    for (const float value : first.at(channel)) ASSERT_EQ(value, 0.0f);
  const auto second = cards.draw(pixel_camera(2.5, 1.25));
  for (const float value : second.at("motion.X")) ASSERT_NEAR(value, -2.5f, 1e-4f);
  for (const float value : second.at("motion.Y")) ASSERT_NEAR(value, 1.25f, 1e-4f);
}

}  // namespace
}  // namespace sideray::tests::temporal_average_test
