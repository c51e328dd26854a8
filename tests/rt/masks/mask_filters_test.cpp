// Compares denoised masks of whole frames with closed forms: a floor under the edge of an infinite roof, light from the
// zenith.
#include "rt/masks/mask_filters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "rt/base/view_rays.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::mask_filters_test {
namespace {

using namespace test;

constexpr uint32_t width = 160, height = 96;
constexpr double roof_height = 8.0;
// An endless roof is seen under all angles.
constexpr float endless = 1e5f;

class UnderTheRoof : public testing::Test {
 protected:
  UnderTheRoof() { tracer_.set_scene(scene_); }

  static std::shared_ptr<const model::Snapshot> make_scene(float angular_diameter_deg, float filter_radius = 0.0f,
                                                           uint32_t frames = 0) {
    TestScene scene;
    scene.quad({0, 0, 0}, {endless, 0, 0}, {0, 0, endless}, plain_material());
    scene.quad({-endless, static_cast<float>(roof_height), 0}, {endless, 0, 0}, {0, 0, endless}, plain_material());
    sideray_light sun = directional_light({0, -1, 0}, 1.0f);
    sun.angular_diameter_deg = angular_diameter_deg;
    sun.shadow_filter_radius = filter_radius, sun.shadow_filter_frames = frames;
    scene.lights({sun});
    return scene.commit();
  }

  // The camera of a frame moves along the edge and toward it.
  void look(uint32_t frame) {
    const double t = 0.07 * frame;
    view_ = perspective({1.0 - 0.5 * t, 6.0, 5.0 + t}, {0.2, 0.0, 0.3 * t}, 0.7, double{width} / height);
    const ViewRays rays(view_, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 from(ray.origin), d(ray.direction);
        const glm::dvec3 p = from - d * (from.y / d.y);
        edge_[size_t{y} * width + x] = p.x;
        const glm::dvec4 clip = view_.clip_from_local * glm::dvec4(p, 1.0);
        depth_.set(x, y, static_cast<float>(clip.z / clip.w), 0);
      }
  }

  MaskRequest request(uint32_t seed, MaskFilters* filters = nullptr, SequenceStep step = SequenceStep::first) {
    MaskRequest r;
    r.view = view_;
    r.width = width, r.height = height;
    r.depth = depth_.image();
    r.shadow_lights = 1;
    r.seed = seed;
    r.filters = filters;
    r.sequence = step;
    return r;
  }

  std::vector<uint8_t> lit(const MaskRequest& r) {
    OcclusionMasks masks;
    tracer_.trace_masks(r, masks);
    return masks.lit;
  }

  // Of a sun in the zenith, what the roof leaves at each pixel.
  double visible(size_t pixel) const {
    const double u =
        std::clamp(edge_[pixel] / (roof_height * std::tan(glm::radians(0.5 * double{diameter}))), -1.0, 1.0);
    return 1.0 - (std::acos(u) - u * std::sqrt(1.0 - u * u)) / 3.14159265358979;
  }
  // Of a cosine-weighted sky, the form factor of what lies beyond the roof's edge.
  double open(size_t pixel) const { return 0.5 + 0.5 * edge_[pixel] / std::hypot(edge_[pixel], roof_height); }

  template <typename Truth>
  double error(const std::vector<double>& values, const Truth& truth) const {
    double sum = 0.0;
    for (size_t i = 0; i < values.size(); ++i) sum += (values[i] - truth(i)) * (values[i] - truth(i));
    return std::sqrt(sum / static_cast<double>(values.size()));
  }
  static std::vector<double> shares(const std::vector<uint8_t>& mask) {
    std::vector<double> values;
    for (const uint8_t v : mask) values.push_back(v / 255.0);
    return values;
  }
  double sun_error(const std::vector<uint8_t>& mask) const {
    return error(shares(mask), [&](size_t i) { return visible(i); });
  }

  static constexpr float diameter = 6.0f;
  std::shared_ptr<const model::Snapshot> scene_ = make_scene(diameter);
  Tracer tracer_{{2, ""}};
  TraceView view_;
  DepthBuffer depth_{width, height, 0.0f, 0};
  std::vector<double> edge_ = std::vector<double>(size_t{width} * height);  // world x
};

TEST_F(UnderTheRoof, eight_moving_frames_of_one_sample_are_as_good_as_sixteen_samples) {
  MaskFilters filters;
  std::vector<uint8_t> mask, first;
  for (uint32_t frame = 0; frame < 8; ++frame) {
    look(frame);
    mask = lit(request(frame + 1, &filters, frame == 0 ? SequenceStep::first : SequenceStep::next));
    if (frame == 0) first = mask;
  }
  std::vector<double> raw(mask.size());
  for (uint32_t seed = 100; seed < 116; ++seed) {
    const std::vector<uint8_t> one = lit(request(seed));
    for (size_t i = 0; i < raw.size(); ++i) raw[i] += one[i] / 255.0 / 16.0;
  }
  const double sixteen = error(raw, [&](size_t i) { return visible(i); });
  const double eight = sun_error(mask), noise = sun_error(lit(request(1)));
  look(0);
  const double one = sun_error(first);
  std::cout << "  error of one raw sample " << noise << ", filtered " << one << ", after eight frames " << eight
            << ", of sixteen raw samples " << sixteen << "\n";
  EXPECT_LE(eight, sixteen);
  EXPECT_LT(one, 0.5 * noise);
}

TEST_F(UnderTheRoof, the_open_sky_is_filtered_too) {
  look(0);
  MaskRequest r = request(1);
  r.shadow_lights = 0, r.ao_rays = 4;
  OcclusionMasks raw, filtered;
  tracer_.trace_masks(r, raw);
  MaskFilters filters;
  r.filters = &filters;
  tracer_.trace_masks(r, filtered);
  const auto truth = [&](size_t i) { return open(i); };
  const double noise = error(shares(raw.open), truth), rest = error(shares(filtered.open), truth);
  std::cout << "  error of four raw rays " << noise << ", filtered " << rest << "\n";
  EXPECT_LT(rest, 0.4 * noise);
}

TEST_F(UnderTheRoof, a_frame_drawn_again_stays_and_a_cut_forgets) {
  MaskFilters filters, fresh;
  look(0);
  lit(request(1, &filters));
  look(1);
  const std::vector<uint8_t> once = lit(request(2, &filters, SequenceStep::next));
  for (int i = 0; i < 2; ++i) EXPECT_EQ(lit(request(2, &filters, SequenceStep::again)), once);
  const std::vector<uint8_t> cut = lit(request(3, &filters));
  EXPECT_EQ(cut, lit(request(3, &fresh)));
  EXPECT_NE(lit(request(4, &filters, SequenceStep::next)), lit(request(4, &fresh)));
}

// After a frame without the light's mask, or of another size, there is no history.
TEST_F(UnderTheRoof, what_was_filtered_before_the_last_frame_is_no_past) {
  MaskFilters filters, fresh;
  look(0);
  lit(request(1, &filters));
  MaskRequest none = request(2, &filters, SequenceStep::next);
  none.shadow_lights = 0;
  none.width = width / 2;
  none.height = height / 2;
  DepthBuffer small(width / 2, height / 2, 0.5f, 0);
  none.depth = small.image();
  lit(none);
  none = request(3, &filters, SequenceStep::next);
  none.shadow_lights = 0;
  lit(none);
  look(1);
  lit(request(4, &fresh));
  EXPECT_EQ(lit(request(5, &filters, SequenceStep::next)), lit(request(5, &fresh)));
}

TEST_F(UnderTheRoof, given_motion_counts_for_what_the_view_alone_would_be) {
  look(0);
  MaskFilters by_view, by_motion, wrong;
  for (MaskFilters* f : {&by_view, &by_motion, &wrong}) lit(request(1, f));
  // By hand: where each pixel of the next frame lay in this one.
  const TraceView before = view_;
  look(8);
  const ViewRays rays(view_, width, height);
  std::vector<glm::vec2> motion, none(size_t{width} * height, glm::vec2(0.0f));
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Ray ray = rays.ray(x, y);
      const glm::dvec3 from(ray.origin), d(ray.direction);
      const glm::dvec4 clip = before.clip_from_local * glm::dvec4(from - d * (from.y / d.y), 1.0);
      const glm::dvec2 was = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(width, height) - 0.5;
      motion.emplace_back(glm::dvec2(x, y) - was);
    }
  MaskRequest r = request(2, &by_motion, SequenceStep::next);
  r.motion = motion;
  const std::vector<uint8_t> given = lit(r), derived = lit(request(2, &by_view, SequenceStep::next));
  r.filters = &wrong, r.motion = none;
  const std::vector<uint8_t> still = lit(r);
  size_t off = 0, otherwise = 0;
  for (size_t i = 0; i < given.size(); ++i) {
    off += std::abs(given[i] - derived[i]) > 2;
    otherwise += std::abs(given[i] - still[i]) > 2;
  }
  EXPECT_LE(off, given.size() / 1000);
  EXPECT_GT(otherwise, given.size() / 20);
}

TEST_F(UnderTheRoof, lights_have_their_own_settings) {
  look(0);
  const std::vector<uint8_t> raw = lit(request(1));
  MaskFilters filters;
  const std::vector<uint8_t> usual = lit(request(1, &filters));
  EXPECT_NE(raw, usual);
  tracer_.set_scene(make_scene(diameter, -1.0f));
  EXPECT_EQ(lit(request(1, &filters)), raw);
  tracer_.set_scene(make_scene(diameter, 4.0f));
  const double narrow = sun_error(lit(request(1, &filters)));
  EXPECT_LT(narrow, sun_error(raw));
  EXPECT_GT(narrow, sun_error(usual));
  // A mean of one frame is that frame.
  tracer_.set_scene(make_scene(diameter, 0.0f, 1));
  lit(request(2, &filters));
  EXPECT_EQ(lit(request(1, &filters, SequenceStep::next)), usual);
}

TEST_F(UnderTheRoof, hard_shadows_and_parallel_views_stay_as_they_were_traced) {
  look(0);
  MaskFilters filters;
  view_.clip_from_local = glm::orthoRH_ZO(-4.0, 4.0, -2.4, 2.4, 20.0, 0.1) *
                          glm::lookAt(glm::dvec3(0, 6, 5), glm::dvec3(0, 0, 0), glm::dvec3(0, 1, 0));
  view_.local_from_clip = glm::inverse(view_.clip_from_local);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) depth_.set(x, y, 0.6f, 0);
  EXPECT_EQ(lit(request(1, &filters)), lit(request(1)));
  look(0);
  tracer_.set_scene(make_scene(0.0f));
  EXPECT_EQ(lit(request(1, &filters)), lit(request(1)));
}

TEST_F(UnderTheRoof, the_same_bits_for_any_thread_count) {
  std::vector<uint8_t> expected;
  for (const uint32_t threads : {1u, 2u}) {
    Tracer tracer({threads, ""});
    tracer.set_scene(scene_);
    MaskFilters filters;
    OcclusionMasks masks;
    for (uint32_t frame = 0; frame < 3; ++frame) {
      look(frame);
      MaskRequest r = request(frame, &filters, frame == 0 ? SequenceStep::first : SequenceStep::next);
      r.ao_rays = 4;
      tracer.trace_masks(r, masks);
    }
    masks.lit.insert(masks.lit.end(), masks.open.begin(), masks.open.end());
    if (expected.empty()) expected = masks.lit;
    EXPECT_EQ(masks.lit, expected);
  }
}

}  // namespace
}  // namespace sideray::rt::mask_filters_test
