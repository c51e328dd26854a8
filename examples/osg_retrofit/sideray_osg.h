// Builds a Sideray scene from an OpenSceneGraph scene: code for the owner of such an engine to copy. Knows
// OpenSceneGraph and Sideray, calls no OpenGL. On the thread that updates the scene graph.
#pragma once

#include <osg/Geometry>
#include <osg/Light>
#include <osg/NodeVisitor>
#include <osg/StateSet>

#include <functional>
#include <map>
#include <set>
#include <sideray/sideray.hpp>
#include <vector>

namespace sideray_osg {

// Holds facts that the scene graph does not express.
struct Rules {
  // Lists the numbers of the lights whose shadows are traced. Other lights shine without shadows, as in the engine.
  std::set<int> shadow_lights = {0};
  // Changes the result for a state set before it becomes a material: how much its glass reflects, for example.
  std::function<void(const osg::StateSet&, sideray_material_desc&)> adjust;
};

// A blended drawable at one place in the graph.
struct Glass {
  osg::ref_ptr<osg::Drawable> drawable;
  osg::ref_ptr<osg::StateSet> blended;  // the state set that enables blending
  osg::ref_ptr<osg::Node> own;          // the lowest node used at no other place in the graph
  uint32_t surface_id;
};

// Holds the first light with traced shadows, in the engine's units.
struct Lighting {
  osg::Vec3 toward_sun, sun, ambient;
};

class SceneAdapter {
 public:
  // Reads all geometries below `root`, their state sets, and directional lights. Throws sideray::Error or
  // std::runtime_error for state that has no equivalent.
  SceneAdapter(osg::Node& root, const Rules& rules);

  // Updates the instances of nodes that moved since the last call, and commits if there are any. Returns their count.
  size_t update();

  const sideray::Scene& scene() const { return scene_; }
  const std::vector<Glass>& glass() const { return glass_; }
  const Lighting& lighting() const { return lighting_; }

 private:
  friend class Walk;
  struct Placed {
    sideray_instance instance;
    osg::NodePath path;
    osg::Matrixd world_from_object;
  };
  struct Lamp {
    osg::ref_ptr<const osg::Light> light;
    osg::Matrixd world_from_light;
  };

  sideray_mesh mesh_of(osg::Geometry& geometry);
  sideray_material material_of(const std::vector<osg::StateSet*>& states, const osg::StateSet& merged);
  sideray_texture texture_of(const osg::Image& image);
  sideray_texture_slot slot_of(const osg::StateSet& merged);
  void set_ambient(const osg::StateSet& merged, sideray_material_desc& desc);
  void place(osg::Geometry& geometry, const osg::NodePath& path, const std::vector<osg::StateSet*>& states);
  void add_glass(osg::Geometry& geometry, const osg::NodePath& path, const std::vector<osg::StateSet*>& states,
                 uint32_t surface_id);
  void set_lights(const std::vector<Lamp>& lamps, osg::Vec4 ambient);

  sideray::Scene scene_;
  Rules rules_;
  std::map<const osg::Geometry*, sideray_mesh> meshes_;
  std::map<std::vector<osg::StateSet*>, sideray_material> materials_;
  std::map<const osg::Image*, sideray_texture> textures_;
  sideray_texture black_ = 0;
  std::vector<Placed> placed_;
  std::vector<Glass> glass_;
  Lighting lighting_;
};

}  // namespace sideray_osg
