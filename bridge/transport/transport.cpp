#include "bridge/transport/transport.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "bridge/transport/texture_upload.h"
#include "model/failure.h"
#include "model/stopwatch.h"

namespace sideray::bridge {
namespace {

// The first round of each allocates; drivers' second and third still differ by a few times.
constexpr int rounds = 4;
constexpr uint64_t second_ns = 1'000'000'000;
constexpr uint32_t most_upload_texels = 1920 * 1088;

template <typename Body>
double ms_of(const gl::Functions& gl, const Body& body) {
  gl.Finish();
  const Stopwatch watch;
  body();
  gl.Finish();
  return watch.ms();
}

struct Best {
  double ms[2] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};  // copied, persistent
  void add(bool persistent, double value) { ms[persistent] = std::min(ms[persistent], value); }
  bool persistent() const { return ms[1] < ms[0]; }
};

// Measures from the issue of the copy to the last byte read: memory that is slow to read counts.
Best measure_readback(const gl::Functions& gl, const ReadbackRequest& request) {
  Best best;
  Readback ways[2];
  bool fences_come = true;
  std::vector<std::byte> bytes;
  for (int round = 0; round < rounds; ++round)
    for (const bool persistent : {false, true}) {
      Readback& readback = ways[persistent];
      const double ms = ms_of(gl, [&] {
        readback.start(gl, {request.source, request.policy, request.stencil, persistent});
        readback.issue_fence(gl);
        fences_come = fences_come && readback.ready(second_ns);  // otherwise map waits in another way
        const rt::DepthImage image = readback.map(gl);
        bytes.resize(image.row_bytes * static_cast<size_t>(request.source.height));  // a mask's bytes lie elsewhere
        std::memcpy(bytes.data(), image.texels, bytes.size());
        readback.finish(gl);
      });
      if (round > 0) best.add(persistent, ms);
    }
  return best;
}

Best measure_upload(const gl::Functions& gl, const sideray_frame_source& source, rt::Executor& copiers) {
  const auto width = static_cast<uint32_t>(source.width);
  const uint32_t height = std::clamp(most_upload_texels / width, 1u, static_cast<uint32_t>(source.height));
  const std::vector<std::byte> texels(size_t{width} * height * half4.source_bytes);
  const gl::Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGBA,
                GL_HALF_FLOAT, nullptr);
  const TexturePiece whole{GL_TEXTURE_2D, texture.id(), 0, half4, {0, 0, width, height}, texels.data(), width};
  Best best;
  TextureUpload ways[2];
  for (int round = 0; round < rounds; ++round)
    for (const bool persistent : {false, true}) {
      const double ms = ms_of(gl, [&] { ways[persistent].send(gl, {&whole, 1}, {persistent, copiers}); });
      if (round > 0) best.add(persistent, ms);
    }
  return best;
}

}  // namespace

Transport choose_transport(const gl::Functions& gl, const ReadbackRequest& request, rt::Executor& copiers) {
  const char* pinned = std::getenv("SIDERAY_TRANSPORT");
  const std::string_view way = pinned ? pinned : "";
  if (!way.empty() && way != "copy" && way != "persistent" && way != "report")
    fail(SIDERAY_INVALID_ARGUMENT, "SIDERAY_TRANSPORT: \"{}\" is no way to move bytes; set copy, persistent or report",
         way);
  if (way == "persistent" && !gl.buffer_storage)
    fail(SIDERAY_UNSUPPORTED, "SIDERAY_TRANSPORT: {} has no buffers that stay mapped (OpenGL 4.4); unset it",
         gl.renderer);
  if (way == "copy" || !gl.buffer_storage) return {};
  if (way == "persistent") return {true, true};
  const Best readback = measure_readback(gl, request), upload = measure_upload(gl, request.source, copiers);
  if (way == "report")
    fmt::print(stderr,
               "sideray: transport of {}x{}: readback copied {:.2f} ms, persistent {:.2f} ms; upload of a layer's "
               "radiance copied {:.2f} ms, persistent {:.2f} ms; the faster is taken\n",
               request.source.width, request.source.height, readback.ms[0], readback.ms[1], upload.ms[0], upload.ms[1]);
  return {readback.persistent(), upload.persistent()};
}

}  // namespace sideray::bridge
