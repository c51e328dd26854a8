// Additional outputs by the channel names of docs/cli.md. Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sideray::cli {

struct Aovs {
  uint32_t bits = 0;                // SIDERAY_AOV_*
  std::vector<std::string> chosen;  // channels ("id.surface") and groups ("N", "layer0", "layers", "all")
};

// `list`: comma separated. `layers`: how many the frame has; `masks`: of shadows. Throws UsageError for what is unknown
// or not built yet.
Aovs parse_aovs(const std::string& list, uint32_t layers, bool masks, bool reference);

// Whether a channel of the picture was asked for. R, G, B and A always are.
bool is_chosen(const Aovs& aovs, const std::string& channel);

}  // namespace sideray::cli
