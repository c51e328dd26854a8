// Provides elementary functions whose results have the same bits on every processor and with every C library. Results
// of libm differ between its versions, and between processors for which it has variants. Any thread may call them. They
// do not touch errno, and depend on no rounding but that of + - * / sqrt (elementary/cores.h). Angles are in radians.
// NaN and arguments outside the domain give NaN.
//
// Results in single precision are rounded from double. Tests over all floats (tests/elementary, Slow*) count the
// results that are not the nearest float; each of them is off by one unit in the last place:
//   exp 0, exp2 2, log 5, log2 0, sin 2, cos 4, tan 0, asin 0; acos and atan 0 of every 997th float;
//   pow of 2^31 numbers: 32 at the exponent 1/2.2, 30 at 1/2.4, 22 at 2.4; 1 of 10^8 pairs each for pow and atan2, chosen
//   by chance.
// In double precision the error of normal results is at most 4 units in the last place, with these exceptions: expm1 8
// units, pow 2^-44 of the result, and sin, cos and tan 2^-52 absolutely, for |x| <= 2^20.
#pragma once

namespace sideray::elementary {

float exp(float x);
float exp2(float x);
float log(float x);
float log2(float x);
float pow(float x, float y);  // x >= 0
float sin(float x);
float cos(float x);
float tan(float x);
float asin(float x);
float acos(float x);
float atan(float x);
float atan2(float y, float x);

double exp(double x);
double exp2(double x);
double expm1(double x);
double log(double x);
double log2(double x);
double pow(double x, double y);  // x >= 0
double sin(double x);
double cos(double x);
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);
double cbrt(double x);
float cbrt(float x);

// Returns the length of (x, y) or (x, y, z). In double no intermediate result overflows or underflows.
float hypot(float x, float y);
double hypot(double x, double y);
float hypot(float x, float y, float z);
double hypot(double x, double y, double z);

}  // namespace sideray::elementary
