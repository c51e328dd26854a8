// Defines the opaque handles of sideray.h. Reference counts are atomic; the rest follows the header's thread rules.
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
  // Gives turns to a service's worker and to direct calls.
  sideray::bridge::TracerTurn turn;
  // Passes shading requests from services' workers to the host's calls.
  sideray::rt::ShadingQueue shading;
  sideray::rt::Tracer tracer;
  std::shared_ptr<const sideray::model::Snapshot> snapshot;  // the commit that the tracer holds

  sideray_tracer(sideray_scene* traced_scene, const sideray::rt::TracerConfig& config);
  // Shares the scene of another tracer, as rt::Tracer does.
  explicit sideray_tracer(sideray_tracer& other);
  ~sideray_tracer();
  // Returns the last commit. Throws Failure where nothing is committed.
  std::shared_ptr<const sideray::model::Snapshot> committed() const;
  // Takes the turn on a thread of the host, which runs the host's shader on request while it waits.
  std::unique_lock<sideray::bridge::TracerTurn> take_turn_in_call();
  // Wakes threads that wait for the turn or for the host's shader: they check whether their frame was cancelled.
  void wake();
  // Makes the tracer hold a commit; the caller must have the turn.
  void use(std::shared_ptr<const sideray::model::Snapshot> commit);
};
