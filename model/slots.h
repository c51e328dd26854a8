// Stores objects under names that stay the same while other objects come and go; a scene stores what its host adds. One
// thread at a time may use it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "model/snapshot.h"

namespace sideray::model {

// A name is the number of a slot, from 1. Free slots are reused before new ones are made, the lowest first, so that
// there are never more slots than objects at the same time.
template <typename T>
class Slots {
 public:
  // Throws bad_alloc, having added nothing. Allocates no memory if reserve() has made room.
  uint32_t add(T thing) {
    if (free_.empty()) {
      reserve(1);
      slots_.push_back({std::move(thing), 0});
      ++size_;
      return static_cast<uint32_t>(slots_.size());
    }
    std::pop_heap(free_.begin(), free_.end(), std::greater<>());
    const uint32_t name = free_.back();
    free_.pop_back();
    Slot& slot = slots_[name - 1];
    slot.thing = std::move(thing);
    ++slot.reuse;
    ++size_;
    return name;
  }

  // Makes room for so many more objects.
  void reserve(size_t count) {
    const size_t more = count - std::min(count, free_.size());
    if (slots_.capacity() - slots_.size() < more)
      slots_.reserve(std::max(slots_.size() + more, 2 * slots_.capacity()));
    if (free_.capacity() < slots_.capacity()) free_.reserve(slots_.capacity());
  }

  void remove(uint32_t name) {
    slots_[name - 1].thing.reset();
    free_.push_back(name);  // within its capacity: see reserve()
    std::push_heap(free_.begin(), free_.end(), std::greater<>());
    --size_;
    any_removed_ = true;
  }

  // Returns null where no object has this name.
  T* find(uint32_t name) {
    if (name == 0 || name > slots_.size() || !slots_[name - 1].thing) return nullptr;
    return &*slots_[name - 1].thing;
  }
  const T* find(uint32_t name) const { return const_cast<Slots*>(this)->find(name); }

  size_t size() const { return size_; }
  size_t slot_count() const { return slots_.size(); }

  // Calls visit(name, thing) for each object, by ascending names.
  template <typename Visit>
  void for_each(Visit&& visit) {
    for (size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].thing) visit(static_cast<uint32_t>(i + 1), *slots_[i].thing);
  }
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].thing) visit(static_cast<uint32_t>(i + 1), *slots_[i].thing);
  }

  // Returns the objects' names, in the order of for_each.
  Names names() const {
    Names names;
    if (!any_removed_) return names;
    names.all.reserve(size_);
    for (size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].thing) names.all.push_back({static_cast<uint32_t>(i + 1), slots_[i].reuse});
    return names;
  }

  // Returns each name's place in the order of for_each; [0] and the places of free slots mean nothing.
  std::vector<uint32_t> places() const {
    std::vector<uint32_t> places(slots_.size() + 1, 0);
    uint32_t place = 0;
    for (size_t i = 0; i < slots_.size(); ++i) {
      places[i + 1] = place;
      if (slots_[i].thing) ++place;
    }
    return places;
  }

 private:
  struct Slot {
    std::optional<T> thing;
    uint32_t reuse = 0;  // how often the name was reused
  };

  std::vector<Slot> slots_;
  std::vector<uint32_t> free_;  // a heap with the lowest name on top
  size_t size_ = 0;
  bool any_removed_ = false;
};

}  // namespace sideray::model
