// Reads and fills structs of the public interface in any version: fields that an older caller lacks have their
// defaults; fields that only a newer caller has must be 0. Any thread.
#pragma once

#include <sideray/service.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "model/failure.h"

namespace sideray::bridge {

template <typename T>
void require(const T* pointer, const char* name) {
  if (!pointer) fail(SIDERAY_INVALID_ARGUMENT, "{}: is NULL; give a valid pointer", name);
}

// No version of a struct is this much larger than today's: a larger `size` was left uninitialised.
inline constexpr size_t most_unknown_bytes = 4096;

// Throws Failure if no version of a struct that has `known_bytes` today can have this `size`.
inline void require_size(size_t size, size_t known_bytes, const char* name) {
  if (size < sizeof(size_t) || size > known_bytes + most_unknown_bytes)
    fail(SIDERAY_INVALID_ARGUMENT, "{}: size is {}, where this version has {}; set it to sizeof(the struct)", name,
         size, known_bytes);
}

// Fills the caller's struct up to its size; fields that only the caller has become 0.
template <typename T>
void init_struct(T* out, size_t size, T defaults) noexcept {
  if (!out || size < sizeof(size_t)) return;
  defaults.size = size;
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &defaults, std::min(size, sizeof(T)));
}

// Copies a struct of any version: fields that an older caller lacks have their defaults, and fields that only a newer
// caller has must be 0, since they cannot be honoured. The copy has our size.
template <typename T>
T read_struct(const T* given, const char* name, void (*init)(T*, size_t)) {
  require(given, name);
  const size_t size = given->size;
  require_size(size, sizeof(T), name);
  T read;
  init(&read, sizeof(T));
  std::memcpy(static_cast<void*>(&read), given, std::min(size, sizeof(T)));
  read.size = sizeof(T);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (size_t i = sizeof(T); i < size; ++i)
    if (bytes[i] != 0)
      fail(SIDERAY_UNSUPPORTED, "{}: the field at byte {} is not known to this version, {}.{}.{}; set it to 0", name, i,
           SIDERAY_VERSION_MAJOR, SIDERAY_VERSION_MINOR, SIDERAY_VERSION_PATCH);
  return read;
}

// Returns the rate in use: until version 0.4, those of 0.2 that reused frames count as full.
inline sideray_cache_rate read_rate(sideray_cache_rate rate) {
  return rate == SIDERAY_RATE_TEMPORAL4 || rate == SIDERAY_RATE_TEMPORAL8 ? SIDERAY_RATE_FULL : rate;
}

// Fills the caller's struct up to its size, and keeps that size.
template <typename T>
void write_struct(T* out, const T& filled, const char* name) {
  require(out, name);
  const size_t size = out->size;
  require_size(size, sizeof(T), name);
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &filled, std::min(size, sizeof(T)));
  out->size = size;
}

// Copies the i-th struct of an array with a stride of `stride_bytes`; fields that an older caller lacks are 0.
template <typename T>
T read_element(const T* array, size_t stride_bytes, size_t i) {
  T element{};
  std::memcpy(static_cast<void*>(&element), reinterpret_cast<const unsigned char*>(array) + i * stride_bytes,
              std::min(stride_bytes, sizeof(T)));
  return element;
}

template <typename T>
void write_element(T* array, size_t stride_bytes, size_t i, const T& element) {
  std::memcpy(reinterpret_cast<unsigned char*>(array) + i * stride_bytes, &element, std::min(stride_bytes, sizeof(T)));
}

// Throws Failure where no version of an element fits the stride.
template <typename T>
void require_stride(size_t stride_bytes, const char* name) {
  if (stride_bytes == 0 || stride_bytes % alignof(T) != 0 || stride_bytes > sizeof(T) + most_unknown_bytes)
    fail(SIDERAY_INVALID_ARGUMENT,
         "{}: elements are {} bytes apart, where this version has {}; give sizeof(the struct)", name, stride_bytes,
         sizeof(T));
}

// Returns the structs of an array of any version: the caller's memory if its stride is ours, otherwise `copies`.
template <typename T>
const T* read_elements(const T* array, size_t stride_bytes, size_t count, std::vector<T>& copies, const char* name) {
  if (count == 0) return array;
  require(array, name);
  require_stride<T>(stride_bytes, name);
  if (stride_bytes == sizeof(T)) return array;
  copies.resize(count);
  for (size_t i = 0; i < count; ++i) copies[i] = read_element(array, stride_bytes, i);
  return copies.data();
}

}  // namespace sideray::bridge
