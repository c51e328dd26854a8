// What textures and meshes are taken for.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace sideray::run {

enum class Kind { unknown, opaque, glass, water, mirror, sky, ignore };

const char* kind_name(Kind kind);

struct Rule {
  Kind kind = Kind::unknown;
  float reflectance = 0;  // head on; it grows to 1 at grazing angles, but for mirrors
  bool guessed = false;   // no rule says so
};

// glass 0.04, water 0.02, mirror 0.3
float usual_reflectance(Kind kind);

// A rules file: one rule a line, `KIND texture HASH [reflectance=R]` or `KIND mesh HASH [reflectance=R]`; # begins a comment.
class Rules {
 public:
  Rules() = default;
  // Throws std::runtime_error that names file, line, and what may stand there.
  static Rules read(const std::string& path);
  // A mesh's rule goes before its texture's. Kind::unknown where there is neither.
  Rule find(uint64_t texture, uint64_t mesh) const;
  bool has_meshes() const { return !meshes_.empty(); }

 private:
  void add(const std::string& line, const std::string& where);
  std::map<uint64_t, Rule> textures_, meshes_;
};

}  // namespace sideray::run
