// sideray_camera_rays and sideray_object_truths_*: plain memory in, plain memory out.
#include <sideray/ground_truth.h>

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "bridge/api/border.h"
#include "bridge/api/truth_view.h"
#include "bridge/base/handles.h"
#include "rt/base/view_rays.h"
#include "rt/truth/object_truth.h"

using sideray::fail;
using sideray::bridge::check_truth_size;
using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::read_struct;
using sideray::bridge::read_truth_camera;
using sideray::bridge::require;
using sideray::bridge::require_stride;
using sideray::bridge::trace_view;
using sideray::bridge::truth_view;

struct sideray_object_truths {
  std::vector<sideray::rt::ObjectTruth> traced;  // entries point into it
  std::vector<sideray_object_truth> entries;
};

namespace {

using sideray::model::Snapshot;
using sideray::rt::ObjectTruthRequest;

// Maps each surface id to its object.
using ObjectOfSurface = std::unordered_map<uint32_t, uint32_t>;

ObjectOfSurface named_objects(const sideray_object_truth_desc& desc) {
  require(desc.objects, "objects");
  ObjectOfSurface objects;
  for (size_t i = 0; i < desc.count; ++i) {
    const uint32_t surface = desc.surface_ids[i], object = desc.objects[i];
    if (surface == 0 || object == 0)
      fail(SIDERAY_INVALID_ARGUMENT, "object truth: entry {} has a surface id or an object of 0; give numbers above 0", i);
    if (!objects.emplace(surface, object).second)
      fail(SIDERAY_INVALID_ARGUMENT, "object truth: surface id {} is named twice; name each once", surface);
  }
  return objects;
}

ObjectOfSurface all_surfaces(const Snapshot& snapshot) {
  ObjectOfSurface objects;
  for (const sideray::model::Instance& instance : snapshot.instances)
    if (instance.surface_id != 0) objects.emplace(instance.surface_id, instance.surface_id);
  return objects;
}

void require_present(const ObjectOfSurface& objects, const Snapshot& snapshot) {
  ObjectOfSurface present = all_surfaces(snapshot);
  for (const auto& [surface, object] : objects)
    if (!present.contains(surface))
      fail(SIDERAY_INVALID_ARGUMENT,
           "object truth: surface id {} (object {}) is not in the committed scene; name its instances' surface ids alone",
           surface, object);
}

// Returns the object numbers in ascending order, each once.
std::vector<uint32_t> numbers_of(const ObjectOfSurface& objects) {
  std::vector<uint32_t> numbers;
  for (const auto& entry : objects) numbers.push_back(entry.second);
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

std::vector<uint32_t> object_of_instances(const Snapshot& snapshot, const ObjectOfSurface& objects,
                                          const std::vector<uint32_t>& numbers) {
  std::vector<uint32_t> indices;
  for (const sideray::model::Instance& instance : snapshot.instances) {
    const auto found = objects.find(instance.surface_id);
    indices.push_back(found == objects.end()
                          ? ObjectTruthRequest::no_object
                          : static_cast<uint32_t>(std::lower_bound(numbers.begin(), numbers.end(), found->second) -
                                                  numbers.begin()));
  }
  return indices;
}

void check_desc(const sideray_object_truth_desc& desc) {
  check_truth_size(desc.width, desc.height);
  if (desc.samples_per_side < 1 || desc.samples_per_side > 16)
    fail(SIDERAY_INVALID_ARGUMENT, "samples_per_side {}: give 1 to 16", desc.samples_per_side);
  if (desc.hidden_by != SIDERAY_HIDDEN_BY_ALL && desc.hidden_by != SIDERAY_HIDDEN_BY_OPAQUE)
    fail(SIDERAY_INVALID_ARGUMENT, "hidden_by {}: give a sideray_hidden_by", static_cast<int>(desc.hidden_by));
}

sideray_object_mask public_mask(const sideray::rt::ObjectMask& mask) {
  return {mask.pixels, mask.corner.x, mask.corner.y, mask.size.x, mask.size.y, mask.runs.data(), mask.runs.size()};
}

sideray_object_truth public_truth(const sideray::rt::ObjectTruth& truth, uint32_t object, uint32_t samples_per_side) {
  const auto amodal = static_cast<double>(truth.amodal_samples);
  return {object, public_mask(truth.visible), public_mask(truth.amodal),
          amodal / (static_cast<double>(samples_per_side) * samples_per_side),
          truth.amodal_samples == 0 ? 0.0 : static_cast<double>(truth.visible_samples) / amodal};
}

sideray_object_truths* trace_truths(sideray_tracer& tracer, const sideray_object_truth_desc& desc) {
  const sideray_camera camera = read_truth_camera(desc.camera);
  const auto lock = tracer.take_turn_in_call();
  tracer.use(tracer.committed());
  const Snapshot& snapshot = *tracer.snapshot;
  const ObjectOfSurface objects = desc.surface_ids ? named_objects(desc) : all_surfaces(snapshot);
  if (desc.surface_ids) require_present(objects, snapshot);
  const std::vector<uint32_t> numbers = numbers_of(objects);
  ObjectTruthRequest request;
  request.view = trace_view(truth_view(camera, desc.width, desc.height, snapshot.origin));
  request.width = desc.width, request.height = desc.height;
  request.samples_per_side = desc.samples_per_side;
  request.hidden_by_opaque = desc.hidden_by == SIDERAY_HIDDEN_BY_OPAQUE;
  request.object_of = object_of_instances(snapshot, objects, numbers);
  request.objects = static_cast<uint32_t>(numbers.size());
  auto truths = std::make_unique<sideray_object_truths>();
  truths->traced = tracer.tracer.trace_objects(request);
  for (size_t i = 0; i < numbers.size(); ++i)
    truths->entries.push_back(public_truth(truths->traced[i], numbers[i], desc.samples_per_side));
  return truths.release();
}

}  // namespace

sideray_status sideray_camera_rays(const sideray_camera* camera, uint32_t width, uint32_t height, sideray_ray* rays,
                                   size_t stride_bytes, sideray_error* error) {
  return guarded(error, [&] {
    const sideray_camera read = read_truth_camera(camera);
    check_truth_size(width, height);
    require(rays, "rays");
    require_stride<sideray_ray>(stride_bytes, "rays");
    // Positions are relative to the eye, so that places far from the world's origin lose no precision.
    const glm::dvec3 eye(read.world_from_camera[9], read.world_from_camera[10], read.world_from_camera[11]);
    const sideray::rt::ViewRays view(trace_view(truth_view(read, width, height, eye)), width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const sideray::rt::Ray r = view.ray(x, height - 1 - y);
        const glm::dvec3 origin = glm::dvec3(r.origin) + eye;
        const sideray_ray ray{{origin.x, origin.y, origin.z}, {r.direction.x, r.direction.y, r.direction.z}, r.t_near,
                              r.t_far};
        sideray::bridge::write_element(rays, stride_bytes, size_t{y} * width + x, ray);
      }
  });
}

void sideray_object_truth_init(sideray_object_truth_desc* out, size_t size) {
  sideray_object_truth_desc desc{};
  desc.width = 1280;
  desc.height = 720;
  desc.samples_per_side = 4;
  init_struct(out, size, desc);
}

sideray_status sideray_object_truths_create(sideray_tracer* tracer, const sideray_object_truth_desc* desc,
                                            sideray_object_truths** truths, sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    require(truths, "object truths result");
    const sideray_object_truth_desc read = read_struct(desc, "object truth description", sideray_object_truth_init);
    check_desc(read);
    *truths = trace_truths(*tracer, read);
  });
}

size_t sideray_object_truths_count(const sideray_object_truths* truths) {
  return truths ? truths->entries.size() : 0;
}

const sideray_object_truth* sideray_object_truths_at(const sideray_object_truths* truths, size_t index) {
  return truths && index < truths->entries.size() ? &truths->entries[index] : nullptr;
}

void sideray_object_truths_release(sideray_object_truths* truths) {
  delete truths;
}
