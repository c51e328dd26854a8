// Sets the floating-point mode for all tracing and shading, so that results do not depend on the mode of the thread
// that runs a piece of work. Any thread may use it, for itself.
#pragma once

#if defined(__SSE__)
#include <immintrin.h>
#endif

namespace sideray::rt {

// Treats denormals as zero on this thread for as long as it lives.
#if defined(__SSE__)
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | flush_to_zero | denormals_are_zero); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  static constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
  unsigned saved_;
};
#else
struct FlushDenormals {
  FlushDenormals() {}
};
#endif

// Computes with denormals on this thread for as long as it lives.
#if defined(__SSE__)
class KeepDenormals {
 public:
  KeepDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ & ~(flush_to_zero | denormals_are_zero)); }
  ~KeepDenormals() { _mm_setcsr(saved_); }
  KeepDenormals(const KeepDenormals&) = delete;
  KeepDenormals& operator=(const KeepDenormals&) = delete;

 private:
  static constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
  unsigned saved_;
};
#else
struct KeepDenormals {
  KeepDenormals() {}
};
#endif

}  // namespace sideray::rt
