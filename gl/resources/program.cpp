#include "gl/resources/program.h"

#include <fmt/format.h>

#include <cstdlib>
#include <glm/gtc/type_ptr.hpp>

#include "model/failure.h"
#include "shaders/sources.h"

namespace sideray::gl {
namespace {

constexpr std::string_view source_marker = "// source ";
constexpr int log_lines = 6;

// Numbers the next line 1: "#line n" gives it the number n from GLSL 3.30 on, n + 1 before.
std::string line_directive(int version, size_t source) {
  return fmt::format("#line {} {}\n", version >= 330 ? 1 : 0, source);
}

std::string insert_defines(const std::string& text, const std::vector<std::string>& defines) {
  if (defines.empty()) return text;
  const size_t end_of_version = text.find('\n');
  std::string block;
  for (const std::string& define : defines) block += "#define " + define + "\n";
  if (text.compare(0, 8, "#version") != 0 || end_of_version == std::string::npos) return block + text;
  return text.substr(0, end_of_version + 1) + block + text.substr(end_of_version + 1);
}

// Returns "1 = shading.h, 2 = light.glsl": the numbers that the driver's log uses for files.
std::string source_legend(const std::string& text) {
  std::string legend;
  for (size_t at = text.find(source_marker); at != std::string::npos; at = text.find(source_marker, at + 1)) {
    if (at != 0 && text[at - 1] != '\n') continue;
    const size_t begin = at + source_marker.size();
    if (!legend.empty()) legend += ", ";
    legend += text.substr(begin, text.find('\n', begin) - begin);
  }
  return legend;
}

// Returns the first lines of a log in one line.
std::string first_lines(const std::string& log) {
  std::string line;
  int count = 0;
  for (const char c : log) {
    if (c == '\0') break;
    if (c != '\n' && c != '\r') {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      if (++count == log_lines) break;
      line += "; ";
    }
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == ';')) line.pop_back();
  return line.empty() ? "the driver gave no reason" : line;
}

struct Shader {
  Shader(const Functions& functions, GLenum type) : gl(functions), id(functions.CreateShader(type)) {}
  ~Shader() { gl.DeleteShader(id); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  const Functions& gl;
  GLuint id;
};

void compile(const Shader& shader, const std::string& program, const char* stage, const std::string& text) {
  const Functions& gl = shader.gl;
  const GLchar* start = text.c_str();
  const GLint size = static_cast<GLint>(text.size());
  gl.ShaderSource(shader.id, 1, &start, &size);
  gl.CompileShader(shader.id);
  GLint compiled = 0;
  gl.GetShaderiv(shader.id, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return;
  GLint log_size = 0;
  gl.GetShaderiv(shader.id, GL_INFO_LOG_LENGTH, &log_size);
  std::string log(static_cast<size_t>(log_size) + 1, '\0');
  gl.GetShaderInfoLog(shader.id, log_size, nullptr, log.data());
  const std::string legend = source_legend(text);
  fail(SIDERAY_GL_FAILED, "program \"{}\": its {} shader does not compile: {}{}", program, stage, first_lines(log),
       legend.empty() ? "" : " (source " + legend + ")");
}

void link(const Functions& gl, GLuint id, const std::string& program) {
  gl.LinkProgram(id);
  GLint linked = 0;
  gl.GetProgramiv(id, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  GLint log_size = 0;
  gl.GetProgramiv(id, GL_INFO_LOG_LENGTH, &log_size);
  std::string log(static_cast<size_t>(log_size) + 1, '\0');
  gl.GetProgramInfoLog(id, log_size, nullptr, log.data());
  fail(SIDERAY_GL_FAILED, "program \"{}\" does not link: {}", program, first_lines(log));
}

}  // namespace

std::string_view shading_prelude() {
  return "#define real float\n"
         "#define real2 vec2\n"
         "#define real3 vec3\n"
         "#define real4 vec4\n"
         "#define one_real float\n"
         "#define one_real3 vec3\n"
         "#define integer int\n"
         "#define boolean bool\n"
         "#define SR_FN\n"
         "#define sr_select(c, a, b) ((c) ? (a) : (b))\n"
         "#define sr_any(c) (c)\n"
         "#define sr_atan2(y, x) atan(y, x)\n";
}

std::string assemble_shader(const ShaderSpec& spec) {
  const int version = std::atoi(spec.version.c_str());
  std::string text = "#version " + spec.version + "\n";
  for (const std::string& define : spec.defines) text += "#define " + define + "\n";
  text += shading_prelude();
  size_t number = 0;
  for (const std::string& file : spec.files) {
    const std::string_view content = shaders::source(file);
    if (content.empty())
      fail(SIDERAY_INTERNAL, "shader file \"{}\": not among the embedded ones; add it to shaders/ and build again",
           file);
    ++number;
    text += fmt::format("{}{} = {}\n", source_marker, number, file);
    text += line_directive(version, number);
    text += content;
    if (text.back() != '\n') text += '\n';
  }
  return text;
}

Program::Program(const Functions& gl, std::string name, const std::string& vertex_text,
                 const std::string& fragment_text, const std::vector<std::string>& defines)
    : gl_(&gl), object_(gl), name_(std::move(name)) {
  const Shader vertex(gl, GL_VERTEX_SHADER), fragment(gl, GL_FRAGMENT_SHADER);
  compile(vertex, name_, "vertex", insert_defines(vertex_text, defines));
  compile(fragment, name_, "fragment", insert_defines(fragment_text, defines));
  gl.AttachShader(id(), vertex.id);
  gl.AttachShader(id(), fragment.id);
  link(gl, id(), name_);
  gl.DetachShader(id(), vertex.id);
  gl.DetachShader(id(), fragment.id);
}

Program::Program(const Functions& gl, std::string name, const ShaderSpec& vertex, const ShaderSpec& fragment)
    : Program(gl, std::move(name), assemble_shader(vertex), assemble_shader(fragment)) {}

Program::Program(const Functions& gl, std::string name, const ShaderSpec& compute)
    : gl_(&gl), object_(gl), name_(std::move(name)) {
  const Shader shader(gl, GL_COMPUTE_SHADER);
  compile(shader, name_, "compute", assemble_shader(compute));
  gl.AttachShader(id(), shader.id);
  link(gl, id(), name_);
  gl.DetachShader(id(), shader.id);
}

void Program::use() const {
  gl_->UseProgram(id());
}

int Program::uniform(std::string_view uniform_name) const {
  const auto found = locations_.find(uniform_name);
  if (found != locations_.end()) return found->second;
  std::string key(uniform_name);
  const int location = gl_->GetUniformLocation(id(), key.c_str());
  locations_.emplace(std::move(key), location);
  return location;
}

void Program::set(std::string_view uniform_name, int value) const {
  gl_->Uniform1i(uniform(uniform_name), value);
}
void Program::set(std::string_view uniform_name, std::span<const int> values) const {
  gl_->Uniform1iv(uniform(uniform_name), static_cast<GLsizei>(values.size()), values.data());
}
void Program::set(std::string_view uniform_name, uint32_t value) const {
  gl_->Uniform1ui(uniform(uniform_name), value);
}
void Program::set(std::string_view uniform_name, float value) const {
  gl_->Uniform1f(uniform(uniform_name), value);
}
void Program::set(std::string_view uniform_name, const glm::vec2& value) const {
  gl_->Uniform2fv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::vec3& value) const {
  gl_->Uniform3fv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::vec4& value) const {
  gl_->Uniform4fv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::ivec2& value) const {
  gl_->Uniform2iv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::ivec3& value) const {
  gl_->Uniform3iv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::ivec4& value) const {
  gl_->Uniform4iv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::uvec2& value) const {
  gl_->Uniform2uiv(uniform(uniform_name), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::mat3& value) const {
  gl_->UniformMatrix3fv(uniform(uniform_name), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::set(std::string_view uniform_name, const glm::mat4& value) const {
  gl_->UniformMatrix4fv(uniform(uniform_name), 1, GL_FALSE, glm::value_ptr(value));
}

void Program::set_block(std::string_view block_name, uint32_t binding) const {
  const std::string zero_terminated(block_name);
  const GLuint index = gl_->GetUniformBlockIndex(id(), zero_terminated.c_str());
  if (index != GL_INVALID_INDEX) gl_->UniformBlockBinding(id(), index, binding);
}

}  // namespace sideray::gl
