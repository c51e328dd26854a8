#include "preload/base/hash.h"

#include <cstdio>

namespace sideray::run {

std::string hash_text(uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace sideray::run
