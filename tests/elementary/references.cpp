#include "elementary/references.h"

#include <bit>

#include "elementary/functions.h"

namespace sideray::elementary_tests {

const Function functions[10] = {
    {"exp", elementary::exp, std::exp, std::exp, 0},     {"exp2", elementary::exp2, std::exp2, std::exp2, 2},
    {"log", elementary::log, std::log, std::log, 5},     {"log2", elementary::log2, std::log2, std::log2, 0},
    {"sin", elementary::sin, std::sin, std::sin, 2},     {"cos", elementary::cos, std::cos, std::cos, 4},
    {"tan", elementary::tan, std::tan, std::tan, 0},     {"asin", elementary::asin, std::asin, std::asin, 0},
    {"acos", elementary::acos, std::acos, std::acos, 16}, {"atan", elementary::atan, std::atan, std::atan, 16},
};

uint64_t count_wrong(const Function& function, uint32_t first, uint64_t step, uint64_t& off) {
  uint64_t wrong = 0;
  for (uint64_t bits = first; bits < uint64_t{1} << 32; bits += step) {
    const auto x = std::bit_cast<float>(static_cast<uint32_t>(bits));
    const float ours = function.ours(x);
    const float wanted = nearest_float(function.reference(static_cast<double>(x)),
                                       [&] { return function.long_reference(static_cast<long double>(x)); });
    if (same(ours, wanted)) continue;
    ++wrong;
    off += ours != std::nextafter(wanted, ours);
  }
  return wrong;
}

}  // namespace sideray::elementary_tests
