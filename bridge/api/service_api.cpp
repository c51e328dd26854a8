// sideray_service_*: the transport, for a host's own context.
#include <cmath>

#include "bridge/api/border.h"
#include "bridge/api/snippet.h"
#include "bridge/service/service.h"

using sideray::fail;
using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::require_struct;

struct sideray_service {
  sideray::bridge::Service service;
};

sideray_frame_inputs sideray_frame_defaults(void) {
  sideray_frame_inputs in{};
  in.size = sizeof(in);
  in.view.size = sizeof(in.view);
  in.depth_texture_target = GL_TEXTURE_2D;
  in.mask = SIDERAY_MASK_COUNT;
  in.stencil_bits = 0x3f;
  in.max_layers = 4;
  in.radiance_scale = 1.0f;
  in.shadows = 1;
  in.match_threshold = 0.001f;
  in.denoise = 1;
  in.inexact_bias = 0.5f;
  in.ao_distance = INFINITY;
  in.seed = 1;
  return in;
}

sideray_status sideray_service_create(sideray_tracer* tracer, const sideray_host_gl* host, sideray_service** service,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    require_struct(host, "host");
    require(service, "service result");
    if (!host->get_proc_address)
      fail(SIDERAY_INVALID_ARGUMENT, "host get_proc_address: NULL; give the context's loader");
    *service = new sideray_service{{tracer, sideray::gl::load_functions(host->get_proc_address, host->user)}};
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
    require_struct(inputs, "frame inputs");
    require(ticket, "ticket");
    const sideray_ticket issued = service->service.submit(*inputs);
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
  return guarded(error, [&] {
    require(service, "service");
    return service->service.wait(ticket, timeout_ms) ? SIDERAY_OK : SIDERAY_NOT_READY;
  });
}

sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    service->service.cancel(ticket);
  });
}

sideray_status sideray_service_latest_of(sideray_service* service, uint32_t view_id, sideray_frame_outputs* outputs,
                                         sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require_struct(outputs, "frame outputs");
    return service->service.latest(view_id, *outputs) ? SIDERAY_OK : SIDERAY_NOT_READY;
  });
}

sideray_status sideray_service_latest(sideray_service* service, sideray_frame_outputs* outputs, sideray_error* error) {
  return sideray_service_latest_of(service, 0, outputs, error);
}

sideray_status sideray_service_bind_view(sideray_service* service, uint32_t view_id, uint32_t program,
                                         uint32_t first_unit, sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    service->service.bind(view_id, program, first_unit, glm::dvec3(0));
  });
}

sideray_status sideray_service_bind(sideray_service* service, uint32_t program, uint32_t first_unit,
                                    sideray_error* error) {
  return sideray_service_bind_view(service, 0, program, first_unit, error);
}

sideray_status sideray_service_stats(sideray_service* service, sideray_ticket ticket, sideray_frame_stats* stats,
                                     sideray_error* error) {
  return guarded(error, [&] {
    require(service, "service");
    require_struct(stats, "frame statistics");
    *stats = service->service.stats(ticket);
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
