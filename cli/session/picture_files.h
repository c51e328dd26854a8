// Writes rendered pictures as image files. Any thread.
#pragma once

#include <sideray/sideray.hpp>

#include "cli/options/render_options.h"

namespace sideray::cli {

// Returns R, G, B, A and the chosen additional channels, with the names of lights.
scenes::Image image_of(const Picture& picture, const std::vector<std::string>& light_names,
                       const RenderOptions& options);

// Writes .exr: R, G, B, A and the chosen additional channels, with the names of lights; or .png: display values. Throws
// Error.
void write_picture(const Picture& picture, const std::vector<std::string>& light_names, const RenderOptions& options);

// Returns whether the file holds a complete picture of that size, not one that a full disk cut off, for example.
bool is_picture(const std::string& path, uint32_t width, uint32_t height);

}  // namespace sideray::cli
