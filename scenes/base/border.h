// Turns exceptions into the errors of the C interface of scenes.h, as bridge/api/border.h does for sideray.h. The two
// libraries share only the public headers. Any thread.
#pragma once

#include <fmt/format.h>
#include <sideray/base.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <new>
#include <sideray/sideray.hpp>

namespace sideray::scenes {

inline sideray_status report(sideray_error* error, sideray_status status, const char* message) noexcept {
  if (!error) return status;
  error->status = status;
  std::snprintf(error->message, sizeof(error->message), "%s", message);
  return status;
}

// Runs `body`, and turns exceptions into a status and a message.
template <typename Body>
sideray_status guarded(sideray_error* error, const Body& body) noexcept {
  try {
    body();
    return SIDERAY_OK;
  } catch (const Error& failure) {
    return report(error, failure.status, failure.what());
  } catch (const std::bad_alloc&) {
    return report(error, SIDERAY_OUT_OF_MEMORY,
                  "memory: this machine has not enough; close other programs or load a smaller scene");
  } catch (const std::exception& exception) {
    return report(error, SIDERAY_INTERNAL, exception.what());
  } catch (...) {
    return report(error, SIDERAY_INTERNAL, "unknown exception");
  }
}

inline void require(const void* pointer, const char* name) {
  if (!pointer) throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("{}: is NULL; give a valid pointer", name));
}

// A larger difference from our size means that the caller left `size` uninitialized: no version will grow that much.
inline constexpr size_t most_unknown_bytes = 4096;

inline void require_size(size_t size, size_t known_bytes, const char* name) {
  if (size < sizeof(size_t) || size > known_bytes + most_unknown_bytes)
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("{}: size is {}, where this version has {}; fill the struct with its defaults function first",
                            name, size, known_bytes));
}

// Fills those fields of the caller's struct that both know with the defaults, and those of a newer caller with 0.
template <typename T>
void init_struct(T* out, size_t size, T defaults) noexcept {
  if (!out || size < sizeof(size_t)) return;
  defaults.size = size;
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &defaults, std::min(size, sizeof(T)));
}

// Copies a struct of any version; NULL means the defaults. Fields that an older caller lacks get their defaults. Fields
// that a newer caller has beyond ours must be 0, since they would have no effect.
template <typename T>
T read_struct(const T* given, const char* name, void (*init)(T*, size_t)) {
  T read;
  init(&read, sizeof(T));
  if (!given) return read;
  const size_t size = given->size;
  require_size(size, sizeof(T), name);
  std::memcpy(static_cast<void*>(&read), given, std::min(size, sizeof(T)));
  read.size = sizeof(T);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (size_t i = sizeof(T); i < size; ++i)
    if (bytes[i] != 0)
      throw Error(SIDERAY_UNSUPPORTED,
                  fmt::format("{}: the field at byte {} is not known to this version, {}.{}.{}; set it to 0", name, i,
                              SIDERAY_VERSION_MAJOR, SIDERAY_VERSION_MINOR, SIDERAY_VERSION_PATCH));
  return read;
}

// Fills the fields that the caller's struct has; its `size` stays.
template <typename T>
void write_struct(T* out, const T& filled, const char* name) {
  require(out, name);
  const size_t size = out->size;
  require_size(size, sizeof(T), name);
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &filled, std::min(size, sizeof(T)));
  out->size = size;
}

}  // namespace sideray::scenes
