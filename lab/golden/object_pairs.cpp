#include "lab/golden/object_pairs.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <unordered_map>

namespace sideray::lab {
namespace {

using Overlaps = std::map<std::pair<size_t, size_t>, uint64_t>;  // (now, reference) -> pixels that show both

Overlaps overlaps_of(std::span<const size_t> now, std::span<const size_t> reference) {
  Overlaps overlaps;
  for (size_t i = 0; i < now.size(); ++i)
    if (now[i] != no_object && reference[i] != no_object) ++overlaps[{now[i], reference[i]}];
  return overlaps;
}

class Pairs {
 public:
  Pairs(const std::vector<NamedObject>& now, const std::vector<NamedObject>& reference)
      : now_(now), reference_(reference), of_now_(now.size(), no_object), is_taken_(reference.size(), false) {}

  void add(size_t now, size_t reference) {
    if (of_now_[now] != no_object || is_taken_[reference]) return;
    of_now_[now] = reference;
    is_taken_[reference] = true;
  }

  // Pairs objects by name and number. That is sure only where both scenes have as many objects of the name: otherwise
  // numbers may have shifted.
  void add_by_number(bool only_of_equal_sets) {
    std::map<std::pair<std::string, uint32_t>, size_t> numbered;
    for (size_t i = 0; i < reference_.size(); ++i) numbered[{reference_[i].name, reference_[i].number}] = i;
    for (size_t i = 0; i < now_.size(); ++i) {
      const auto at = numbered.find({now_[i].name, now_[i].number});
      if (at == numbered.end()) continue;
      if (!only_of_equal_sets || reference_[at->second].of == now_[i].of) add(i, at->second);
    }
  }

  void add_by_overlap(const Overlaps& overlaps) {
    std::vector<std::tuple<uint64_t, size_t, size_t>> largest;
    for (const auto& [pair, pixels] : overlaps)
      if (now_[pair.first].name == reference_[pair.second].name) largest.emplace_back(pixels, pair.first, pair.second);
    std::sort(largest.begin(), largest.end(), [](const auto& a, const auto& b) {
      return std::get<0>(a) != std::get<0>(b) ? std::get<0>(a) > std::get<0>(b) : a < b;
    });
    for (const auto& [pixels, now, reference] : largest) add(now, reference);
  }

  std::vector<size_t> result() && { return std::move(of_now_); }

 private:
  const std::vector<NamedObject>&now_, &reference_;
  std::vector<size_t> of_now_;
  std::vector<bool> is_taken_;
};

}  // namespace

std::vector<size_t> shown_objects(const ShownPicture& shown) {
  std::unordered_map<uint32_t, size_t> of_surface;
  for (size_t i = 0; i < shown.objects.size(); ++i)
    for (const uint32_t surface : shown.objects[i].surfaces) of_surface.emplace(surface, i);
  std::vector<size_t> objects;
  const std::vector<uint32_t>& ids = shown.ids.find("first.surface")->uint_values;
  objects.reserve(ids.size());
  for (const uint32_t id : ids) {
    const auto at = of_surface.find(id);
    objects.push_back(id == 0 || at == of_surface.end() ? no_object : at->second);
  }
  return objects;
}

std::vector<size_t> paired_objects(const std::vector<NamedObject>& now, std::span<const size_t> now_shown,
                                   const std::vector<NamedObject>& reference, std::span<const size_t> reference_shown) {
  Pairs pairs(now, reference);
  pairs.add_by_number(true);
  pairs.add_by_overlap(overlaps_of(now_shown, reference_shown));
  pairs.add_by_number(false);
  return std::move(pairs).result();
}

}  // namespace sideray::lab
