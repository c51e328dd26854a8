#include "bridge/options/presets.h"

#include <optional>
#include <string_view>

namespace sideray::bridge {
namespace {

struct PresetValue {
  Quality quality;
  std::string_view option;
  const char* value;
  std::optional<sideray_translucency> method = {};  // empty: any method
};

// `balanced` has every option's default. docs/cli.md has the times and errors of the presets.
constexpr PresetValue values[] = {
    {Quality::draft, "layers", "2", SIDERAY_TRANSLUCENCY_HYBRID},
    {Quality::draft, "refraction", "off"},
    {Quality::draft, "shadows", "map"},
    {Quality::draft, "poses", "rest"},
    {Quality::draft, "reflections", "off"},
    {Quality::draft, "ambient", "off"},
    {Quality::best, "ray-traced", "all"},
    {Quality::best, "layers", "8", SIDERAY_TRANSLUCENCY_HYBRID},
    {Quality::best, "layers", "unlimited", SIDERAY_TRANSLUCENCY_RAYTRACED},
    {Quality::best, "ray-reuse", "0"},
};

}  // namespace

const char* preset_value(Quality quality, const char* option, const RenderOptions& before) {
  for (const PresetValue& v : values)
    if (v.quality == quality && v.option == option && (!v.method || before.draws(*v.method))) return v.value;
  return nullptr;
}

}  // namespace sideray::bridge
