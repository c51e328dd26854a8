// Makes the "config" of the stats: every option as used, without those that do not affect the picture. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "cli/session/stats.h"

namespace sideray::cli {

nlohmann::ordered_json used_config(const RenderOptions& options, const RenderRun& run);

}  // namespace sideray::cli
