// Random numbers that are the same on every machine for the same seed. Test support.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <iterator>

namespace sideray::fuzz {

// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
  }
  // 0 to count - 1; 0 where count is 0.
  uint32_t below(uint32_t count) { return count == 0 ? 0 : static_cast<uint32_t>(next() % count); }
  bool one_in(uint32_t count) { return below(count) == 0; }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  template <typename T>
  T pick(std::initializer_list<T> values) {
    return *std::next(values.begin(), below(static_cast<uint32_t>(values.size())));
  }
  template <typename List>
  const auto& of(const List& list) {
    return list[below(static_cast<uint32_t>(std::size(list)))];
  }

 private:
  uint64_t state_;
};

}  // namespace sideray::fuzz
