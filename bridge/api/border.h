// Turns exceptions inside into status codes outside. Every C entry point that can fail goes through it.
#pragma once

#include <sideray/sideray.h>

#include <cstdio>
#include <new>
#include <utility>

#include "bridge/base/versions.h"
#include "model/failure.h"

namespace sideray::bridge {

inline sideray_status report(sideray_error* error, sideray_status status, const char* message) noexcept {
  if (error) {
    error->status = status;
    std::snprintf(error->message, sizeof(error->message), "%s", message);
  }
  return status;
}

// Runs `body`, which returns a sideray_status or nothing, and turns what it throws into a status and a message.
template <typename Body>
sideray_status guarded(sideray_error* error, Body&& body) noexcept {
  try {
    if constexpr (std::is_void_v<decltype(body())>) {
      body();
      return SIDERAY_OK;
    } else {
      return body();
    }
  } catch (const Failure& failure) {
    return report(error, failure.status, failure.what());
  } catch (const std::bad_alloc&) {
    return report(error, SIDERAY_OUT_OF_MEMORY,
                  "memory: this machine has not enough; close other programs or ask for less");
  } catch (const std::exception& exception) {
    return report(error, SIDERAY_INTERNAL, exception.what());
  } catch (...) {
    return report(error, SIDERAY_INTERNAL, "unknown exception");
  }
}

}  // namespace sideray::bridge
