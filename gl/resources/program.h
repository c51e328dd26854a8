// Puts shader texts together from the embedded files (shaders/sources.h), and links programs made of them. Any thread
// may call assemble_shader; a Program's calls need its context current on the calling thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"

namespace sideray::gl {

// Lists the parts of a shader, in this order: #version, defines, the GLSL side of shading.h's dialect, the files.
struct ShaderSpec {
  std::vector<std::string> files;    // names in shaders/, for example {"shading.h", "light.frag.glsl"}
  std::vector<std::string> defines;  // "NAME" or "NAME value"
  std::string version = "330 core";
};

// Assembles a shader. Each file starts with a #line directive, whose source number identifies it in the driver's
// messages. Throws Failure (INTERNAL) where a file does not exist.
std::string assemble_shader(const ShaderSpec& spec);

// Returns the macros that let shading.h compile as GLSL; every assembled text contains them.
std::string_view shading_prelude();

class Program {
 public:
  Program() = default;  // empty
  // Texts start with #version; `defines` follow that line in both. Throws Failure (GL_FAILED) with the program's name
  // and the first lines of the driver's log.
  Program(const Functions& gl, std::string name, const std::string& vertex_text, const std::string& fragment_text,
          const std::vector<std::string>& defines = {});
  Program(const Functions& gl, std::string name, const ShaderSpec& vertex, const ShaderSpec& fragment);
  // Links a compute shader.
  Program(const Functions& gl, std::string name, const ShaderSpec& compute);

  uint32_t id() const { return object_.id(); }
  const std::string& name() const { return name_; }
  explicit operator bool() const { return static_cast<bool>(object_); }
  void use() const;
  void abandon() { object_.abandon(); }

  // Returns -1 where the program has no such active uniform.
  int uniform(std::string_view uniform_name) const;

  // Set a uniform of the program, which must be in use. A name that is not active is ignored.
  void set(std::string_view uniform_name, int value) const;
  void set(std::string_view uniform_name, std::span<const int> values) const;
  void set(std::string_view uniform_name, uint32_t value) const;
  void set(std::string_view uniform_name, float value) const;
  void set(std::string_view uniform_name, const glm::vec2& value) const;
  void set(std::string_view uniform_name, const glm::vec3& value) const;
  void set(std::string_view uniform_name, const glm::vec4& value) const;
  void set(std::string_view uniform_name, const glm::ivec2& value) const;
  void set(std::string_view uniform_name, const glm::ivec3& value) const;
  void set(std::string_view uniform_name, const glm::ivec4& value) const;
  void set(std::string_view uniform_name, const glm::uvec2& value) const;
  void set(std::string_view uniform_name, const glm::mat3& value) const;
  void set(std::string_view uniform_name, const glm::mat4& value) const;

  // Connects a uniform block to a binding point; ignored where it is not active.
  void set_block(std::string_view block_name, uint32_t binding) const;

 private:
  const Functions* gl_ = nullptr;
  ProgramObject object_;
  std::string name_;
  mutable std::map<std::string, int, std::less<>> locations_;
};

}  // namespace sideray::gl
