// The scene that rays see, in eye space: what the program has drawn in this frame. Meshes, textures and materials stay from
// frame to frame by what they hold.
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

// A draw as the scene takes it.
struct SceneDraw {
  const Geometry* geometry = nullptr;
  uint64_t hash = 0;  // of the geometry
  const DrawState* state = nullptr;
  const Texture* textures[2] = {};  // of layers 0 and 1
  float tint[4] = {1, 1, 1, 1};
};

// The surface ids of what reflects; 0 = rays cannot hit it.
struct MirrorIds {
  uint32_t mirror = 0;  // what it reflects
  uint32_t bent = 0;    // what is seen through it, where it bends light
};

class TracedScene {
 public:
  TracedScene();
  // Empties the frame. Meshes, materials and textures that were not drawn for a while are dropped.
  void begin_frame();
  void add_opaque(const SceneDraw& draw);
  // A sheet of the sky, which is moved out to where it hides nothing.
  void add_sky(const SceneDraw& draw);
  // What reflects, as a rule says. Its ids are those that it had in the frame before.
  MirrorIds add_mirror(const SceneDraw& draw, const Rule& rule);
  // The light that casts shadows, in eye space; null = none. Where there has been one, draws cast shadows.
  void set_sun(const FixedLight* sun);
  void set_background(const std::array<float, 3>& color);
  // Frames that were submitted before keep what they had.
  void commit();

  const Tracer& tracer() const { return tracer_; }
  size_t instances() const { return wanted_.size(); }
  size_t meshes() const { return meshes_.size(); }
  const std::vector<sideray_instance_desc>& frame() const { return wanted_; }

 private:
  struct Mesh {
    sideray_mesh name = 0;
    uint64_t first_frame = 0, last_frame = 0;
    // Vertices that the program makes anew for each frame are not kept for long.
    bool is_old(uint64_t now) const { return now - last_frame > (last_frame > first_frame ? 60u : 2u); }
  };
  template <typename Name>
  struct Kept {
    Name name = 0;
    uint64_t last_frame = 0;
  };
  // What a surface is for rays.
  enum class Role { opaque, mirror, clear_mirror, bent, caster };
  struct MaterialKey {
    uint64_t textures[2] = {0, 0};
    Role role = Role::opaque;
    float value = 0;  // of opaque: the cutoff of alpha; of bent: the index of refraction; of caster: alpha
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
  std::vector<sideray_instance_desc> wanted_;  // of this frame
  std::vector<sideray_instance> held_;         // in the scene
};

}  // namespace sideray::run
