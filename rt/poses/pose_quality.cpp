#include "rt/poses/pose_quality.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace sideray::rt {
namespace {

double half_area(const model::Bounds& b) {
  const glm::dvec3 size = glm::dvec3(b.maximum) - glm::dvec3(b.minimum);
  return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Inserts two zero bits after each of ten bits.
uint32_t spread(uint32_t x) {
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

uint32_t place_on_curve(glm::vec3 share) {
  const glm::uvec3 cell(glm::clamp(share, 0.0f, 1.0f) * 1023.0f);
  return spread(cell.x) | (spread(cell.y) << 1) | (spread(cell.z) << 2);
}

}  // namespace

void PoseQuality::build(const model::Mesh& mesh) {
  const glm::vec3 size = glm::max(mesh.bounds.maximum - mesh.bounds.minimum, glm::vec3(1e-30f));
  std::vector<uint32_t> places;
  places.reserve(mesh.triangles.size());
  for (const glm::uvec3 t : mesh.triangles) {
    const glm::vec3 center = (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) * (1.0f / 3.0f);
    places.push_back(place_on_curve((center - mesh.bounds.minimum) / size));
  }
  order_.resize(mesh.triangles.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(order_.begin(), order_.end(),
            [&](uint32_t a, uint32_t b) { return places[a] != places[b] ? places[a] < places[b] : a < b; });
  built_ = cost(mesh);
}

double PoseQuality::growth(const model::Mesh& mesh) {
  if (order_.size() != mesh.triangles.size()) return std::numeric_limits<double>::infinity();
  return built_ > 0.0 ? cost(mesh) / built_ : 1.0;
}

double PoseQuality::cost(const model::Mesh& mesh) {
  constexpr size_t group = 4;
  boxes_.clear();
  boxes_.reserve((order_.size() + group - 1) / group);
  for (size_t i = 0; i < order_.size(); ++i) {
    if (i % group == 0) boxes_.emplace_back();
    for (int k = 0; k < 3; ++k) boxes_.back().add(mesh.positions[mesh.triangles[order_[i]][k]]);
  }
  double sum = 0.0;
  for (;;) {
    for (const model::Bounds& box : boxes_) sum += half_area(box);
    if (boxes_.size() <= 1) break;
    // Groups are merged in place: a group's boxes never come before its merged box.
    const size_t parents = (boxes_.size() + group - 1) / group;
    for (size_t p = 0; p < parents; ++p) {
      model::Bounds box = boxes_[p * group];
      for (size_t i = p * group + 1; i < std::min((p + 1) * group, boxes_.size()); ++i) {
        box.add(boxes_[i].minimum);
        box.add(boxes_[i].maximum);
      }
      boxes_[p] = box;
    }
    boxes_.resize(parents);
  }
  const double whole = boxes_.empty() ? 0.0 : half_area(boxes_.front());
  return whole > 0.0 ? sum / whole : 0.0;
}

}  // namespace sideray::rt
