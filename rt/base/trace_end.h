// Says how tracing a frame, or a part of it, ended. A value; any thread.
#pragma once

namespace sideray::rt {

enum class TraceEnd {
  complete,
  late,      // the deadline passed: what was not traced has no answer
  cancelled  // the result is no longer wanted
};

}  // namespace sideray::rt
