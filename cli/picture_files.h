// A rendered picture as an image file. Any thread.
#pragma once

#include <sideray/sideray.hpp>

#include "render_options.h"

namespace sideray::cli {

// .exr: R, G, B, A and the chosen additional channels; .png: display values. Throws Error.
void write_picture(const Picture& picture, const RenderOptions& options);

}  // namespace sideray::cli
