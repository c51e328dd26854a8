#include "scenes/builtin/surroundings.h"

#include "scenes/base/files.h"
#include "scenes/builtin/builtin.h"
#include "scenes/images/images.h"

namespace sideray::scenes {
namespace {

Sky read_picture(const std::string& path) {
  const Image image = read_image(path);
  Sky result{image.width, image.height, std::vector<float>(size_t{image.width} * image.height * 3)};
  for (size_t k = 0; k < 3; ++k) {
    const Plane* plane = image.find(std::string(1, "RGB"[k]));
    if (!plane || plane->values.size() * 3 != result.rgb.size())
      refuse("{}: has no channels R, G, B; use a lat-long colour image", path);
    for (size_t i = 0; i < plane->values.size(); ++i) result.rgb[3 * i + k] = plane->values[i];
  }
  return result;
}

}  // namespace

void check_surroundings(const Surroundings& surroundings) {
  if (surroundings.name != "none" && surroundings.name != "sky") (void)read_picture(surroundings.name);
}

void set_surroundings(Scene& scene, const Surroundings& surroundings) {
  const auto& [name, scale, rotation_deg] = surroundings;
  if (name == "none") return scene.set_environment(0, 0, nullptr, scale, rotation_deg);
  const Sky image = name == "sky" ? sky() : read_picture(name);
  try {
    scene.set_environment(image.width, image.height, image.rgb.data(), scale, rotation_deg);
  } catch (const Error& error) {
    throw Error(error.status, fmt::format("cannot use {}: {}", name, error.what()));
  }
}

}  // namespace sideray::scenes
