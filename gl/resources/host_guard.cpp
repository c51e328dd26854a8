#include "gl/resources/host_guard.h"

#include <algorithm>

#include "model/failure.h"

namespace sideray::gl {
namespace {

// The rasterizer uses at most so many of a fragment shader's texture units.
constexpr uint32_t most_units = 32;
constexpr uint32_t uniform_points = 3;  // raster_programs.h: block
constexpr uint32_t storage_points = 2;

uint32_t get_name(const Functions& gl, GLenum name) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return static_cast<uint32_t>(value);
}

uint32_t used_units(const Functions& gl) {
  return std::min(static_cast<uint32_t>(std::max(gl.texture_units, 1)), most_units);
}

}  // namespace

RasterizationGuard::RasterizationGuard(const Functions& gl, uint32_t unit_count)
    : gl_(gl),
      cull_face_(get_name(gl, GL_CULL_FACE_MODE)),
      front_face_(get_name(gl, GL_FRONT_FACE)),
      provoking_vertex_(get_name(gl, GL_PROVOKING_VERTEX)),
      derivative_hint_(get_name(gl, GL_FRAGMENT_SHADER_DERIVATIVE_HINT)) {
  gl.GetFloatv(GL_POLYGON_OFFSET_FACTOR, &polygon_offset_[0]);
  gl.GetFloatv(GL_POLYGON_OFFSET_UNITS, &polygon_offset_[1]);
  if (gl.version >= 46) gl.GetFloatv(GL_POLYGON_OFFSET_CLAMP, &polygon_offset_[2]);
  depth_ranges_.resize(gl.viewport_arrays ? std::max(get_name(gl, GL_MAX_VIEWPORTS), 1u) : 1);
  if (gl.viewport_arrays)
    for (GLuint i = 0; i < depth_ranges_.size(); ++i) gl.GetDoublei_v(GL_DEPTH_RANGE, i, depth_ranges_[i].data());
  else
    gl.GetDoublev(GL_DEPTH_RANGE, depth_ranges_[0].data());
  if (gl.storage_buffers) {
    storage_.emplace(gl, storage_points);
    indirect_buffer_ = get_name(gl, GL_DRAW_INDIRECT_BUFFER_BINDING);
  }
  if (!gl.core_profile) save_level_biases(unit_count);
  gl.CullFace(GL_BACK);
  gl.FrontFace(GL_CCW);
  gl.ProvokingVertex(GL_LAST_VERTEX_CONVENTION);
  gl.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GL_DONT_CARE);
  gl.PolygonOffset(0, 0);
  // With one of these on, Mesa's llvmpipe draws filled triangles by another path: depths differ in their last bits.
  offsets_lines_ = gl.IsEnabled(GL_POLYGON_OFFSET_LINE) == GL_TRUE;
  offsets_points_ = gl.IsEnabled(GL_POLYGON_OFFSET_POINT) == GL_TRUE;
  gl.Disable(GL_POLYGON_OFFSET_LINE);
  gl.Disable(GL_POLYGON_OFFSET_POINT);
  gl.DepthRange(0, 1);
}

RasterizationGuard::~RasterizationGuard() {
  if (!gl_.core_profile) restore_level_biases();
  if (gl_.storage_buffers) {
    const bool exists = indirect_buffer_ != 0 && gl_.IsBuffer(indirect_buffer_) == GL_TRUE;
    gl_.BindBuffer(GL_DRAW_INDIRECT_BUFFER, exists ? indirect_buffer_ : 0);
  }
  gl_.CullFace(cull_face_);
  gl_.FrontFace(front_face_);
  gl_.ProvokingVertex(provoking_vertex_);
  gl_.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, derivative_hint_);
  if (offsets_lines_) gl_.Enable(GL_POLYGON_OFFSET_LINE);
  if (offsets_points_) gl_.Enable(GL_POLYGON_OFFSET_POINT);
  if (gl_.version >= 46)
    gl_.PolygonOffsetClamp(polygon_offset_[0], polygon_offset_[1], polygon_offset_[2]);
  else
    gl_.PolygonOffset(polygon_offset_[0], polygon_offset_[1]);
  if (gl_.viewport_arrays)
    for (GLuint i = 0; i < depth_ranges_.size(); ++i)
      gl_.DepthRangeIndexed(i, depth_ranges_[i][0], depth_ranges_[i][1]);
  else
    gl_.DepthRange(depth_ranges_[0][0], depth_ranges_[0][1]);
}

void RasterizationGuard::save_level_biases(uint32_t unit_count) {
  level_biases_.resize(unit_count);
  const uint32_t active = get_name(gl_, GL_ACTIVE_TEXTURE);
  for (uint32_t i = 0; i < unit_count; ++i) {
    gl_.ActiveTexture(GL_TEXTURE0 + i);
    gl_.GetTexEnvfv(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, &level_biases_[i]);
    gl_.TexEnvf(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, 0.0f);
  }
  gl_.ActiveTexture(active);
}

void RasterizationGuard::restore_level_biases() const {
  const uint32_t active = get_name(gl_, GL_ACTIVE_TEXTURE);
  for (uint32_t i = 0; i < level_biases_.size(); ++i) {
    gl_.ActiveTexture(GL_TEXTURE0 + i);
    gl_.TexEnvf(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, level_biases_[i]);
  }
  gl_.ActiveTexture(active);
}

HostGuard::HostGuard(const Functions& gl, uint32_t stencil_framebuffer)
    : errors_(gl),
      framebuffers_(gl),
      stencil_(gl, stencil_framebuffer),
      pixel_transfer_(gl),
      textures_(gl, 0, used_units(gl)),
      buffers_(gl, uniform_points),
      rasterization_(gl, used_units(gl)),
      draw_(gl),
      stencil_state_(gl) {
  gl.BindVertexArray(0);
}

void require_nothing_under_way(const Functions& gl) {
  struct Counted {
    GLenum target;
    const char* name;
    int version;
  };
  constexpr Counted queries[] = {{GL_SAMPLES_PASSED, "GL_SAMPLES_PASSED", 33},
                                 {GL_ANY_SAMPLES_PASSED, "GL_ANY_SAMPLES_PASSED", 33},
                                 {GL_ANY_SAMPLES_PASSED_CONSERVATIVE, "GL_ANY_SAMPLES_PASSED_CONSERVATIVE", 43},
                                 {GL_PRIMITIVES_GENERATED, "GL_PRIMITIVES_GENERATED", 33}};
  for (const Counted& query : queries) {
    if (gl.version < query.version) continue;
    GLint under_way = 0;
    gl.GetQueryiv(query.target, GL_CURRENT_QUERY, &under_way);
    if (under_way != 0)
      fail(SIDERAY_INVALID_ARGUMENT,
           "render: the host's query {} of {} is under way, and would count what is drawn here; end it first",
           under_way, query.name);
  }
  if (gl.version < 40) return;
  GLboolean feeds = GL_FALSE;
  GLboolean pauses = GL_FALSE;
  gl.GetBooleanv(GL_TRANSFORM_FEEDBACK_ACTIVE, &feeds);
  gl.GetBooleanv(GL_TRANSFORM_FEEDBACK_PAUSED, &pauses);
  if (feeds == GL_TRUE && pauses == GL_FALSE)
    fail(SIDERAY_INVALID_ARGUMENT, "render: the host's transform feedback is under way; end or pause it first");
}

}  // namespace sideray::gl
