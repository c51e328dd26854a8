// Holds the values that the rows of the table store. Any thread.
#pragma once

#include <optional>

#include "bridge/base/render_options.h"
#include "bridge/options/presets.h"

namespace sideray::bridge {

struct OptionValues : RenderOptions {
  Quality quality = Quality::balanced;  // gives the values of options that are not set
  std::optional<uint32_t> surfaces;  // most layers or surfaces of a ray, 0 = unlimited; empty: the method's own default
};

}  // namespace sideray::bridge
