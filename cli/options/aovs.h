// Selects additional outputs by the channel names of docs/cli.md. Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sideray::cli {

struct Aovs {
  uint32_t bits = 0;                // SIDERAY_AOV_*
  std::vector<std::string> chosen;  // channels ("id.surface") and groups ("N", "layer0", "layers", "all")
};

// Says what a frame can show.
struct FrameContents {
  uint32_t layers = 0;
  bool shadow_masks = false, inexact = false, reference = false;
};

// `list`: comma separated. Throws UsageError for names that are unknown or not in the frame.
Aovs parse_aovs(const std::string& list, const FrameContents& frame);

// Returns whether a channel of the picture was requested; R, G, B and A always are.
bool is_chosen(const Aovs& aovs, const std::string& channel);

}  // namespace sideray::cli
