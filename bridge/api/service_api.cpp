// sideray_service_*: the service in a host's own context.
#include <sideray/diagnostics.h>

#include <cmath>

#include "bridge/api/border.h"
#include "bridge/base/host_gl.h"
#include "bridge/base/local_view.h"
#include "bridge/api/snippet.h"
#include "bridge/base/public_stats.h"
#include "bridge/service/service.h"

using sideray::fail;
using sideray::bridge::FrameInputs;
using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::read_rate;
using sideray::bridge::read_struct;
using sideray::bridge::require;
using sideray::bridge::set_stats;
using sideray::bridge::write_struct;

struct sideray_service {
  sideray::bridge::Service service;
};

namespace {

// Fills a caller's struct of outputs, of which only the size is set.
template <typename Outputs>
sideray_status write_newest(sideray_service* service, uint32_t view_id, Outputs* outputs, const char* name,
                            bool (sideray::bridge::Service::*newest)(uint32_t, Outputs&) const) {
  require(service, "service");
  require(outputs, name);
  // Checks before the first outputs exist too, so that a host sees its mistake at once.
  sideray::bridge::require_size(outputs->size, sizeof(Outputs), name);
  Outputs filled{};
  if (!(service->service.*newest)(view_id, filled)) return SIDERAY_NOT_READY;
  write_struct(outputs, filled, name);
  return SIDERAY_OK;
}

FrameInputs read_frame_inputs(const sideray_frame_inputs* given) {
  const sideray_frame_inputs in = read_struct(given, "frame inputs", sideray_frame_init);
  FrameInputs read;
  read.view = in.view;
  read.source = in.source;
  read.shadows = in.shadows != 0;
  read.continues = in.continues != 0;
  read.seed = in.seed;
  // Hosts that average frames turn the seed with them, as the renderer turns its sample positions.
  read.inspection.position = in.seed;
  read.deadline_ms = in.deadline_ms;
  read.budget_ms = in.budget_ms;
  read.state_policy = in.state_policy;
  read.view_id = in.view_id;
  if (in.diagnostics) {
    const sideray_diagnostics diagnostics = read_struct(in.diagnostics, "diagnostics", sideray_diagnostics_init);
    read.exact_points = diagnostics.exact_points != 0;
    read.budget_pieces = diagnostics.budget_pieces;
  }
  if (in.layers) {
    read.layers = read_struct(in.layers, "layer inputs", sideray_layer_inputs_init);
    read.layers->cache_rate = read_rate(read.layers->cache_rate);
  }
  if (in.masks) read.masks = read_struct(in.masks, "mask inputs", sideray_mask_inputs_init);
  if (in.reflections)
    read.reflections = read_struct(in.reflections, "reflection inputs", sideray_reflection_inputs_init);
  if (in.irradiance) read.irradiance = read_struct(in.irradiance, "irradiance inputs", sideray_irradiance_inputs_init);
  return read;
}

}  // namespace

void sideray_frame_init(sideray_frame_inputs* out, size_t size) {
  sideray_frame_inputs in{};
  in.source.depth_texture_target = GL_TEXTURE_2D;
  in.source.mask = SIDERAY_MASK_COUNT;
  in.source.stencil_bits = 0x3f;
  in.shadows = 1;
  in.seed = 1;
  init_struct(out, size, in);
}

void sideray_layer_inputs_init(sideray_layer_inputs* out, size_t size) {
  init_struct(out, size, sideray::rt::default_layer_inputs());
}

void sideray_mask_inputs_init(sideray_mask_inputs* out, size_t size) {
  init_struct(out, size, sideray::rt::default_mask_inputs());
}

void sideray_reflection_inputs_init(sideray_reflection_inputs* out, size_t size) {
  sideray_reflection_inputs in{};
  in.denoise = 1;
  init_struct(out, size, in);
}

void sideray_irradiance_inputs_init(sideray_irradiance_inputs* out, size_t size) {
  sideray_irradiance_inputs in{};
  in.denoise = 1;
  init_struct(out, size, in);
}

sideray_status sideray_view_from_matrices(const double projection[16], const double modelview[16], sideray_view* view,
                                          sideray_error* error) {
  return guarded(error, [&] {
    require(projection, "projection");
    require(modelview, "modelview");
    require(view, "view");
    *view = sideray::bridge::view_of_matrices(projection, modelview);
  });
}

sideray_status sideray_service_create(sideray_tracer* tracer, const sideray_host_gl* host, sideray_service** service,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    const sideray_host_gl loader = sideray::bridge::read_host(host);
    require(service, "service result");
    *service = new sideray_service{{tracer, sideray::gl::load_functions(loader.get_proc_address, loader.user)}};
  });
}

void sideray_service_destroy(sideray_service* service) {
  delete service;
}

void sideray_service_abandon_context(sideray_service* service) {
  if (service) service->service.abandon_context();
}

sideray_status sideray_service_submit(sideray_service* service, const sideray_frame_inputs* inputs,
                                      sideray_ticket* ticket, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require(ticket, "ticket");
    const sideray_ticket issued = service->service.submit(read_frame_inputs(inputs));
    if (issued == 0) return SIDERAY_NOT_READY;
    *ticket = issued;
    return SIDERAY_OK;
  });
}

sideray_status sideray_service_advance(sideray_service* service, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    service->service.advance();
  });
}

sideray_status sideray_service_wait(sideray_service* service, sideray_ticket ticket, int32_t timeout_ms,
                                    sideray_error* error) {
  return sideray_service_wait_jobs(service, ticket, SIDERAY_JOB_ALL, timeout_ms, error);
}

sideray_status sideray_service_wait_jobs(sideray_service* service, sideray_ticket ticket, uint32_t jobs,
                                         int32_t timeout_ms, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    if ((jobs & ~uint32_t{SIDERAY_JOB_ALL}) != 0)
      fail(SIDERAY_INVALID_ARGUMENT, "jobs {:#x}: give SIDERAY_JOB_* alone", jobs);
    return service->service.wait(ticket, jobs, timeout_ms) ? SIDERAY_OK : SIDERAY_NOT_READY;
  });
}

sideray_status sideray_service_finished_jobs(sideray_service* service, sideray_ticket ticket, uint32_t* jobs,
                                             sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require(jobs, "jobs result");
    *jobs = service->service.finished_jobs(ticket);
  });
}

sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    service->service.cancel(ticket);
  });
}

sideray_status sideray_service_layers(sideray_service* service, uint32_t view_id, sideray_layer_outputs* outputs,
                                      sideray_error* error) {
  return guarded(error, [&] {
    return write_newest(service, view_id, outputs, "layer outputs", &sideray::bridge::Service::layers);
  });
}

sideray_status sideray_service_masks(sideray_service* service, uint32_t view_id, sideray_mask_outputs* outputs,
                                     sideray_error* error) {
  return guarded(error, [&] {
    return write_newest(service, view_id, outputs, "mask outputs", &sideray::bridge::Service::masks);
  });
}

sideray_status sideray_service_reflections(sideray_service* service, uint32_t view_id,
                                           sideray_reflection_outputs* outputs, sideray_error* error) {
  return guarded(error, [&] {
    return write_newest(service, view_id, outputs, "reflection outputs", &sideray::bridge::Service::reflections);
  });
}

sideray_status sideray_service_irradiance(sideray_service* service, uint32_t view_id, sideray_irradiance_outputs* outputs,
                                          sideray_error* error) {
  return guarded(error, [&] {
    return write_newest(service, view_id, outputs, "irradiance outputs", &sideray::bridge::Service::irradiance);
  });
}

sideray_status sideray_service_placement(sideray_service* service, uint32_t view_id, uint32_t job,
                                         sideray_instance instance, double world_from_object[12],
                                         sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require(world_from_object, "placement result");
    const std::optional<glm::dmat4x3> placement = service->service.placement(view_id, job, instance);
    if (!placement) return SIDERAY_NOT_READY;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) world_from_object[3 * column + row] = (*placement)[column][row];
    return SIDERAY_OK;
  });
}

sideray_status sideray_service_bind(sideray_service* service, uint32_t view_id, uint32_t program, uint32_t first_unit,
                                    sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    service->service.bind(view_id, program, first_unit, glm::dvec3(0));
  });
}

sideray_status sideray_service_stats(sideray_service* service, sideray_ticket ticket, sideray_frame_stats* stats,
                                     sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require(stats, "frame statistics");
    sideray_frame_stats filled{};
    set_stats(filled, service->service.stats(ticket));
    write_struct(stats, filled, "frame statistics");
  });
}

const char* sideray_glsl(int glsl_version) {
  return sideray::bridge::snippet_text(glsl_version);
}

const char* sideray_ready_vertex(sideray_ready_program program) {
  return sideray::bridge::ready_vertex(program);
}

const char* sideray_ready_fragment(sideray_ready_program program) {
  return sideray::bridge::ready_fragment(program);
}
