// What the program and the libraries that it is linked with hold by operator new. Drivers are loaded later, and what
// they hold is not counted, nor is what anybody holds by malloc() itself. Test support; one at a time, any thread
// allocates.
#pragma once

#include <cstddef>

namespace sideray::tests {

class OwnHeap {
 public:
  struct Use {
    size_t bytes = 0, blocks = 0;
  };

  // Counts what is allocated from here on, until it is destroyed. With sanitizers, which have an operator new of their
  // own, nothing is counted.
  OwnHeap();
  ~OwnHeap();
  OwnHeap(const OwnHeap&) = delete;
  OwnHeap& operator=(const OwnHeap&) = delete;

  // What is held now of what was allocated since the count began.
  Use use() const;
};

}  // namespace sideray::tests
