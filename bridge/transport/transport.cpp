#include "bridge/transport/transport.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridge/transport/texture_upload.h"
#include "model/failure.h"
#include "model/stopwatch.h"

namespace sideray::bridge {
namespace {

// The first round of each way allocates, and times of the next two may still differ severalfold in drivers. The least
// time after the first round counts, since other work on the machine only makes a round slower.
constexpr int rounds = 5;
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

// Describes one way to move data, and its least time.
struct Way {
  const char* name;
  bool persistent;
  DepthPacker* packer = nullptr;
  double ms = std::numeric_limits<double>::max();
  bool is_right = true;  // gives the same bytes as the first way
};

const Way& fastest(std::span<const Way> ways) {
  return *std::min_element(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return std::pair(!a.is_right, a.ms) < std::pair(!b.is_right, b.ms);
  });
}

std::string told(std::span<const Way> ways) {
  std::string text;
  for (const Way& way : ways)
    text += fmt::format("{}{} {:.2f} ms{}", text.empty() ? "" : ", ", way.name, way.ms,
                        way.is_right ? "" : " but with other bits");
  return text;
}

// Measures from the issue of the copy to the last byte read, so that slowly readable memory counts.
void measure_readback(const gl::Functions& gl, const ReadbackRequest& request, std::span<Way> ways) {
  std::vector<Readback> readbacks(ways.size());
  std::vector<std::byte> bytes, first_bytes;
  bool fences_come = true;
  for (int round = 0; round < rounds; ++round)
    for (size_t i = 0; i < ways.size(); ++i) {
      Way& way = ways[i];
      Readback& readback = readbacks[i];
      const double ms = ms_of(gl, [&] {
        readback.start(gl, {request.source, request.policy, request.stencil, way.persistent, way.packer});
        readback.issue_fence(gl);
        fences_come = fences_come && readback.ready(second_ns);  // if not, map waits in another way
        const rt::DepthImage image = readback.map(gl);
        bytes.resize(image.row_bytes * static_cast<size_t>(request.source.height));  // a mask's bytes are elsewhere
        std::memcpy(bytes.data(), image.texels, bytes.size());
        readback.finish(gl);
      });
      if (round > 0) way.ms = std::min(way.ms, ms);
      if (i == 0) first_bytes = bytes;
      way.is_right = way.is_right && bytes == first_bytes && gl.GetError() == GL_NO_ERROR;
    }
}

void measure_upload(const gl::Functions& gl, const sideray_frame_source& source, rt::Executor& copiers,
                    std::span<Way> ways) {
  const auto width = static_cast<uint32_t>(source.width);
  const uint32_t height = std::clamp(most_upload_texels / width, 1u, static_cast<uint32_t>(source.height));
  const std::vector<std::byte> texels(size_t{width} * height * half4.bytes);
  const gl::Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGBA,
                GL_HALF_FLOAT, nullptr);
  const TexturePiece whole{GL_TEXTURE_2D, texture.id(), 0, half4, {0, 0, width, height}, texels.data(), width};
  std::vector<TextureUpload> uploads(ways.size());
  for (int round = 0; round < rounds; ++round)
    for (size_t i = 0; i < ways.size(); ++i) {
      const double ms = ms_of(gl, [&] { uploads[i].send(gl, {&whole, 1}, {ways[i].persistent, copiers}); });
      if (round > 0) ways[i].ms = std::min(ways[i].ms, ms);
    }
}

bool has_packed_depth(const gl::Functions& gl, const ReadbackRequest& request) {
  ReadTarget target;
  const ReadTarget::Bound bound = target.bind(gl, request.source, request.policy);
  return depth_stencil_format(gl, bound.framebuffer == 0).layout == rt::DepthFormat::d24s8;
}

// Returns null where there is nothing to pack, and where the context cannot pack or gives other depths than the driver.
std::unique_ptr<DepthPacker> exact_packer(const gl::Functions& gl, const ReadbackRequest& request) {
  if (!gl.compute || !has_packed_depth(gl, request)) return nullptr;
  try {
    auto packer = std::make_unique<DepthPacker>(gl);
    if (packer->is_exact()) return packer;
  } catch (const Failure&) {  // the driver cannot pack
  }
  return nullptr;
}

Transport fastest_transport(const gl::Functions& gl, const ReadbackRequest& request, rt::Executor& copiers,
                            bool reports) {
  std::unique_ptr<DepthPacker> packer = exact_packer(gl, request);
  std::vector<Way> readbacks{{"copied", false}, {"persistent", true}};
  if (packer) readbacks.push_back({"packed", true, packer.get()});
  Way uploads[] = {{"copied", false}, {"persistent", true}};
  measure_readback(gl, request, readbacks);
  measure_upload(gl, request.source, copiers, uploads);
  const Way &readback = fastest(readbacks), &upload = fastest(uploads);
  if (reports)
    fmt::print(stderr,
               "sideray: transport of {}x{}: readback {}, so {} is taken; upload of a layer's radiance {}, so {}\n",
               request.source.width, request.source.height, told(readbacks), readback.name, told(uploads), upload.name);
  if (!readback.packer) packer.reset();
  return {readback.persistent, upload.persistent, std::move(packer)};
}

}  // namespace

Transport choose_transport(const gl::Functions& gl, const ReadbackRequest& request, rt::Executor& copiers) {
  const char* pinned = std::getenv("SIDERAY_TRANSPORT");
  const std::string_view way = pinned ? pinned : "";
  if (!way.empty() && way != "copy" && way != "persistent" && way != "packed" && way != "report")
    fail(SIDERAY_INVALID_ARGUMENT,
         "SIDERAY_TRANSPORT: \"{}\" is no way to move bytes; set copy, persistent, packed or report", way);
  if ((way == "persistent" || way == "packed") && !gl.buffer_storage)
    fail(SIDERAY_UNSUPPORTED, "SIDERAY_TRANSPORT: {} has no buffers that stay mapped (OpenGL 4.4); unset it",
         gl.renderer);
  if (way == "packed" && !gl.compute)
    fail(SIDERAY_UNSUPPORTED, "SIDERAY_TRANSPORT: {} has no compute shaders (OpenGL 4.3); unset it", gl.renderer);
  if (way == "copy" || !gl.buffer_storage) return {};
  if (way == "persistent") return {true, true, nullptr};
  if (way == "packed") return {true, true, std::make_unique<DepthPacker>(gl)};
  return fastest_transport(gl, request, copiers, way == "report");
}

}  // namespace sideray::bridge
