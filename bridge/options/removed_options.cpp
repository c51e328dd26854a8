#include "bridge/options/removed_options.h"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace sideray::bridge {
namespace {

struct Removed {
  std::string_view name;   // the option's name
  std::string_view value;  // the removed value; "" = the whole option
  const char* instead;
};

// In alphabetical order. docs/migrating.md has the reasons.
constexpr Removed removed[] = {
    {"ao", "", "write ambient ao for on, ambient off for off, or leave it out"},
    {"denoise-on", "", "leave it out: masks are filtered by the threads that trace them"},
    {"foliage", "", "write poses rest for static, poses 1 for shared, or poses all for unique"},
    {"layer-threshold", "", "leave it out: every ray of a layer is traced, unless ray-reuse shares it"},
    {"oit", "front", "write abuffer, which is exact, or peel below OpenGL 4.3"},
    {"oit", "weighted", "write sorted, or abuffer, which is exact"},
    {"radiance-format", "", "leave it out: layers are kept in half floats"},
    {"shared-copies", "", "write poses K, 1 to 256"},
    {"unique-cap", "", "leave it out: poses all gives every instance its own pose"},
};

// Options and values that are still accepted.
struct Mapped {
  std::string_view name;   // the option's name
  std::string_view value;  // the option's value; "" = any
  const char* now;
};

// docs/adr/0029-shading-reuse.md has the reasons.
constexpr Mapped mapped[] = {{"cache-rate", "temporal4", "full"}, {"cache-rate", "temporal8", "full"}, {"shading-reuse", "", ""}};

const char* find(std::string_view name, std::string_view value) {
  const auto at = std::find_if(std::begin(removed), std::end(removed),
                               [&](const Removed& r) { return r.name == name && r.value == value; });
  return at == std::end(removed) ? nullptr : at->instead;
}

}  // namespace

const char* removed_option(const std::string& name) {
  return find(name, "");
}

const char* removed_value(const std::string& name, const std::string& value) {
  return value.empty() ? nullptr : find(name, value);
}

const char* read_as(const std::string& name, const std::string& value) {
  const auto at = std::find_if(std::begin(mapped), std::end(mapped), [&](const Mapped& m) {
    return m.name == name && (m.value.empty() || m.value == value);
  });
  return at == std::end(mapped) ? nullptr : at->now;
}

}  // namespace sideray::bridge
