#include "cli/options/aovs.h"

#include <sideray/sideray.h>

#include <algorithm>
#include <string_view>

#include "cli/base/failure.h"
#include "cli/options/options.h"

namespace sideray::cli {
namespace {

struct Group {
  std::string_view name;
  uint32_t bit;
  std::vector<std::string_view> channels;  // suffixes after the dot; none: the name is the channel
};

const std::vector<std::string_view> surface_channels = {"surface", "primitive", "Z", "N", "N.X", "N.Y", "N.Z"};

std::vector<std::string_view> path_channels() {
  std::vector<std::string_view> channels = surface_channels;
  channels.insert(channels.end(), {"length", "turns", "state"});
  return channels;
}

const std::vector<Group>& groups() {
  static const std::vector<Group> list = {{"Z", SIDERAY_AOV_Z, {}},
                                          {"N", SIDERAY_AOV_NORMAL, {"X", "Y", "Z"}},
                                          {"albedo", SIDERAY_AOV_ALBEDO, {"R", "G", "B"}},
                                          {"material", SIDERAY_AOV_MATERIAL, {"metallic", "roughness"}},
                                          {"id", SIDERAY_AOV_ID, {"surface", "primitive"}},
                                          {"mask", SIDERAY_AOV_MASK, {"count", "inexact"}},
                                          {"shadow", SIDERAY_AOV_SHADOW, {}},
                                          {"hitdist", SIDERAY_AOV_HIT_DISTANCE, {}},
                                          {"motion", SIDERAY_AOV_MOTION, {"X", "Y"}},
                                          {"first", SIDERAY_AOV_FIRST, surface_channels},
                                          {"glass", SIDERAY_AOV_GLASS, surface_channels},
                                          {"behind", SIDERAY_AOV_BEHIND, path_channels()},
                                          {"refraction", SIDERAY_AOV_REFRACTION, {"X", "Y", "state"}},
                                          {"answer", SIDERAY_AOV_ANSWERS, {"lights", "sky", "reflections", "layers"}}};
  return list;
}

bool has(const std::vector<std::string_view>& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// Returns K of "layerK", or -1.
int layer_number(std::string_view base) {
  constexpr std::string_view prefix = "layer";
  if (base.size() != prefix.size() + 1 || !base.starts_with(prefix)) return -1;
  const char digit = base.back();
  return digit >= '0' && digit <= '9' ? digit - '0' : -1;
}

[[noreturn]] void unknown(const std::string& name) {
  wrong_usage(
      "--aov: unknown name \"{}\"; there are Z, N, albedo, material, id, mask, layers, layer0..7, shadow, hitdist, "
      "motion, first, glass, behind, refraction, answer, their channels, all",
      name);
}

uint32_t layer_bit(const std::string& name, int number, uint32_t layers) {
  if (layers == 0) wrong_usage("--aov {}: this frame has no layers; use --translucency hybrid --layers 1..8", name);
  if (number >= static_cast<int>(layers))
    wrong_usage("--aov {}: this frame has layers 0 to {}; ask for those or raise --layers", name, layers - 1);
  return SIDERAY_AOV_LAYERS;
}

uint32_t bit_of(const std::string& name, const FrameContents& frame) {
  const size_t dot = name.find('.');
  const std::string_view base = std::string_view(name).substr(0, dot);
  const std::string_view channel =
      dot == std::string::npos ? std::string_view() : std::string_view(name).substr(dot + 1);
  if (frame.reference && (base == "mask" || base == "motion" || base == "answer" || base.starts_with("layer")))
    wrong_usage("--aov {}: a reference has neither mask nor layers nor motion nor answers; leave it out", name);
  if (name == "layers") return layer_bit(name, 0, frame.layers);
  if (const int number = layer_number(base); number >= 0) {
    if (dot != std::string::npos && !has({"R", "G", "B", "distance", "surface"}, channel)) unknown(name);
    return layer_bit(name, number, frame.layers);
  }
  if (base == "shadow" || base == "hitdist") {
    if (!frame.shadow_masks)
      wrong_usage("--aov {}: this frame has no shadow masks; use --shadows exact or inexact", name);
    return base == "shadow" ? SIDERAY_AOV_SHADOW : SIDERAY_AOV_HIT_DISTANCE;
  }
  if (name == "mask.inexact") {
    if (!frame.inexact) wrong_usage("--aov {}: this frame has no such shadows; use --shadows inexact", name);
    return SIDERAY_AOV_INEXACT;
  }
  for (const Group& group : groups())
    if (group.name == base && (dot == std::string::npos || has(group.channels, channel))) return group.bit;
  unknown(name);
}

}  // namespace

Aovs parse_aovs(const std::string& list, const FrameContents& frame) {
  Aovs aovs;
  for (const std::string& name : split(list, ',')) {
    aovs.chosen.push_back(name);
    if (name == "mask" && frame.inexact) aovs.bits |= SIDERAY_AOV_INEXACT;
    if (name != "all") {
      aovs.bits |= bit_of(name, frame);
      continue;
    }
    for (const Group& group : groups()) aovs.bits |= group.bit;
    if (frame.inexact) aovs.bits |= SIDERAY_AOV_INEXACT;
    if (frame.reference) aovs.bits &= ~uint32_t{SIDERAY_AOV_MASK | SIDERAY_AOV_MOTION | SIDERAY_AOV_INEXACT | SIDERAY_AOV_ANSWERS};
    if (!frame.shadow_masks) aovs.bits &= ~uint32_t{SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE};
    if (frame.layers > 0 && !frame.reference) aovs.bits |= SIDERAY_AOV_LAYERS;
  }
  return aovs;
}

bool is_chosen(const Aovs& aovs, const std::string& channel) {
  if (channel == "R" || channel == "G" || channel == "B" || channel == "A") return true;
  const std::string base = channel.substr(0, channel.find('.'));
  return std::any_of(aovs.chosen.begin(), aovs.chosen.end(), [&](const std::string& name) {
    return name == "all" || name == channel || channel.starts_with(name + ".") ||
           (name == "layers" && layer_number(base) >= 0);
  });
}

}  // namespace sideray::cli
