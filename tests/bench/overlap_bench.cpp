// Measures what the service costs a host whose drawing thread has its own processor: the host's frame without it, and
// with it one frame late, and the time of each call, under both state policies; for a GPU-bound and for a CPU-bound
// host. Glass covers a ninth of the picture.
//   bench_overlap [WIDTH HEIGHT [FRAMES]]
// The bound: a frame grows by at most the times of a readback and an upload that are waited for alone, plus 10 %. Run
// it again with __GL_THREADED_OPTIMIZATIONS=1 in the environment for a driver (NVIDIA's) that works in its own thread.
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Times {
  std::vector<double> ms;
  double quantile(double q) const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty() ? 0 : sorted[static_cast<size_t>(q * static_cast<double>(sorted.size() - 1))];
  }
  double mean() const {
    double sum = 0;
    for (const double v : ms) sum += v;
    return ms.empty() ? 0 : sum / static_cast<double>(ms.size());
  }
};

template <typename Body>
void timed(Times& times, const Body& body) {
  const Clock::time_point start = Clock::now();
  body();
  times.ms.push_back(ms_since(start));
}

// Makes a wall behind a pane of glass that covers the picture, and small plates that the glass reflects.
Scene make_scene() {
  Scene scene = Scene::create().value();
  constexpr float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  constexpr uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6;
  mesh.positions.data = positions, mesh.indices = indices;
  sideray_material_desc material = sideray_material_defaults();
  material.double_sided = 1;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  instance.visibility = SIDERAY_VISIBLE_ALL;
  const auto add = [&](double size, double x, double y, double z) {
    for (const int i : {0, 4, 8}) instance.world_from_object[i] = size;
    instance.world_from_object[9] = x, instance.world_from_object[10] = y, instance.world_from_object[11] = z;
    scene.add_instances({&instance, 1});
  };
  add(9.0, 0, 0, 0);
  for (int i = 0; i < 400; ++i) add(0.1, i % 20 - 9.5, i / 20 - 9.5, 3.5);
  material.alpha_mode = SIDERAY_BLEND;
  material.base_color[3] = 0.3f;
  instance.material = scene.add_material(material);
  instance.surface_id = 5;
  add(9.0, 0, 0, 1.0);
  sideray_light sun{};
  sun.size = sizeof(sun);
  sun.direction[0] = 0.4f, sun.direction[2] = -1.0f;
  for (float& c : sun.intensity) c = 1.0f;
  scene.set_lights({&sun, 1});
  scene.commit();
  return scene;
}

enum class Mode { off, saved, left };
constexpr const char* names[] = {"off", "late, state saved and restored", "late, the host restores"};

struct Result {
  Times frame, submit, advance, uploading, bind;  // uploading: calls of advance() that brought answers
  size_t frames = 0;
};

class Host {
 public:
  Host(int width, int height, bool waits_for_gpu) : width_(width), height_(height), draws_(waits_for_gpu ? 300 : 3000) {
    gl_.BindTexture(GL_TEXTURE_2D, color_.id());
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    gl_.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl_.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color_.id(), 0);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    const glm::dmat4 clip = glm::perspective(0.9, double(width) / height, 0.1, 50.0) *
                            glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -3));
    const glm::dmat4 world = glm::inverse(clip);
    sideray_view& view = in_.frame.view;
    std::memcpy(view.clip_from_world, glm::value_ptr(clip), sizeof(view.clip_from_world));
    std::memcpy(view.world_from_clip, glm::value_ptr(world), sizeof(view.world_from_clip));
    const glm::dvec4 wall = clip * glm::dvec4(0, 0, 0, 1);
    wall_depth_ = 0.5 + 0.5 * wall.z / wall.w;
    in_.frame.source.framebuffer = framebuffer_.id();
    in_.frame.source.width = width;
    in_.frame.source.height = height;
    in_.layers->max_layers = 1;
    if (waits_for_gpu) calibrate();
  }

  // Returns the median times of readback and upload of a frame that is waited for alone.
  std::pair<double, double> alone() {
    Times readback, upload;
    for (int i = 0; i < 12; ++i) {
      draw();
      gl_.Finish();
      const sideray_ticket ticket = service_.submit(in_).value();
      service_.wait(ticket);
      gl_.Finish();
      seen_ = ticket;
      const sideray_frame_stats stats = service_.stats(ticket);
      if (i > 1) readback.ms.push_back(stats.readback_ms), upload.ms.push_back(stats.upload_ms);
    }
    return {readback.quantile(0.5), upload.quantile(0.5)};
  }

  void frames(Mode mode, int count, Result& result) {
    in_.frame.state_policy = mode == Mode::left ? SIDERAY_HOST_RESTORES : SIDERAY_SAVE_AND_RESTORE;
    for (int i = 0; i < count; ++i) {
      const Clock::time_point start = Clock::now();
      draw();
      if (mode != Mode::off) serve(result);
      draw_glass();
      end_frame();
      if (i > 2) result.frame.ms.push_back(ms_since(start)), ++result.frames;
    }
    while (mode != Mode::off && in_flight_ > 0) service_.advance(), take_answers();
    gl_.Finish();
  }

  const std::string& renderer() const { return gl_.renderer; }

 private:
  // Submits this frame if fewer than two are in flight, and takes the answers of an earlier one if they are there.
  void serve(Result& result) {
    if (in_flight_ < 2) {
      timed(result.submit, [&] { service_.submit(in_); });
      ++in_flight_;
    }
    Times advance;
    timed(advance, [&] { service_.advance(); });
    (take_answers() ? result.uploading : result.advance).ms.push_back(advance.ms[0]);
    timed(result.bind, [&] { service_.bind(glass_.id(), 2); });
  }
  bool take_answers() {
    const auto newest = service_.layers();
    if (!newest || newest->ticket == seen_) return false;
    in_flight_ -= newest->ticket - seen_;
    seen_ = newest->ticket;
    return true;
  }

  // Draws as engines do: each pass sets all state that it needs.
  void draw() {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.Viewport(0, 0, width_, height_);
    gl_.Disable(GL_DEPTH_TEST), gl_.Disable(GL_BLEND), gl_.Disable(GL_STENCIL_TEST);
    gl_.DepthMask(GL_TRUE), gl_.StencilMask(0xff), gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl_.ClearDepth(wall_depth_);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl_.ClearStencil(0);
    gl_.Clear(GL_STENCIL_BUFFER_BIT);
    gl_.Enable(GL_SCISSOR_TEST), gl_.Scissor(width_ / 3, height_ / 3, width_ / 3, height_ / 3);
    gl_.ClearStencil(1);
    gl_.Clear(GL_STENCIL_BUFFER_BIT);
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.DepthMask(GL_FALSE);
    gl_.BindVertexArray(vertices_.id());
    gl_.UseProgram(opaque_.id());
    for (int i = 0; i <= draws_; ++i) {
      const float size = i == 0 ? 1.0f : 0.02f;
      gl_.Uniform4f(place_, i == 0 ? 0.0f : 1.8f * static_cast<float>(i) / static_cast<float>(draws_) - 0.9f, 0.0f,
                    size, size);
      gl_.Uniform1i(count_, i == 0 ? loops_ : 1);
      gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
  }
  void draw_glass() {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.BindVertexArray(vertices_.id());
    gl_.UseProgram(glass_.id());
    gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
  // Waits for the frame before, as two swapped buffers do.
  void end_frame() {
    gl::Fence fence(gl_);
    gl_.Flush();
    if (last_) last_.wait(1'000'000'000);
    last_ = std::move(fence);
  }
  // Chooses the number of loops with which drawing the picture takes about 4 ms.
  void calibrate() {
    for (loops_ = 8; loops_ < (1 << 20); loops_ *= 2) {
      Times times;
      for (int i = 0; i < 4; ++i) timed(times, [&] { draw(), gl_.Finish(); });
      if (times.quantile(0.0) > 4.0) return;
    }
  }
  static const char* vertex() {
    return "#version 330\nuniform vec4 place;\nvoid main() { vec2 c = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - "
           "1.0;\n  gl_Position = vec4(place.xy + c * place.zw, 0.0, 1.0); }\n";
  }

  struct Current {
    explicit Current(gl::Context& context) { context.make_current(); }
  };
  std::unique_ptr<gl::Context> context_ = gl::Context::create("auto", "");
  Current current_{*context_};
  const gl::Functions& gl_ = context_->functions();
  int width_, height_, draws_, loops_ = 1;
  sideray_ticket seen_ = 0;
  uint64_t in_flight_ = 0;
  double wall_depth_ = 1;
  gl::Texture color_{gl_};
  gl::Renderbuffer depth_{gl_};
  gl::Framebuffer framebuffer_{gl_};
  gl::VertexArray vertices_{gl_};
  gl::Program opaque_{gl_, "opaque", vertex(),
                      "#version 330\nuniform int loops;\nout vec4 c;\nvoid main() { vec2 z = vec2(0.0);\n"
                      "  for (int i = 0; i < loops; ++i) z = fract(z * 1.7 + sin(gl_FragCoord.xy * 0.01 + z.yx));\n"
                      "  c = vec4(z, 0.0, 1.0); }\n"};
  gl::Program glass_{gl_, "glass",
                     "#version 330\nout vec3 world;\nvoid main() { vec2 c = vec2(gl_VertexID & 1, gl_VertexID >> 1) * "
                     "2.0 - 1.0;\n  world = vec3(c, 1.0);\n  gl_Position = vec4(c, 0.0, 1.0); }\n",
                     std::string("#version 330\n") + sideray_glsl(330) +
                         "in vec3 world;\nout vec4 c;\nvoid main() { c = vec4(sideray_translucent(vec3(0.5), world, "
                         "5u), 1.0); }\n"};
  GLint place_ = gl_.GetUniformLocation(opaque_.id(), "place"), count_ = gl_.GetUniformLocation(opaque_.id(), "loops");
  gl::Fence last_;
  FrameInputs in_;
  Scene scene_ = make_scene();
  Tracer tracer_ = make_tracer(scene_);
  Service service_ =
      Service::create(tracer_, {sizeof(sideray_host_gl), gl::Context::get_proc_address, context_.get()}).value();

  // Makes a tracer that uses all processors but one.
  static Tracer make_tracer(const Scene& scene) {
    cpu_set_t set{};
    sched_getaffinity(0, sizeof(set), &set);
    sideray_tracer_desc desc = sideray_tracer_defaults();
    desc.threads = static_cast<uint32_t>(std::max(1, CPU_COUNT(&set) - 1));
    std::printf("%u tracing threads\n", desc.threads);
    return Tracer::create(scene, desc).value();
  }
};

void print(Mode mode, const Result& r) {
  std::printf("%-30s %6.2f %6.2f %6.2f %6.2f", names[static_cast<int>(mode)], r.frame.quantile(0.25),
              r.frame.quantile(0.5), r.frame.quantile(0.75), r.frame.mean());
  if (mode != Mode::off)
    std::printf("  %7.1f %7.1f %7.1f %7.1f   %5.2f", 1e3 * r.submit.quantile(0.5), 1e3 * r.advance.quantile(0.5),
                1e3 * r.uploading.quantile(0.5), 1e3 * r.bind.quantile(0.5),
                static_cast<double>(r.uploading.ms.size()) / static_cast<double>(r.frames));
  std::printf("\n");
}

void run(int width, int height, int count, bool waits_for_gpu) {
  Host host(width, height, waits_for_gpu);
  const auto [readback, upload] = host.alone();
  Result results[3];
  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round)
    for (const Mode mode : {Mode::off, Mode::saved, Mode::left})
      host.frames(mode, count / rounds, results[static_cast<int>(mode)]);
  std::printf("%s, %dx%d, a host that %s, %d frames each; alone: readback %.2f ms, upload %.2f ms\n",
              host.renderer().c_str(), width, height, waits_for_gpu ? "waits for its GPU" : "keeps its GPU waiting",
              count, readback, upload);
  std::printf("%-30s %27s  %31s  answers\n", "", "frame ms: 25 % 50 % 75 % mean", "us: submit advance uploading bind");
  for (const Mode mode : {Mode::off, Mode::saved, Mode::left}) print(mode, results[static_cast<int>(mode)]);
  const double off = results[0].frame.mean(), bound = readback + upload + 0.1 * off;
  for (const Mode mode : {Mode::saved, Mode::left}) {
    const double grown = results[static_cast<int>(mode)].frame.mean() - off;
    std::printf("%s: the mean frame grows by %.2f ms; bound %.2f: %s\n", names[static_cast<int>(mode)], grown, bound,
                grown <= bound ? "holds" : "FAILS");
  }
}

}  // namespace
}  // namespace sideray

int main(int argc, char** argv) {
  int numbers[] = {640, 360, 200};  // width, height, frames
  for (int i = 1; i < argc; ++i)
    if (i > 3 || (numbers[i - 1] = std::atoi(argv[i])) < 1) {
      std::fprintf(stderr, "usage: bench_overlap [WIDTH [HEIGHT [FRAMES]]]\n");
      return 2;
    }
  for (const bool waits_for_gpu : {true, false}) sideray::run(numbers[0], numbers[1], numbers[2], waits_for_gpu);
  return 0;
}
