// Writes JSON. Any thread.
#pragma once

#include <string>

namespace sideray::scenes {

// Replaces what is not UTF-8, as names of files may be, for which dump() alone throws. A negative indent: one line.
template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sideray::scenes
