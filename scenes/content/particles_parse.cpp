#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "scenes/base/files.h"
#include "scenes/content/particles.h"

namespace sideray::scenes {
namespace {

using Json = nlohmann::json;

constexpr uint32_t most_particles = 50000;
constexpr size_t most_keys = 64;  // of a value over life
constexpr double farthest = 1e9;

struct Limits {
  double low, high;
};

// Reads the keys of one object. Keys that remain at the end are unknown.
class Reader {
 public:
  Reader(std::string file, std::string node, const Json& object)
      : file_(std::move(file)), node_(std::move(node)), object_(object) {}

  template <typename... Args>
  [[noreturn]] void refuse_key(const std::string& key, fmt::format_string<Args...> wanted, Args&&... args) const {
    refuse("cannot read {}: {} of particles of node {} is {}; give {}", file_, key, node_, object_.at(key).dump(),
           fmt::format(wanted, std::forward<Args>(args)...));
  }
  template <typename... Args>
  [[noreturn]] void refuse_all(fmt::format_string<Args...> format, Args&&... args) const {
    refuse("cannot read {}: particles of node {}: {}", file_, node_, fmt::format(format, std::forward<Args>(args)...));
  }

  bool has(const std::string& key) const { return object_.contains(key); }
  const Json* take(const std::string& key) {
    known_.insert(key);
    return has(key) ? &object_.at(key) : nullptr;
  }

  double number(const std::string& key, Limits limits, double fallback) {
    const Json* value = take(key);
    if (!value) return fallback;
    if (!is_number(*value, limits)) refuse_key(key, "a number from {} to {}", limits.low, limits.high);
    return value->get<double>();
  }
  uint32_t whole(const std::string& key, Limits limits, uint32_t fallback) {
    const double value = number(key, limits, fallback);
    if (value != std::floor(value)) refuse_key(key, "a whole number from {} to {}", limits.low, limits.high);
    return static_cast<uint32_t>(value);
  }
  bool flag(const std::string& key, bool fallback) {
    const Json* value = take(key);
    if (value && !value->is_boolean()) refuse_key(key, "true or false");
    return value ? value->get<bool>() : fallback;
  }
  // Reads a number, or the ends of a range.
  Range range(const std::string& key, Limits limits, Range fallback) {
    const Json* value = take(key);
    if (!value) return fallback;
    if (is_number(*value, limits)) return {value->get<double>(), value->get<double>()};
    if (!is_list(*value, 2, 2, limits) || (*value)[0].get<double>() > (*value)[1].get<double>())
      refuse_key(key, "a number from {} to {}, or two in a list, the smaller one first", limits.low, limits.high);
    return {(*value)[0].get<double>(), (*value)[1].get<double>()};
  }
  glm::dvec3 vector(const std::string& key, Limits limits) {
    const Json* value = take(key);
    if (!value) return glm::dvec3(0);
    if (!is_list(*value, 3, 3, limits)) refuse_key(key, "three numbers from {} to {}", limits.low, limits.high);
    return vector_of(*value);
  }
  // Reads a number, or several numbers over life.
  std::vector<double> curve(const std::string& key, Limits limits, double fallback) {
    const Json* value = take(key);
    if (!value) return {fallback};
    if (is_number(*value, limits)) return {value->get<double>()};
    if (!is_list(*value, 1, most_keys, limits))
      refuse_key(key, "a number from {} to {}, or a list of up to {}", limits.low, limits.high, most_keys);
    return value->get<std::vector<double>>();
  }
  std::vector<glm::dvec3> colors(const std::string& key, Limits limits) {
    const Json* value = take(key);
    if (!value) return {glm::dvec3(1)};
    if (is_list(*value, 3, 3, limits)) return {vector_of(*value)};
    const bool of_colors =
        value->is_array() && !value->empty() && value->size() <= most_keys &&
        std::all_of(value->begin(), value->end(), [&](const Json& color) { return is_list(color, 3, 3, limits); });
    if (!of_colors)
      refuse_key(key, "a colour (three numbers from {} to {}), or a list of them", limits.low, limits.high);
    std::vector<glm::dvec3> colors;
    for (const Json& color : *value) colors.push_back(vector_of(color));
    return colors;
  }
  size_t choice(const std::string& key, std::initializer_list<const char*> names) {
    const Json* value = take(key);
    if (!value) return 0;
    const auto found = std::find_if(names.begin(), names.end(), [&](const char* name) { return *value == name; });
    if (found == names.end()) refuse_key(key, "{}", fmt::join(names, ", "));
    return static_cast<size_t>(found - names.begin());
  }

  void warn_of_unknown(Warnings& warnings) const {
    for (const auto& [key, value] : object_.items())
      if (!known_.contains(key))
        warnings.push_back(printable(fmt::format("node {}: particles.{} is unknown and left out", node_, key)));
  }

 private:
  static bool is_number(const Json& value, Limits limits) {
    return value.is_number() && value.get<double>() >= limits.low && value.get<double>() <= limits.high;
  }
  static bool is_list(const Json& value, size_t least, size_t most, Limits limits) {
    return value.is_array() && value.size() >= least && value.size() <= most &&
           std::all_of(value.begin(), value.end(), [&](const Json& v) { return is_number(v, limits); });
  }
  static glm::dvec3 vector_of(const Json& value) {
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
  }

  std::string file_, node_;
  const Json& object_;
  std::set<std::string> known_;
};

constexpr Limits unit{0, 1}, positive{1e-6, farthest}, not_negative{0, farthest}, any{-farthest, farthest};

void read_births(Reader& r, Particles& p) {
  p.lifetime = r.range("lifetime", {1e-3, 1e6}, {1, 1});
  if (r.has("count") == r.has("rate"))
    r.refuse_all("has {} of count and rate; give one of them", r.has("count") ? "both" : "none");
  p.count = r.whole("count", {1, most_particles}, 1);
  const double rate = r.number("rate", positive, 0);
  if (r.has("rate")) {
    const double alive = std::ceil(rate * p.lifetime.high);
    if (alive > most_particles)
      r.refuse_all("{} particles a second for {} seconds are more than {} at once; give less of either", rate,
                   p.lifetime.high, most_particles);
    p.count = static_cast<uint32_t>(std::max(alive, 1.0));
  }
  p.start = static_cast<Particles::Start>(r.choice("start", {"point", "box", "sphere", "cone"}));
  p.box = r.vector("box", not_negative);
  p.radius = r.number("radius", not_negative, 0);
  p.cone_deg = r.number("cone_deg", {0, 89}, 0);
  p.seed = r.whole("seed", {0, 4294967295.0}, 1);
  p.loop = r.flag("loop", true);
  p.prewarm = r.flag("prewarm", p.loop);
  if (p.prewarm && !p.loop) r.refuse_key("prewarm", "it only with loop: what happens once has nothing before it");
}

void read_motion(Reader& r, Particles& p) {
  p.velocity = r.vector("velocity", any);
  p.spread = r.number("spread", not_negative, 0);
  p.acceleration = r.vector("acceleration", any);
  p.drag = r.number("drag", {0, 1e6}, 0);
  p.turbulence = r.number("turbulence", not_negative, 0);
  p.turbulence_hz = r.number("turbulence_hz", {0, 1e3}, 1);
  p.rotation_deg = r.range("rotation_deg", any, {0, 0});
  p.spin_deg = r.range("spin_deg", any, {0, 0});
}

void read_looks(Reader& r, Particles& p) {
  p.size = r.curve("size", not_negative, 0.1);
  p.size_variation = r.number("size_variation", unit, 0);
  p.aspect = r.number("aspect", {1e-3, 1e3}, 1);
  p.color = r.colors("color", {0, 1e6});
  p.alpha = r.curve("alpha", unit, 1);
  p.frames_per_second = r.number("frames_per_second", {0, 1e4}, 0);
  p.random_frame = r.flag("random_frame", false);
  p.texture = static_cast<int>(r.number("texture", {0, 2147483647.0}, -1));
  p.desc = sideray_particles_defaults();
  p.desc.columns = r.whole("columns", {1, 256}, 1);
  p.desc.rows = r.whole("rows", {1, 256}, 1);
  p.desc.blend_mode = static_cast<sideray_blend_mode>(r.choice("blend", {"alpha", "premultiplied", "additive"}));
  p.desc.soft_distance = static_cast<float>(r.number("soft_distance", not_negative, 0));
  p.desc.lit = r.flag("lit", false) ? 1 : 0;
}

}  // namespace

Particles parse_particles(const std::string& file, const std::string& node, const std::string& json,
                          Warnings& warnings) {
  const Json object = Json::parse(json);
  Reader reader(file, node, object);
  Particles particles;
  read_births(reader, particles);
  read_motion(reader, particles);
  read_looks(reader, particles);
  reader.warn_of_unknown(warnings);
  return particles;
}

}  // namespace sideray::scenes
