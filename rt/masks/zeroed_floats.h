// Holds floats that are 0 until they are written. The system provides their memory where it is written first, by the
// thread that writes: large planes of which a frame uses parts cost neither time nor memory elsewhere.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace sideray::rt {

class ZeroedFloats {
 public:
  void reset(size_t size) {
    floats_.reset(size > 0 ? static_cast<float*>(std::calloc(size, sizeof(float))) : nullptr);
    if (size > 0 && !floats_) throw std::bad_alloc();
    size_ = size;
  }
  size_t size() const { return size_; }
  float* data() { return floats_.get(); }
  const float* data() const { return floats_.get(); }

 private:
  struct Free {
    void operator()(float* floats) const { std::free(floats); }
  };
  std::unique_ptr<float[], Free> floats_;
  size_t size_ = 0;
};

}  // namespace sideray::rt
