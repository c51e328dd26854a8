#include "cli/session/picture_files.h"

#include <algorithm>
#include <filesystem>

namespace sideray::cli {
namespace {

constexpr float largest_half = 65504.0f;

// Returns whether a channel needs single floats: distances, motion and ground truth.
bool is_single(const std::string& name) {
  constexpr std::string_view exact[] = {"motion.", "hitdist.", "first.", "glass.", "behind.", "refraction."};
  return name == "Z" || name.ends_with(".distance") ||
         std::any_of(std::begin(exact), std::end(exact), [&](std::string_view prefix) { return name.starts_with(prefix); });
}

// Returns the channel's name in files: masks get their light's name; the shared one is called "combined".
std::string named_channel(const std::string& channel, const std::vector<std::string>& light_names) {
  for (const std::string prefix : {"shadow.", "hitdist."}) {
    if (!channel.starts_with(prefix) || channel == prefix + "combined") continue;
    const size_t light = std::stoul(channel.substr(prefix.size()));
    if (light < light_names.size()) return prefix + light_names[light];
  }
  return channel;
}

scenes::Plane plane_of(const sideray_channel& channel, size_t pixels) {
  scenes::Plane plane;
  plane.name = channel.name;
  if (channel.type == SIDERAY_CHANNEL_UINT) {
    plane.type = scenes::Plane::Type::uint;
    const auto* values = static_cast<const uint32_t*>(channel.values);
    plane.uint_values.assign(values, values + pixels);
    return plane;
  }
  const auto* values = static_cast<const float*>(channel.values);
  plane.values.assign(values, values + pixels);
  plane.type = is_single(plane.name) ? scenes::Plane::Type::single : scenes::Plane::Type::half;
  // Limits finite radiance to finite halfs. NaN passes: hiding it would hide a defect.
  if (plane.type == scenes::Plane::Type::half)
    for (float& v : plane.values)
      if (v > largest_half || v < -largest_half) v = v > 0 ? largest_half : -largest_half;
  return plane;
}

}  // namespace

bool is_picture(const std::string& path, uint32_t width, uint32_t height) {
  try {
    if (!std::filesystem::is_regular_file(path)) return false;
    const scenes::Image image = scenes::read_image(path);
    return image.width == width && image.height == height;
  } catch (const std::exception&) {
    return false;
  }
}

scenes::Image image_of(const Picture& picture, const std::vector<std::string>& light_names,
                       const RenderOptions& options) {
  scenes::Image image{picture.width(), picture.height(), {}, true};
  const size_t pixels = size_t{image.width} * image.height;
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    const std::string name = named_channel(channel.name, light_names);
    if (!is_chosen(options.aovs, name)) continue;
    image.planes.push_back(plane_of(channel, pixels));
    image.planes.back().name = name;
  }
  return image;
}

void write_picture(const Picture& picture, const std::vector<std::string>& light_names, const RenderOptions& options) {
  const scenes::Image image = image_of(picture, light_names, options);
  if (options.exr) {
    scenes::write_exr(options.output, image);
    return;
  }
  const std::vector<float> shown = scenes::display_values(image, options.display.exposure_ev, options.display.tonemap);
  scenes::write_png(options.output, image.width, image.height, scenes::quantize(shown));
}

}  // namespace sideray::cli
