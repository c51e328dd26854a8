// Defines the elementary functions in double precision, for a scalar double (elementary/functions.cpp) or a vector of
// doubles (rt/base/lanes.h). Included inside a namespace that has
//   Real   double, or a vector of them,
//   Word   uint64_t, or a vector of as many,
//   SIDERAY_CORE   the specifiers of each function.
// The functions use + - * / and bit operations alone, whose results IEEE 754 fixes, so that a lane, a scalar and every
// processor get the same bits. No result depends on other lanes. Errors are a few units of 2^-53, relative to the
// result, so that a result rounded to float is the nearest float to the truth, with few exceptions
// (elementary/functions.h). Any thread may call them.

// Returns one of the two sums in c0 + z (c2 + z (c4 + ...)) + x (c1 + z (c3 + ...)), z = x^2: with `odd` the second
// without its factor x, otherwise the first. Two sums have half as long a chain of dependent operations as one.
template <bool odd, typename... More>
SIDERAY_CORE Real core_half(Real z, double c0, double c1, More... more) {
  const double c = odd ? c1 : c0;
  if constexpr (sizeof...(more) == 0)
    return z - z + c;
  else if constexpr (sizeof...(more) == 1)
    return odd ? z - z + c : z * (more + ...) + c;
  else
    return core_half<odd>(z, more...) * z + c;
}
template <typename... More>
SIDERAY_CORE Real core_polynomial(Real x, double c0, double c1, More... more) {
  const Real z = x * x;
  return core_half<false>(z, c0, c1, more...) + x * core_half<true>(z, c0, c1, more...);
}

// Holds the number value * 2^power; the low bits of `power` are the exponent in two's complement.
struct CoreScaled {
  Real value;
  Word power;
};

SIDERAY_CORE Real core_scaled(CoreScaled s) {
  return s.value * __builtin_bit_cast(Real, (s.power + 1023) << 52);
}

// Returns x rounded to an integer, ties to even, |x| < 2^51; the low bits of `bits` get the integer.
SIDERAY_CORE Real core_nearest(Real x, Word& bits) {
  constexpr double magic = 0x1.8p52;
  const Real shifted = x + magic;
  bits = __builtin_bit_cast(Word, shifted);
  return shifted - magic;
}

// Returns e^r - 1, |r| <= 0.35.
SIDERAY_CORE Real core_exp_small(Real r) {
  return r + r * r *
                 core_polynomial(r, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320,
                                 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600);
}

// Returns e^x, |x| < 2^20.
SIDERAY_CORE CoreScaled core_exp(Real x) {
  Word power;
  const Real n = core_nearest(x * 0x1.71547652b82fep+0, power);
  return {1.0 + core_exp_small((x - n * 0x1.62e42fefa2p-1) - n * 0x1.9ef35793c7673p-41), power};
}

// Returns 2^x, |x| < 2^20.
SIDERAY_CORE CoreScaled core_exp2(Real x) {
  Word power;
  const Real n = core_nearest(x, power);
  return {1.0 + core_exp_small((x - n) * 0x1.62e42fefa39efp-1), power};
}

// Holds a logarithm as exponent * log 2 + rest.
struct CoreLog {
  Real exponent, rest;
};

// Returns the logarithm of a normal number > 0.
SIDERAY_CORE CoreLog core_log_parts(Real x) {
  constexpr uint64_t root_half = 0x3fe6a09e667f3bcd, one = 0x3ff0000000000000;
  const Word moved = __builtin_bit_cast(Word, x) + (one - root_half);
  const Real exponent = __builtin_bit_cast(Real, (moved >> 52) | 0x4330000000000000) - (0x1p52 + 1023.0);
  const Real m = __builtin_bit_cast(Real, (moved & 0x000fffffffffffff) + root_half);  // sqrt(1/2) .. sqrt(2)
  // log m = 2 artanh s = 2 (s + s^3 / 3 + ...); with f = m - 1: 2 s = f - s f.
  const Real f = m - 1.0, s = f / (m + 1.0), z = s * s;
  const Real series = core_polynomial(z, 2.0 / 3, 2.0 / 5, 2.0 / 7, 2.0 / 9, 2.0 / 11, 2.0 / 13, 2.0 / 15, 2.0 / 17,
                                      2.0 / 19, 2.0 / 21);
  return {exponent, f - s * (f - z * series)};
}

SIDERAY_CORE Real core_log(Real x) {
  const CoreLog l = core_log_parts(x);
  return l.exponent * 0x1.62e42fefa2p-1 + (l.rest + l.exponent * 0x1.9ef35793c7673p-41);
}

SIDERAY_CORE Real core_log2(Real x) {
  const CoreLog l = core_log_parts(x);
  return l.exponent + l.rest * 0x1.71547652b82fep+0;
}

// Returns sin r and cos r, |r| <= pi / 4.
SIDERAY_CORE Real core_sin_small(Real r) {
  const Real z = r * r;
  return r + r * z *
                 core_polynomial(z, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800.0,
                                 -1.0 / 1307674368000.0, 1.0 / 355687428096000.0);
}
SIDERAY_CORE Real core_cos_small(Real r) {
  const Real z = r * r;
  return 1.0 + z * core_polynomial(z, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, 1.0 / 479001600,
                                   -1.0 / 87178291200.0, 1.0 / 20922789888000.0);
}

// Returns the magnitude of x.
SIDERAY_CORE Real core_abs(Real x) {
  return __builtin_bit_cast(Real, __builtin_bit_cast(Word, x) & 0x7fffffffffffffff);
}

// Returns the angle of (x, y), -pi .. pi, with y's sign. Where y is 0 it is pi for x < 0, else 0. Both must be finite,
// of magnitudes up to 2^1000.
SIDERAY_CORE Real core_atan2(Real y, Real x) {
  const Real ax = core_abs(x), ay = core_abs(y);
  const Real most = ax < ay ? ay : ax, least = ax < ay ? ax : ay;
  // Splits the angle into that of the nearest of five directions and a rest whose tangent is t, |t| <= 1/8.
  const Real zero = most - most;
  Real c = zero, angle = zero;
  c = least > most * 0.125 ? zero + 0.25 : c, angle = least > most * 0.125 ? zero + 0x1.f5b75f92c80ddp-3 : angle;
  c = least > most * 0.375 ? zero + 0.5 : c, angle = least > most * 0.375 ? zero + 0x1.dac670561bb4fp-2 : angle;
  c = least > most * 0.625 ? zero + 0.75 : c, angle = least > most * 0.625 ? zero + 0x1.4978fa3269ee1p-1 : angle;
  c = least > most * 0.875 ? zero + 1.0 : c, angle = least > most * 0.875 ? zero + 0x1.921fb54442d18p-1 : angle;
  const Real below = most + c * least, t = (least - c * most) / (below > 0.0 ? below : zero + 1.0), z = t * t;
  angle = angle + (t + t * z *
                           core_polynomial(z, -1.0 / 3, 1.0 / 5, -1.0 / 7, 1.0 / 9, -1.0 / 11, 1.0 / 13, -1.0 / 15,
                                           1.0 / 17));
  angle = ax < ay ? 0x1.921fb54442d18p+0 - (angle - 0x1.1a62633145c07p-54) : angle;
  angle = x < 0.0 ? 0x1.921fb54442d18p+1 - (angle - 0x1.1a62633145c07p-53) : angle;
  return __builtin_bit_cast(Real, __builtin_bit_cast(Word, angle) | (__builtin_bit_cast(Word, y) & 0x8000000000000000));
}
