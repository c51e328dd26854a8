// Holds the scene that rays hit, in eye space: the draws of this frame. Meshes, textures and materials are reused in
// later frames if their contents are the same.
#pragma once

#include <sideray/sideray.hpp>

#include <array>
#include <compare>
#include <map>
#include <vector>

#include "preload/base/rules.h"
#include "preload/capture/geometry.h"
#include "preload/capture/textures.h"
#include "preload/rays/looks.h"
#include "preload/rays/surface_names.h"

namespace sideray::run {

// Describes a draw for the scene.
struct SceneDraw {
  const Geometry* geometry = nullptr;
  uint64_t hash = 0;  // of the geometry
  const DrawState* state = nullptr;
  const Texture* textures[2] = {};  // of layers 0 and 1
  float tint[4] = {1, 1, 1, 1};
};

// Holds the surface ids of a reflector; 0 = rays cannot hit it.
struct MirrorIds {
  uint32_t mirror = 0;  // of the layer with its reflection
  uint32_t bent = 0;    // of the layer with what is seen through it, if it refracts
};

class TracedScene {
 public:
  TracedScene();
  // Removes the last frame's draws, and frees meshes, materials and textures that were not drawn for a while.
  void begin_frame();
  void add_opaque(const SceneDraw& draw);
  // Adds a surface of the sky, moved so far away that it hides nothing.
  void add_sky(const SceneDraw& draw);
  // Adds a reflecting surface with its rule. It keeps the ids of the previous frame.
  MirrorIds add_mirror(const SceneDraw& draw, const Rule& rule);
  // Sets the light that casts shadows, in eye space; null = none. Once there was one, draws cast shadows.
  void set_sun(const FixedLight* sun);
  void set_background(const std::array<float, 3>& color);
  // Commits the scene. Frames submitted earlier keep their own snapshot.
  void commit();

  const Tracer& tracer() const { return tracer_; }
  size_t instances() const { return wanted_.size(); }
  size_t meshes() const { return meshes_.size(); }
  const std::vector<sideray_instance_desc>& frame() const { return wanted_; }

 private:
  struct Mesh {
    sideray_mesh name = 0;
    uint64_t first_frame = 0, last_frame = 0;
    // Meshes of a single frame expire early, because a program may make their vertices anew for each frame.
    bool is_old(uint64_t now) const { return now - last_frame > (last_frame > first_frame ? 60u : 2u); }
  };
  template <typename Name>
  struct Kept {
    Name name = 0;
    uint64_t last_frame = 0;
  };
  // Says how rays treat a surface.
  enum class Role { opaque, mirror, clear_mirror, bent, caster };
  struct MaterialKey {
    uint64_t textures[2] = {0, 0};
    Role role = Role::opaque;
    float value = 0;  // opaque: alpha cutoff; bent: index of refraction; caster: alpha
    auto operator<=>(const MaterialKey&) const = default;
  };
  // `colored`: with the vertices' colours, if they count.
  bool place(const SceneDraw& draw, float scale, bool colored, sideray_instance_desc& instance);
  sideray_mesh mesh(const SceneDraw& draw, bool colored);
  sideray_texture texture(const Texture& texture);
  sideray_texture_slot slot(const Texture& texture);
  sideray_material opaque_material(const SceneDraw& draw);
  sideray_material material(const MaterialKey& key, const SceneDraw& draw);
  sideray_material_desc describe(const MaterialKey& key, const SceneDraw& draw);
  void add_caster(const SceneDraw& draw);
  void drop_old();
  void set_looks();

  Scene scene_;
  Tracer tracer_;
  Looks looks_;
  uint64_t frame_ = 0;
  SurfaceNames names_, bent_names_;
  int sheets_ = 0;
  FixedLight sun_{};
  bool has_sun_ = false;
  std::array<float, 3> background_ = {-1, -1, -1};
  std::map<uint64_t, Mesh> meshes_;
  std::map<uint64_t, Kept<sideray_texture>> textures_;
  std::map<MaterialKey, Kept<sideray_material>> materials_;
  std::vector<sideray_instance_desc> wanted_;  // instances of this frame
  std::vector<sideray_instance> held_;         // instances in the scene
};

}  // namespace sideray::run
