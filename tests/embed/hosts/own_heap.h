// Counts the memory that the program and its linked libraries hold by operator new, without that of drivers, which are
// loaded later, and without direct malloc(). Test support; one at a time, any thread may allocate.
#pragma once

#include <cstddef>

namespace sideray::tests {

class OwnHeap {
 public:
  struct Use {
    size_t bytes = 0, blocks = 0;
  };

  // Counts allocations from here on, until it is destroyed. Counts nothing with sanitizers, which have their own
  // operator new.
  OwnHeap();
  ~OwnHeap();
  OwnHeap(const OwnHeap&) = delete;
  OwnHeap& operator=(const OwnHeap&) = delete;

  // Returns the memory that was allocated since the count began and is still held.
  Use use() const;
};

}  // namespace sideray::tests
