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

// What a frame can show.
struct FrameContents {
  uint32_t layers = 0;
  bool shadow_masks = false, inexact = false, reference = false;
};

// `list`: comma separated. Throws UsageError for what is unknown, or not in the frame.
Aovs parse_aovs(const std::string& list, const FrameContents& frame);

// Whether a channel of the picture was asked for. R, G, B and A always are.
bool is_chosen(const Aovs& aovs, const std::string& channel);

}  // namespace sideray::cli
