// Includes Embree 3.13 or 4 and hides the differences between them, for packets of 16, 8, 4 and 1 rays. No other header
// depends on the version. Any thread may use it.
#pragma once

#if __has_include(<embree4/rtcore.h>) && !__has_include(<embree3/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace sideray::rt::embree {

#if RTC_VERSION_MAJOR >= 4

inline constexpr RTCSceneFlags filter_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

// Carries a filter's state through Embree: derive from it, and get the state back by state_of().
struct Query : RTCRayQueryContext {
  Query() : RTCRayQueryContext{} { rtcInitRayQueryContext(this); }
};

inline RTCRayQueryFlags query_flags(bool coherent, bool filter) {
  const int flags = (coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT) |
                    (filter ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : 0);
  return static_cast<RTCRayQueryFlags>(flags);
}

struct IntersectArguments : RTCIntersectArguments {
  IntersectArguments(Query& query, bool coherent, RTCFilterFunctionN filter_function) : RTCIntersectArguments{} {
    rtcInitIntersectArguments(this);
    flags = query_flags(coherent, filter_function);
    context = &query;
    filter = filter_function;
  }
  RTCIntersectArguments* get() { return this; }
};

struct OccludedArguments : RTCOccludedArguments {
  OccludedArguments(Query& query, bool coherent, RTCFilterFunctionN filter_function) : RTCOccludedArguments{} {
    rtcInitOccludedArguments(this);
    flags = query_flags(coherent, filter_function);
    context = &query;
    filter = filter_function;
  }
  RTCOccludedArguments* get() { return this; }
};

#define SIDERAY_RTC_CALL(function, scene, arguments, packet) function(scene, packet, (arguments).get())
#define SIDERAY_RTC_CALL_N(function, valid, scene, arguments, packet) function(valid, scene, packet, (arguments).get())

#else

inline constexpr RTCSceneFlags filter_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

// Carries a filter's state through Embree: derive from it, and get the state back by state_of().
struct Query : RTCIntersectContext {
  Query() : RTCIntersectContext{} { rtcInitIntersectContext(this); }
};

struct IntersectArguments {
  IntersectArguments(Query& query, bool coherent, RTCFilterFunctionN filter) : context(&query) {
    query.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    query.filter = filter;
  }
  RTCIntersectContext* get() { return context; }
  RTCIntersectContext* context;
};
using OccludedArguments = IntersectArguments;

#define SIDERAY_RTC_CALL(function, scene, arguments, packet) function(scene, (arguments).get(), packet)
#define SIDERAY_RTC_CALL_N(function, valid, scene, arguments, packet) function(valid, scene, (arguments).get(), packet)

#endif

template <typename State>
State& state_of(const RTCFilterFunctionNArguments& arguments) {
  return static_cast<State&>(*static_cast<Query*>(arguments.context));
}

// Packet<N> names the aligned structs and calls of width N. `valid` holds -1 or 0 for each lane. A width that the
// machine does not have natively ignores it, so inactive lanes must hold harmless rays too.
template <unsigned N>
struct Packet;

#define SIDERAY_PACKET(N)                                                                                    \
  template <>                                                                                                \
  struct Packet<N> {                                                                                         \
    using RayHit = RTCRayHit##N;                                                                             \
    using Ray = RTCRay##N;                                                                                   \
    static void intersect(const int* valid, RTCScene scene, IntersectArguments& arguments, RayHit* packet) { \
      SIDERAY_RTC_CALL_N(rtcIntersect##N, valid, scene, arguments, packet);                                  \
    }                                                                                                        \
    static void occluded(const int* valid, RTCScene scene, OccludedArguments& arguments, Ray* packet) {      \
      SIDERAY_RTC_CALL_N(rtcOccluded##N, valid, scene, arguments, packet);                                   \
    }                                                                                                        \
  }
SIDERAY_PACKET(16);
SIDERAY_PACKET(8);
SIDERAY_PACKET(4);
#undef SIDERAY_PACKET

template <>
struct Packet<1> {
  using RayHit = RTCRayHit;
  using Ray = RTCRay;
  static void intersect(const int* valid, RTCScene scene, IntersectArguments& arguments, RayHit* packet) {
    if (*valid) SIDERAY_RTC_CALL(rtcIntersect1, scene, arguments, packet);
  }
  static void occluded(const int* valid, RTCScene scene, OccludedArguments& arguments, Ray* packet) {
    if (*valid) SIDERAY_RTC_CALL(rtcOccluded1, scene, arguments, packet);
  }
};

#undef SIDERAY_RTC_CALL
#undef SIDERAY_RTC_CALL_N

}  // namespace sideray::rt::embree
