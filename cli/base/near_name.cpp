#include "cli/base/near_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace sideray::cli {
namespace {

// Returns how many letters must be inserted, removed or replaced to make one word of the other.
size_t edits_between(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);  // edits from the first letters of `a` to each beginning of `b`
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t k = 0; k < b.size(); ++k) {
      const size_t replaced = diagonal + (a[i] != b[k]);
      diagonal = row[k + 1];
      row[k + 1] = std::min({replaced, row[k] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string near_name(const std::string& typed, std::span<const std::string> names) {
  size_t fewest = 1 + typed.size() / 4;
  std::string nearest;
  for (const std::string& name : names) {
    const size_t edits = edits_between(typed, name);
    if (edits > fewest || (edits == fewest && !nearest.empty())) continue;
    fewest = edits;
    nearest = name;
  }
  return nearest;
}

std::string did_you_mean(const std::string& name) {
  return name.empty() ? "" : "did you mean " + name + "? ";
}

}  // namespace sideray::cli
