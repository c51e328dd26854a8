// Makes a Sideray scene of an OpenSceneGraph scene, for owners of such engines to copy. Knows OpenSceneGraph and
// Sideray, calls no OpenGL. Call it on the thread that updates the scene graph.
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

// Holds properties that the scene graph lacks.
struct Rules {
  // Numbers of the lights whose shadows are traced. Other lights have no shadows, as in the engine.
  std::set<int> shadow_lights = {0};
  // Changes the description made from a state set before it becomes a material, for example the reflectance of glass.
  std::function<void(const osg::StateSet&, sideray_material_desc&)> adjust;
};

// Holds one occurrence of a blended drawable in the graph.
struct Glass {
  osg::ref_ptr<osg::Drawable> drawable;
  osg::ref_ptr<osg::StateSet> blended;  // the state set that turns blending on
  osg::ref_ptr<osg::Node> own;          // the lowest node with a single parent path
  uint32_t surface_id;
};

// Holds the first light whose shadows are traced, in the engine's values.
struct Lighting {
  osg::Vec3 toward_sun, sun, ambient;
};

class SceneAdapter {
 public:
  // Reads the geometries, state sets and directional lights under `root`. Throws sideray::Error or std::runtime_error
  // for what it cannot convert.
  SceneAdapter(osg::Node& root, const Rules& rules);

  // Moves the instances of nodes that have moved, and commits if there are any. Returns the number of moved instances.
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
