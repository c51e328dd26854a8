// Holds numbers that start as zeros in memory that the system maps where it is first touched, by the thread that touches
// it: large planes of which a frame uses parts cost neither time nor memory elsewhere.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace sideray::rt {

template <typename T>
struct ZeroedAllocator {
  using value_type = T;

  ZeroedAllocator() = default;
  template <typename U>
  ZeroedAllocator(const ZeroedAllocator<U>&) noexcept {}

  T* allocate(size_t count) {
    void* memory = std::calloc(count, sizeof(T));
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t) noexcept { std::free(memory); }
  // The memory is zero already.
  void construct(T*) noexcept {}
  template <typename... Values>
  void construct(T* place, Values&&... values) {
    std::construct_at(place, std::forward<Values>(values)...);
  }
  friend bool operator==(const ZeroedAllocator&, const ZeroedAllocator&) { return true; }
};

// Is made at its size: one that shrinks and grows again would have its old values.
template <typename T>
using ZeroedVector = std::vector<T, ZeroedAllocator<T>>;

}  // namespace sideray::rt
