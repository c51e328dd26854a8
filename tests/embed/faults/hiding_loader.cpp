#include "embed/faults/hiding_loader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>

namespace sideray::tests {
namespace {

using G = GladGLContext;
HidingLoader* current = nullptr;
gl::Functions real;

struct Constant {
  const char* name;
  int64_t value;
  std::vector<std::string> providers;
};

const std::vector<Constant>& newer_constants() {
  static const std::vector<Constant> constants{
      {"SAMPLER_BINDING", GL_SAMPLER_BINDING, {"VERSION_3_3", "ARB_sampler_objects"}},
      {"VERTEX_ARRAY_BINDING", GL_VERTEX_ARRAY_BINDING, {"VERSION_3_0", "ARB_vertex_array_object"}},
      {"READ_FRAMEBUFFER", GL_READ_FRAMEBUFFER, {"VERSION_3_0", "ARB_framebuffer_object", "EXT_framebuffer_blit"}},
      {"DRAW_FRAMEBUFFER", GL_DRAW_FRAMEBUFFER, {"VERSION_3_0", "ARB_framebuffer_object", "EXT_framebuffer_blit"}},
      {"READ_FRAMEBUFFER_BINDING",
       GL_READ_FRAMEBUFFER_BINDING,
       {"VERSION_3_0", "ARB_framebuffer_object", "EXT_framebuffer_blit"}},
      {"DEPTH_STENCIL_ATTACHMENT", GL_DEPTH_STENCIL_ATTACHMENT, {"VERSION_3_0", "ARB_framebuffer_object"}},
      {"ATTACHMENT_DEPTH_SIZE", GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE, {"VERSION_3_0", "ARB_framebuffer_object"}},
      {"ATTACHMENT_STENCIL_SIZE", GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE, {"VERSION_3_0", "ARB_framebuffer_object"}},
      {"ATTACHMENT_COMPONENT_TYPE",
       GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE,
       {"VERSION_3_0", "ARB_framebuffer_object"}},
      {"COPY_READ_BUFFER", GL_COPY_READ_BUFFER, {"VERSION_3_1", "ARB_copy_buffer"}},
      {"COPY_WRITE_BUFFER", GL_COPY_WRITE_BUFFER, {"VERSION_3_1", "ARB_copy_buffer"}},
      {"UNIFORM_BUFFER", GL_UNIFORM_BUFFER, {"VERSION_3_1", "ARB_uniform_buffer_object"}},
      {"UNIFORM_BUFFER_BINDING", GL_UNIFORM_BUFFER_BINDING, {"VERSION_3_1", "ARB_uniform_buffer_object"}},
      {"CLAMP_READ_COLOR", GL_CLAMP_READ_COLOR, {"VERSION_3_0", "ARB_color_buffer_float"}},
      {"CLIP_ORIGIN", GL_CLIP_ORIGIN, {"VERSION_4_5", "ARB_clip_control"}},
      {"CLIP_DEPTH_MODE", GL_CLIP_DEPTH_MODE, {"VERSION_4_5", "ARB_clip_control"}},
      {"MAX_VIEWPORTS", GL_MAX_VIEWPORTS, {"VERSION_4_1", "ARB_viewport_array"}},
      {"CONTEXT_PROFILE_MASK", GL_CONTEXT_PROFILE_MASK, {"VERSION_3_2"}},
      {"CONTEXT_FLAGS", GL_CONTEXT_FLAGS, {"VERSION_3_0", "KHR_debug"}},
      {"MAJOR_VERSION", GL_MAJOR_VERSION, {"VERSION_3_0"}},
      {"MINOR_VERSION", GL_MINOR_VERSION, {"VERSION_3_0"}},
      {"NUM_EXTENSIONS", GL_NUM_EXTENSIONS, {"VERSION_3_0"}},
      {"TEXTURE_2D_ARRAY", GL_TEXTURE_2D_ARRAY, {"VERSION_3_0", "EXT_texture_array"}},
      {"TEXTURE_BINDING_2D_ARRAY", GL_TEXTURE_BINDING_2D_ARRAY, {"VERSION_3_0", "EXT_texture_array"}},
      {"DEPTH_CLAMP", GL_DEPTH_CLAMP, {"VERSION_3_2", "ARB_depth_clamp"}},
      {"FRAMEBUFFER_SRGB", GL_FRAMEBUFFER_SRGB, {"VERSION_3_0", "ARB_framebuffer_sRGB", "EXT_framebuffer_sRGB"}},
      {"SAMPLE_MASK", GL_SAMPLE_MASK, {"VERSION_3_2", "ARB_texture_multisample"}},
      {"PRIMITIVE_RESTART", GL_PRIMITIVE_RESTART, {"VERSION_3_1"}},
      {"RASTERIZER_DISCARD", GL_RASTERIZER_DISCARD, {"VERSION_3_0"}},
      {"SAMPLE_SHADING", GL_SAMPLE_SHADING, {"VERSION_4_0", "ARB_sample_shading"}},
      {"PRIMITIVE_RESTART_FIXED_INDEX", GL_PRIMITIVE_RESTART_FIXED_INDEX, {"VERSION_4_3", "ARB_ES3_compatibility"}},
      {"CLIP_DISTANCE6", GL_CLIP_DISTANCE6, {"VERSION_3_0"}},
      {"CLIP_DISTANCE7", GL_CLIP_DISTANCE7, {"VERSION_3_0"}},
      {"ANY_SAMPLES_PASSED", GL_ANY_SAMPLES_PASSED, {"VERSION_3_3", "ARB_occlusion_query2"}},
      {"R32UI", GL_R32UI, {"VERSION_3_0", "EXT_texture_integer"}},
      {"R32F", GL_R32F, {"VERSION_3_0", "ARB_texture_rg"}},
      {"R8", GL_R8, {"VERSION_3_0", "ARB_texture_rg"}},
      {"RG", GL_RG, {"VERSION_3_0", "ARB_texture_rg"}},
      {"RGBA16F", GL_RGBA16F, {"VERSION_3_0", "ARB_texture_float"}},
      {"HALF_FLOAT", GL_HALF_FLOAT, {"VERSION_3_0", "ARB_half_float_pixel"}},
  };
  return constants;
}

void hidden_function() {
  if (current) ADD_FAILURE() << "a hidden function was called";
}

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

}  // namespace

// Wraps functions to record hidden values.
struct Watch {
  static void see(GLenum value) { current->see(value); }
  static void see(GLint value) { current->see(value); }
  template <typename Other>
  static void see(const Other&) {}

  template <auto Entry>
  struct Function;
  template <typename Result, typename... Arguments, Result (*GladGLContext::*Entry)(Arguments...)>
  struct Function<Entry> {
    static Result call(Arguments... arguments) {
      (see(arguments), ...);
      return (real.*Entry)(arguments...);
    }
  };
  template <auto Entry>
  static void* function() {
    return reinterpret_cast<void*>(&Function<Entry>::call);
  }

  static const GLubyte* get_string(GLenum name) {
    const auto* loader = current;
    const std::string* own = name == GL_VERSION                    ? &loader->version_
                             : name == GL_SHADING_LANGUAGE_VERSION ? &loader->glsl_
                             : name == GL_EXTENSIONS               ? &loader->all_extensions_
                                                                   : nullptr;
    return own ? reinterpret_cast<const GLubyte*>(own->c_str()) : real.GetString(name);
  }
  static const GLubyte* get_stringi(GLenum name, GLuint index) {
    if (name != GL_EXTENSIONS) return real.GetStringi(name, index);
    return reinterpret_cast<const GLubyte*>(std::next(current->extensions_.begin(), index)->c_str());
  }
  static void get_integer(GLenum name, GLint* value) {
    see(name);
    if (name == GL_MAJOR_VERSION)
      *value = current->driver_.version / 10;
    else if (name == GL_MINOR_VERSION)
      *value = current->driver_.version % 10;
    else if (name == GL_NUM_EXTENSIONS)
      *value = static_cast<GLint>(current->extensions_.size());
    else
      real.GetIntegerv(name, value);
  }

  static void get_query_object(GLuint query, GLenum name, GLuint* value) {
    if (name == GL_QUERY_RESULT_AVAILABLE && current->queries_held_)
      *value = GL_FALSE;
    else
      real.GetQueryObjectuiv(query, name, value);
  }

  // Returns the wrapper of a function, null for the real one.
  static void* over(const std::string& name) {
    static const std::map<std::string, void*> functions{
        {"glGetString", reinterpret_cast<void*>(&get_string)},
        {"glGetStringi", reinterpret_cast<void*>(&get_stringi)},
        {"glGetIntegerv", reinterpret_cast<void*>(&get_integer)},
        {"glGetQueryObjectuiv", reinterpret_cast<void*>(&get_query_object)},
        {"glGetBooleanv", function<&G::GetBooleanv>()},
        {"glGetFloatv", function<&G::GetFloatv>()},
        {"glGetInteger64v", function<&G::GetInteger64v>()},
        {"glGetQueryiv", function<&G::GetQueryiv>()},
        {"glIsEnabled", function<&G::IsEnabled>()},
        {"glEnable", function<&G::Enable>()},
        {"glDisable", function<&G::Disable>()},
        {"glBindBuffer", function<&G::BindBuffer>()},
        {"glBindTexture", function<&G::BindTexture>()},
        {"glBindFramebuffer", function<&G::BindFramebuffer>()},
        {"glBindFramebufferEXT", function<&G::BindFramebufferEXT>()},
        {"glCheckFramebufferStatus", function<&G::CheckFramebufferStatus>()},
        {"glCheckFramebufferStatusEXT", function<&G::CheckFramebufferStatusEXT>()},
        {"glFramebufferRenderbuffer", function<&G::FramebufferRenderbuffer>()},
        {"glFramebufferRenderbufferEXT", function<&G::FramebufferRenderbufferEXT>()},
        {"glFramebufferTexture2D", function<&G::FramebufferTexture2D>()},
        {"glFramebufferTexture2DEXT", function<&G::FramebufferTexture2DEXT>()},
        {"glGetFramebufferAttachmentParameteriv", function<&G::GetFramebufferAttachmentParameteriv>()},
        {"glGetFramebufferAttachmentParameterivEXT", function<&G::GetFramebufferAttachmentParameterivEXT>()},
        {"glTexImage2D", function<&G::TexImage2D>()},
        {"glTexImage3D", function<&G::TexImage3D>()},
        {"glTexSubImage2D", function<&G::TexSubImage2D>()},
        {"glTexSubImage3D", function<&G::TexSubImage3D>()},
        {"glReadPixels", function<&G::ReadPixels>()},
        {"glTexParameteri", function<&G::TexParameteri>()}};
    const auto found = functions.find(name);
    return found == functions.end() ? nullptr : found->second;
  }
};

HidingLoader::HidingLoader(gl::Context& context, const Driver& driver) : context_(context), driver_(driver) {
  real = context.functions();
  current = this;
  for (const std::string& name : driver.extensions)
    if (!driver.all_but) extensions_.insert("GL_" + name);
  GLint count = 0;
  real.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLuint i = 0; driver.all_but && i < static_cast<GLuint>(count); ++i) {
    const std::string name = reinterpret_cast<const char*>(real.GetStringi(GL_EXTENSIONS, i));
    if (!contains(driver.extensions, name.substr(3))) extensions_.insert(name);
  }
  extensions_.insert("GL_EXT_bgra");  // none has no extension
  for (const std::string& name : extensions_) all_extensions_ += name + " ";
  const int major = driver.version / 10, minor = driver.version % 10;
  version_ = fmt::format("{}.{} of a test", major, minor);
  constexpr int glsl_of_3[] = {130, 140, 150, 330};
  const int glsl = driver.version < 21    ? 110
                   : driver.version == 21 ? 120
                   : major == 3           ? glsl_of_3[minor]
                                          : 10 * driver.version;
  glsl_ = fmt::format("{}.{:02}", glsl / 100, glsl % 100);
  read_providers();
}

HidingLoader::~HidingLoader() {
  current = nullptr;
}

// Reads the version and the extensions that have each function, from glad's loader.
void HidingLoader::read_providers() {
  std::ifstream source(SIDERAY_BINARY_DIR "/gl/glad/src/gl.c");
  ASSERT_TRUE(source) << "glad's loader is not where it is generated";
  const std::regex group("static void glad_gl_load_GL_(\\w+)\\("), function("load\\(userptr, \"(\\w+)\"\\)");
  std::string provider;
  std::smatch match;
  for (std::string line; std::getline(source, line);) {
    if (line.find("glad_gl_load_GL_") == std::string::npos && line.find("load(userptr") == std::string::npos) continue;
    if (std::regex_search(line, match, group)) provider = match[1];
    if (std::regex_search(line, match, function)) providers_[match[1]].push_back(provider);
  }
  ASSERT_GT(providers_.size(), 700u);
}

bool HidingLoader::has(const std::string& provider) const {
  if (provider.rfind("VERSION_", 0) == 0) return 10 * (provider[8] - '0') + provider[10] - '0' <= driver_.version;
  return extensions_.count("GL_" + provider) != 0;
}

bool HidingLoader::is_hidden(const std::string& name) const {
  const auto found = providers_.find(name);
  if (found == providers_.end()) return true;
  return std::none_of(found->second.begin(), found->second.end(), [&](const std::string& p) { return has(p); });
}

void HidingLoader::see(int64_t value) {
  for (const Constant& constant : newer_constants()) {
    if (constant.value != value) continue;
    const bool there = std::any_of(constant.providers.begin(), constant.providers.end(),
                                   [&](const std::string& provider) { return has(provider); });
    if (!there) used_.insert(constant.name);
  }
}

void* HidingLoader::get_proc_address(void* loader, const char* name) {
  const auto* self = static_cast<const HidingLoader*>(loader);
  if (contains(self->driver_.null_functions, name)) return nullptr;
  // Not null, as in drivers.
  if (self->is_hidden(name)) return reinterpret_cast<void*>(&hidden_function);
  void* over = Watch::over(name);
  return over ? over : gl::Context::get_proc_address(&self->context_, name);
}

}  // namespace sideray::tests
