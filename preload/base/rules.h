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
  float ior = 1;          // of glass and water: 1 = what is behind is not bent
  float shade = -1;       // of what is opaque: the share of its colour that shadows leave; below 0 = as its lighting says
  bool guessed = false;   // no rule says so
};

// glass 0.04, water 0.02, mirror 0.3
float usual_reflectance(Kind kind);

// A rules file: one rule a line, `KIND texture HASH [OPTION=VALUE...]`, `KIND mesh HASH [OPTION=VALUE...]`, `KIND guessed
// [OPTION=VALUE...]` (of what is guessed to be glass) or `sun light N`; # begins a comment.
class Rules {
 public:
  Rules();
  // Throws std::runtime_error that names file, line, and what may stand there.
  static Rules read(const std::string& path);
  // A mesh's rule goes before its texture's. Kind::unknown where there is neither.
  Rule find(uint64_t texture, uint64_t mesh) const;
  bool has_meshes() const { return !meshes_.empty(); }
  // Of what looks like glass, and of which no rule says what it is.
  const Rule& guess() const { return guess_; }
  // The light that casts shadows: GL_LIGHT0 + sun(); below 0 = none.
  int sun() const { return sun_; }

 private:
  void add(const std::string& line, const std::string& where);
  void add_sun(const std::string& number, const std::string& where);
  std::map<uint64_t, Rule> textures_, meshes_;
  Rule guess_;
  int sun_ = -1;
};

}  // namespace sideray::run
