// Adds glass to MuJoCo's own picture: mjr_render draws opaque geoms, Sideray's rays draw the glass into the same
// offscreen framebuffer, and mjr_readPixels reads it. MuJoCo is unchanged and no shader is written: the fixed function
// blends the two. Headless, through EGL.
//
//   mujoco_glass MODEL.xml [-o after.png] [--before before.png] [--glass NAME] [--frames N] [--time SECONDS]
//
// Glass is any geom with a material whose name begins with "glass", and the geom or body called NAME.
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "glass_scene.h"

namespace {

struct Arguments {
  std::string model, after, before, glass;
  int frames = 1;
  double time_s = 0;
};

Arguments read_arguments(int count, char** values) {
  Arguments a;
  for (int i = 1; i < count; ++i) {
    const std::string name = values[i];
    const auto value = [&]() -> std::string {
      if (++i >= count) throw std::invalid_argument(name + ": a value is missing");
      return values[i];
    };
    if (name == "-o") a.after = value();
    else if (name == "--before") a.before = value();
    else if (name == "--glass") a.glass = value();
    else if (name == "--frames") a.frames = std::max(1, std::stoi(value()));
    else if (name == "--time") a.time_s = std::stod(value());
    else if (a.model.empty() && name[0] != '-') a.model = name;
    else throw std::invalid_argument(name + ": is no option; see the first lines of mujoco_glass.cpp");
  }
  if (a.model.empty()) throw std::invalid_argument("give a model, for example glassware.xml");
  return a;
}

void make_context() {
  const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  const auto devices_of = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  if (!get_display) throw std::runtime_error("EGL has no platforms");
  std::vector<EGLDisplay> displays{get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)};
  EGLDeviceEXT devices[8];
  EGLint count = 0;
  if (devices_of && devices_of(8, devices, &count))
    for (int i = 0; i < count; ++i) displays.push_back(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
  for (const EGLDisplay display : displays) {
    if (!display || !eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API)) continue;
    const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, nullptr);
    if (context && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) return;
  }
  throw std::runtime_error("EGL makes no context of OpenGL");
}

void* get_proc_address(void*, const char* name) {
  return reinterpret_cast<void*>(eglGetProcAddress(name));
}

using Matrix = std::array<double, 16>;

Matrix product(const float* a, const float* b) {
  Matrix m{};
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      for (size_t k = 0; k < 4; ++k) m[4 * column + row] += static_cast<double>(a[4 * k + row]) * static_cast<double>(b[4 * column + k]);
  return m;
}

// Uses Gauss-Jordan elimination with the largest pivot.
Matrix inverse(Matrix m) {
  Matrix out{};
  for (size_t i = 0; i < 4; ++i) out[5 * i] = 1;
  for (size_t i = 0; i < 4; ++i) {
    size_t pivot = i;
    for (size_t k = i + 1; k < 4; ++k)
      if (std::abs(m[4 * i + k]) > std::abs(m[4 * i + pivot])) pivot = k;
    const double scale = m[4 * i + pivot];
    for (size_t column = 0; column < 4; ++column) {
      std::swap(m[4 * column + i], m[4 * column + pivot]), std::swap(out[4 * column + i], out[4 * column + pivot]);
      m[4 * column + i] /= scale, out[4 * column + i] /= scale;
    }
    for (size_t row = 0; row < 4; ++row) {
      const double factor = m[4 * i + row];
      if (row == i) continue;
      for (size_t column = 0; column < 4; ++column)
        m[4 * column + row] -= factor * m[4 * column + i], out[4 * column + row] -= factor * out[4 * column + i];
    }
  }
  return out;
}

// Draws a picture of the rectangle's size over the framebuffer, by the fixed function.
void draw_over(GLuint texture, GLenum source, GLenum destination) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glBlendFunc(source, destination);
  glBegin(GL_QUADS);
  for (const auto& [x, y] : {std::array{0, 0}, std::array{1, 0}, std::array{1, 1}, std::array{0, 1}}) {
    glTexCoord2i(x, y);
    glVertex2i(2 * x - 1, 2 * y - 1);
  }
  glEnd();
}

// Computes picture = radiance + picture * transmittance. After a light with shadows mjr_render leaves another texture
// unit active, for which there are no texture coordinates here.
void composite(const sideray_layer_outputs& glass) {
  glPushAttrib(GL_ALL_ATTRIB_BITS);
  glActiveTexture(GL_TEXTURE0);
  for (const GLenum mode : {GL_TEXTURE, GL_PROJECTION, GL_MODELVIEW}) glMatrixMode(mode), glPushMatrix(), glLoadIdentity();
  for (const GLenum off : {GL_LIGHTING, GL_DEPTH_TEST, GL_CULL_FACE, GL_STENCIL_TEST, GL_FOG, GL_ALPHA_TEST, GL_SCISSOR_TEST,
                           GL_TEXTURE_GEN_S, GL_TEXTURE_GEN_T, GL_TEXTURE_CUBE_MAP})
    glDisable(off);
  glEnable(GL_TEXTURE_2D);
  glEnable(GL_BLEND);
  glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_REPLACE);
  draw_over(glass.distance_texture, GL_ZERO, GL_SRC_COLOR);
  draw_over(glass.radiance_texture, GL_ONE, GL_ONE);
  for (const GLenum mode : {GL_TEXTURE, GL_PROJECTION, GL_MODELVIEW}) glMatrixMode(mode), glPopMatrix();
  glPopAttrib();
}

class Clock {
 public:
  double ms() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

class Picture {
 public:
  Picture(const mjModel& model, const std::string& glass) : model_(model), also_(glass), scene_(model, glass) {
    mjv_defaultScene(&drawn_), mjr_defaultContext(&context_);
    mjv_makeScene(&model, &drawn_, 10000);
    mjr_makeContext(&model, &context_, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    if (context_.currentBuffer != mjFB_OFFSCREEN) throw std::runtime_error("MuJoCo has no offscreen framebuffer");
    size_ = {0, 0, context_.offWidth, context_.offHeight};
    mjv_defaultFreeCamera(&model, &camera_), mjv_defaultOption(&options_);
  }
  ~Picture() {
    service_.reset();
    mjr_freeContext(&context_), mjv_freeScene(&drawn_);
  }

  void draw_before(mjData& data) {
    mjv_updateScene(&model_, &data, &options_, nullptr, &camera_, mjCAT_ALL, &drawn_);
    mjr_render(size_, &drawn_, &context_);
  }

  // MuJoCo draws opaque geoms, rays draw glass.
  void draw_after(mjData& data) {
    mjv_updateScene(&model_, &data, &options_, nullptr, &camera_, mjCAT_ALL, &drawn_);
    scene_.update(drawn_);
    const auto all = drawn_.ngeom;
    const auto opaque = std::stable_partition(drawn_.geoms, drawn_.geoms + all,
                                              [&](const mjvGeom& g) { return !is_glass(model_, g, also_); });
    drawn_.ngeom = static_cast<int>(opaque - drawn_.geoms);
    mjr_render(size_, &drawn_, &context_);
    drawn_.ngeom = all;
    composite(trace());
  }

  std::vector<uint8_t> read() {
    std::vector<uint8_t> rgb(size_t{3} * static_cast<size_t>(size_.width) * static_cast<size_t>(size_.height));
    mjr_readPixels(rgb.data(), nullptr, size_, &context_);
    return rgb;
  }
  mjrRect size() const { return size_; }

 private:
  // Returns the camera, which mjr_render leaves in OpenGL's matrices.
  static sideray_view view() {
    float projection[16], model_view[16];
    glGetFloatv(GL_PROJECTION_MATRIX, projection), glGetFloatv(GL_MODELVIEW_MATRIX, model_view);
    const Matrix clip = product(projection, model_view), back = inverse(clip);
    sideray_view view{};
    std::copy(clip.begin(), clip.end(), view.clip_from_world), std::copy(back.begin(), back.end(), view.world_from_clip);
    return view;
  }

  sideray_layer_outputs trace() {
    if (!service_) {
      tracer_.emplace(sideray::Tracer::create(scene_.scene()).value());
      service_.emplace(sideray::Service::create(*tracer_, {sizeof(sideray_host_gl), get_proc_address, nullptr}).value());
    }
    sideray::FrameInputs in;
    in.frame.view = view();
    in.frame.source.framebuffer = context_.offFBO;
    in.frame.source.width = size_.width, in.frame.source.height = size_.height;
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.layers->mode = SIDERAY_COMPOSITE;
    in.layers->max_layers = 0;
    in.layers->refraction = 1;
    const sideray_frame_inputs frame = in.c();
    sideray_error error{};
    sideray_ticket ticket = 0;
    sideray_layer_outputs out{};
    out.size = sizeof(out);
    if (sideray_service_submit(service_->get(), &frame, &ticket, &error) != SIDERAY_OK ||
        sideray_service_wait(service_->get(), ticket, -1, &error) != SIDERAY_OK ||
        sideray_service_layers(service_->get(), 0, &out, &error) != SIDERAY_OK)
      throw std::runtime_error(error.message);
    return out;
  }

  const mjModel& model_;
  const std::string also_;
  GlassScene scene_;
  mjvScene drawn_;
  mjrContext context_;
  mjvCamera camera_;
  mjvOption options_;
  mjrRect size_{};
  std::optional<sideray::Tracer> tracer_;
  std::optional<sideray::Service> service_;
};

// Rows start at the bottom.
void write(const std::string& path, const Picture& picture, const std::vector<uint8_t>& rgb) {
  if (path.empty()) return;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.size().width), image.height = static_cast<png_uint_32>(picture.size().height);
  image.format = PNG_FORMAT_RGB;
  if (!png_image_write_to_file(&image, path.c_str(), 0, rgb.data(), -3 * picture.size().width, nullptr))
    throw std::runtime_error(path + ": " + image.message);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

int run(const Arguments& arguments) {
  make_context();
  char error[1000] = "";
  mjModel* const model = mj_loadXML(arguments.model.c_str(), nullptr, error, sizeof(error));
  if (!model) throw std::runtime_error(error);
  mjData* const data = mj_makeData(model);
  mj_forward(model, data);
  while (data->time < arguments.time_s) mj_step(model, data);
  {
    Picture picture(*model, arguments.glass);
    std::vector<double> before, after;
    std::vector<uint8_t> pictures[2];
    // mjr_render of 2.2.2 lights the first picture of a context differently from all others.
    picture.draw_before(*data);
    picture.read();
    Clock clock;
    for (int i = 0; i < arguments.frames; ++i) {
      clock.ms();
      picture.draw_before(*data);
      pictures[0] = picture.read();
      before.push_back(clock.ms());
      picture.draw_after(*data);
      pictures[1] = picture.read();
      after.push_back(clock.ms());
      mj_step(model, data);
    }
    if (const GLenum left = glGetError(); left != GL_NO_ERROR) throw std::runtime_error("OpenGL error " + std::to_string(left));
    size_t changed = 0;
    for (size_t i = 0; i < pictures[0].size(); i += 3) changed += !std::equal(&pictures[0][i], &pictures[0][i] + 3, &pictures[1][i]);
    write(arguments.before, picture, pictures[0]);
    write(arguments.after, picture, pictures[1]);
    std::printf("%dx%d, %d frames: MuJoCo %.1f ms, with glass by rays %.1f ms; %zu of %zu pixels differ\n", picture.size().width,
                picture.size().height, arguments.frames, median(before), median(after), changed, pictures[0].size() / 3);
  }
  mj_deleteData(data), mj_deleteModel(model);
  return 0;
}

}  // namespace

int main(int count, char** values) {
  try {
    return run(read_arguments(count, values));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mujoco_glass: %s\n", e.what());
    return 1;
  }
}
