// Says which kind of material textures and meshes stand for.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace sideray::run {

enum class Kind { unknown, opaque, glass, water, mirror, sky, ignore };

const char* kind_name(Kind kind);

struct Rule {
  Kind kind = Kind::unknown;
  float reflectance = 0;  // at normal incidence; grows to 1 at grazing angles, except for mirrors
  float ior = 1;          // of glass and water: 1 = refraction is off
  float shade = -1;       // of opaque surfaces: share of their colour that shadows leave; below 0 = by their lighting
  bool guessed = false;   // no rule says so
};

// Returns 0.04 for glass, 0.02 for water, 0.3 for mirrors.
float usual_reflectance(Kind kind);

// Holds a rules file with one rule a line: `KIND texture HASH [OPTION=VALUE...]`, `KIND mesh HASH [OPTION=VALUE...]`,
// `KIND guessed [OPTION=VALUE...]` (for surfaces that look like glass) or `sun light N`; # begins a comment.
class Rules {
 public:
  Rules();
  // Throws std::runtime_error that names the file, the line, and what is allowed there.
  static Rules read(const std::string& path);
  // Returns the mesh's rule, or else the texture's; Kind::unknown if there is neither.
  Rule find(uint64_t texture, uint64_t mesh) const;
  bool has_meshes() const { return !meshes_.empty(); }
  // Returns the rule for surfaces that look like glass and have no rule of their own.
  const Rule& guess() const { return guess_; }
  // Returns the light that casts shadows: GL_LIGHT0 + sun(); below 0 = none.
  int sun() const { return sun_; }

 private:
  void add(const std::string& line, const std::string& where);
  void add_sun(const std::string& number, const std::string& where);
  std::map<uint64_t, Rule> textures_, meshes_;
  Rule guess_;
  int sun_ = -1;
};

}  // namespace sideray::run
