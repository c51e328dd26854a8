#include "model/solid.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace sideray::model {
namespace {

constexpr double weld_share = 1e-5;  // share of the radius

// Gives each position the number of the first one near it. Cells are twice as large as the tolerance, so that positions
// within it are in at most eight cells.
class Welder {
 public:
  Welder(const std::vector<glm::vec3>& positions, double tolerance)
      : positions_(positions), tolerance_(tolerance), per_unit_(0.5 / tolerance) {}

  uint32_t weld(uint32_t vertex) {
    const glm::dvec3 p(positions_[vertex]);
    const glm::i64vec3 low = cell(p - tolerance_), high = cell(p + tolerance_);
    for (int64_t z = low.z; z <= high.z; ++z)
      for (int64_t y = low.y; y <= high.y; ++y)
        for (int64_t x = low.x; x <= high.x; ++x)
          for (auto [at, end] = first_.equal_range(key({x, y, z})); at != end; ++at)
            if (glm::length(glm::dvec3(positions_[at->second]) - p) <= tolerance_) return at->second;
    first_.emplace(key(cell(p)), vertex);
    return vertex;
  }

 private:
  glm::i64vec3 cell(glm::dvec3 p) const { return glm::i64vec3(glm::floor(p * per_unit_)); }
  static uint64_t key(glm::i64vec3 c) {
    const glm::u64vec3 u(c);
    return (u.x * 0x9e3779b97f4a7c15u) ^ (u.y * 0xc2b2ae3d27d4eb4fu) ^ (u.z * 0x165667b19e3779f9u);
  }

  const std::vector<glm::vec3>& positions_;
  double tolerance_, per_unit_;
  std::unordered_multimap<uint64_t, uint32_t> first_;
};

}  // namespace

bool is_closed(const Mesh& mesh) {
  const double radius = static_cast<double>(mesh.bounds.radius());
  if (mesh.triangles.empty() || !(radius > 0.0)) return false;
  Welder welder(mesh.positions, radius * weld_share);
  std::vector<uint32_t> welded(mesh.positions.size());
  for (uint32_t i = 0; i < welded.size(); ++i) welded[i] = welder.weld(i);
  // Edges, each with the direction in which a triangle runs along it, +1 or -1.
  std::vector<std::pair<uint64_t, int>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    const uint32_t corners[] = {welded[t.x], welded[t.y], welded[t.z]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
      edges.push_back({uint64_t{low} << 32 | high, corners[i] == low ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (size_t first = 0, next = 0; first < edges.size(); first = next) {
    int sum = 0;
    for (; next < edges.size() && edges[next].first == edges[first].first; ++next) sum += edges[next].second;
    if (sum != 0) return false;
  }
  return !edges.empty();
}

}  // namespace sideray::model
