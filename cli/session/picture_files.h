// A rendered picture as an image file. Any thread.
#pragma once

#include <sideray/sideray.hpp>

#include "cli/options/render_options.h"

namespace sideray::cli {

// R, G, B, A and the chosen additional channels, those of lights by their names.
scenes::Image image_of(const Picture& picture, const std::vector<std::string>& light_names,
                       const RenderOptions& options);

// .exr: R, G, B, A and the chosen additional channels, those of lights by their names; .png: display values. Throws
// Error.
void write_picture(const Picture& picture, const std::vector<std::string>& light_names, const RenderOptions& options);

// Whether the file holds a whole picture of that size. What was cut off, by a full disk for example, is none.
bool is_picture(const std::string& path, uint32_t width, uint32_t height);

}  // namespace sideray::cli
