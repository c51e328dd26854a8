// Compares raster fragments with ray-traced layers where both follow the same equations: without shadows, and with only
// the environment to reflect.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "frame/frame.h"
#include "frame/lobe_grid.h"
#include "lab/metrics/metrics.h"
#include "scenes/builtin/builtin.h"
#include "scenes/images/images.h"

namespace sideray::tests::parity_layer_test {
namespace {

scenes::Image image_of(const Frame& f) {
  scenes::Image image{f.width, f.height, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::single, f.planes.at(name), {}});
  return image;
}

// Writes the compared pictures to the folder SIDERAY_WRITE_PICTURES.
void write_picture(const Frame& frame, const std::string& name) {
  const char* folder = std::getenv("SIDERAY_WRITE_PICTURES");
  if (!folder) return;
  const std::vector<float> display = scenes::display_values(image_of(frame), 0, scenes::Tonemap::pbr_neutral);
  scenes::write_png(std::string(folder) + "/" + name + ".png", frame.width, frame.height, scenes::quantize(display));
}

struct Likeness {
  double flip, flip_where_translucent;
  size_t translucent_pixels;
};

Likeness compare_both_ways(const scenes::Content& content, Setup setup, const std::string& name) {
  setup.shadows = SIDERAY_SHADOWS_OFF;
  // In whole pixels rays set the order, so fragments need exact order too, for a comparison of the equations alone.
  setup.oit = SIDERAY_OIT_ABUFFER;
  setup.seen_in_reflections = false;
  setup.aovs = SIDERAY_AOV_MASK;
  const Frame layers = render(content, setup);
  setup.translucency = SIDERAY_TRANSLUCENCY_RASTER;
  const Frame raster = render(content, setup);
  write_picture(raster, name + "-raster");
  write_picture(layers, name + "-layers");
  const lab::Comparison compared = lab::compare(image_of(layers), image_of(raster));
  const std::vector<uint32_t>& counts = layers.uint_planes.at("mask.count");
  double sum = 0;
  Likeness result{compared.metrics.flip.value(), 0, 0};
  for (size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0) sum += static_cast<double>(compared.flip_map[i]), ++result.translucent_pixels;
  result.flip_where_translucent = sum / static_cast<double>(std::max<size_t>(result.translucent_pixels, 1));
  std::cout << "  " << name << ": FLIP " << result.flip << ", over its " << result.translucent_pixels
            << " translucent pixels " << result.flip_where_translucent << "\n";
  EXPECT_GT(result.translucent_pixels, 100u);
  return result;
}

TEST(ParityLayer, OfEveryLobe) {
  EXPECT_LT(
      compare_both_ways(lobe_grid(true), {.width = 200, .height = 360, .layers = 1}, "lobes").flip_where_translucent,
      0.01);
}

bool is_translucent(const sideray_material_desc& d) {
  return d.alpha_mode == SIDERAY_BLEND || d.transmission > 0;
}

// Returns the objects that layers can hold, in the middle of the picture.
scenes::Content translucent_part(scenes::Content content) {
  std::erase_if(content.objects,
                [&](const scenes::Object& o) { return !is_translucent(content.materials[o.material].desc); });
  content.cameras.clear();
  return content;
}

TEST(ParityLayer, OfAPoliceCarsLights) {
  SIDERAY_ASSET_OR_SKIP(path, "KenneyCars_PoliceCar/police-car.plain.glb");
  EXPECT_LT(compare_both_ways(translucent_part(scenes::load(path)), {}, "police-car").flip_where_translucent, 0.01);
}

TEST(ParityLayer, OfAGlassTable) {
  SIDERAY_ASSET_OR_SKIP(path, "GlassTable/GlassTable.glb");
  EXPECT_LT(compare_both_ways(translucent_part(scenes::load(path)), {}, "glass-table").flip_where_translucent, 0.01);
}

TEST(ParityLayer, OfACupWithWater) {
  SIDERAY_ASSET_OR_SKIP(path, "CupAndWater/CupAndWater.glb");
  EXPECT_LT(compare_both_ways(translucent_part(scenes::load(path)), {}, "cup").flip_where_translucent, 0.01);
}

// Compares whole pictures only: leaf textures show the tenth of a mip level between ray cones and driver.
TEST(ParityLayer, OfATree) {
  SIDERAY_ASSET_OR_SKIP(path, "TreeLowPoly/TreeLowPoly.gltf");
  EXPECT_LT(compare_both_ways(translucent_part(scenes::load(path)), {.layers = 8}, "tree").flip, 0.01);
}

// The third way is through the G-buffer, which differs by its half floats alone.
TEST(ParityLayer, DeferredAndForwardShadingAgree) {
  tests::Setup setup{.width = 200, .height = 360, .translucency = SIDERAY_TRANSLUCENCY_RASTER};
  setup.shadows = SIDERAY_SHADOWS_OFF;
  const Frame opaque = render(lobe_grid(false), setup), translucent = render(lobe_grid(true), setup);
  write_picture(opaque, "lobes-opaque");
  const double flip = lab::compare(image_of(opaque), image_of(translucent)).metrics.flip.value();
  std::cout << "  FLIP " << flip << "\n";
  EXPECT_LT(flip, 0.01);
}

}  // namespace
}  // namespace sideray::tests::parity_layer_test
