#include "scenes/gltf/file/json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"

namespace sideray::scenes::gltf {
namespace {

using Json = nlohmann::json;

// Returns the parser's message without its identifier and without colons and semicolons, which divide our lines into
// "what: why; what to do".
std::string json_reason(std::string text) {
  const size_t identifier = text.find("] ");
  if (text.starts_with('[') && identifier != std::string::npos) text.erase(0, identifier + 2);
  for (const char* mark : {": ", "; "}) {
    for (size_t at = text.find(mark); at != std::string::npos; at = text.find(mark)) text[at] = ',';
  }
  return one_line(std::move(text));
}

// Checks a text before values are made of it. A callback of the parser that makes values could check too, but that
// parser searches the list around an object at each object's end: hours for a list of a million nodes.
class JsonLimits : public nlohmann::json_sax<Json> {
 public:
  JsonLimits(const std::string& path, Budget& budget) : path_(path), budget_(budget) {}
  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool key(string_t&) override { return count(); }
  bool start_object(size_t) override { return count() && ++depth_ > 0; }
  bool start_array(size_t) override { return count() && ++depth_ > 0; }
  bool end_object() override { return depth_-- > 0; }
  bool end_array() override { return depth_-- > 0; }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  bool count() {
    if (depth_ > limits::json_depth)
      refuse("cannot read {}: its JSON is nested deeper than {}; export it again", path_, limits::json_depth);
    if (++values_ > limits::json_values)
      refuse("cannot read {}: its JSON has more than {} values; keep numbers in buffers", path_, limits::json_values);
    if (values_ % chunk != 1) return true;
    budget_.take(chunk * limits::json_value_bytes, "its JSON");
    budget_.check_time("its JSON");
    return true;
  }
  static constexpr uint64_t chunk = 4096;
  const std::string& path_;
  Budget& budget_;
  int depth_ = 0;
  uint64_t values_ = 0;
};

}  // namespace

std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  if (text.ends_with('.')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() > 300 ? text.substr(0, 300) + "..." : text;
}

nlohmann::json parse_json(std::span<const uint8_t> text, const std::string& path, Budget& budget) {
  const auto first = std::find_if(text.begin(), text.end(), [](uint8_t c) { return std::isspace(c) == 0; });
  const bool marked = first != text.end() && *first == 0xef;  // byte order mark
  if (first != text.end() && *first != '{' && !marked)
    refuse("cannot read {}: it is neither binary glTF nor JSON; get it again or export it again", path);
  JsonLimits sizes(path, budget);
  Json::sax_parse(text.begin(), text.end(), &sizes);
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::exception& error) {
    refuse("cannot read {}: {}; export it again", path, json_reason(error.what()));
  }
}

const Json& objects(const Json& root, const char* key, const std::string& path) {
  static const Json none = Json::array();
  const auto found = root.find(key);
  if (found == root.end()) return none;
  const bool well_formed = found->is_array() && std::all_of(found->begin(), found->end(),
                                                            [](const Json& entry) { return entry.is_object(); });
  if (!well_formed) refuse("cannot read {}: {} is not a list of objects; export it again", path, key);
  return *found;
}

uint64_t whole(const Json& object, const char* key, uint64_t fallback, const std::string& what) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  const double value = found->is_number() ? found->get<double>() : -1.0;
  if (!(value >= 0.0 && value <= 2147483647.0) || value != std::floor(value)) {
    refuse("cannot read {}: {} is not a whole number from 0 to 2^31-1; export it again", what, key);
  }
  return static_cast<uint64_t>(value);
}

}  // namespace sideray::scenes::gltf
