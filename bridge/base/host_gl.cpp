#include "bridge/base/host_gl.h"

#include "bridge/base/versions.h"

namespace sideray::bridge {
namespace {

void init_host(sideray_host_gl* out, size_t size) {
  init_struct(out, size, sideray_host_gl{});
}

}  // namespace

sideray_host_gl read_host(const sideray_host_gl* given) {
  const sideray_host_gl host = read_struct(given, "host", init_host);
  if (!host.get_proc_address)
    fail(SIDERAY_INVALID_ARGUMENT, "host get_proc_address: NULL; give the context's loader");
  return host;
}

}  // namespace sideray::bridge
