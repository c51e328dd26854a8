// What the opaque handles of sideray.h point at. Reference counts are atomic; the rest follows the header's thread
// rules.
#pragma once

#include <sideray/sideray.h>

#include <atomic>
#include <memory>
#include <mutex>

#include "bridge/base/tracer_turn.h"
#include "model/scene.h"
#include "rt/shading/shading_queue.h"
#include "rt/tracer.h"

struct sideray_scene {
  std::atomic<uint32_t> references{1};
  sideray::model::Scene scene;
};

struct sideray_tracer {
  std::atomic<uint32_t> references{1};
  sideray_scene* scene;  // one reference held
  // A service's worker and direct calls take turns.
  sideray::bridge::TracerTurn turn;
  // From services' workers to the host's calls.
  sideray::rt::ShadingQueue shading;
  sideray::rt::Tracer tracer;
  std::shared_ptr<const sideray::model::Snapshot> snapshot;  // what the tracer holds

  sideray_tracer(sideray_scene* traced_scene, const sideray::rt::TracerConfig& config);
  // With the scene of another one, as rt::Tracer has it.
  explicit sideray_tracer(sideray_tracer& other);
  ~sideray_tracer();
  // The last commit. Throws Failure where nothing is committed.
  std::shared_ptr<const sideray::model::Snapshot> committed() const;
  // Takes the turn on a thread of the host; what the host's shader is asked for meanwhile is done.
  std::unique_lock<sideray::bridge::TracerTurn> take_turn_in_call();
  // Wakes threads that wait for the turn or for the host's shader: they check whether their frame was cancelled.
  void wake();
  // Makes the tracer hold a commit; call in turn.
  void use(std::shared_ptr<const sideray::model::Snapshot> commit);
};
