// What the opaque handles of sideray.h point at. Reference counts are atomic; the rest follows the header's thread
// rules.
#pragma once

#include <sideray/sideray.h>

#include <atomic>
#include <memory>
#include <mutex>

#include "model/scene.h"
#include "rt/tracer.h"

struct sideray_scene {
  std::atomic<uint32_t> references{1};
  sideray::model::Scene scene;
};

struct sideray_tracer {
  std::atomic<uint32_t> references{1};
  sideray_scene* scene;  // one reference held
  // A service's worker and direct calls take turns.
  std::mutex mutex;
  sideray::rt::Tracer tracer;
  std::shared_ptr<const sideray::model::Snapshot> snapshot;  // what the tracer holds

  sideray_tracer(sideray_scene* traced_scene, const sideray::rt::TracerConfig& config);
  ~sideray_tracer();
  // The last commit. Throws Failure where nothing is committed.
  std::shared_ptr<const sideray::model::Snapshot> committed() const;
  // Makes the tracer hold a commit; call with the mutex held.
  void use(std::shared_ptr<const sideray::model::Snapshot> commit);
};
