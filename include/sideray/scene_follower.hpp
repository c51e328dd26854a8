// Makes a Sideray scene follow an engine's scene graph: each frame the engine names everything that it has by its own
// keys, and things that it no longer names are removed. C++17, header-only; contracts are those of sideray.h. One
// thread, as with a Scene.
//
//   follower.begin();
//   for (Node& node : engine) {
//     const sideray_mesh mesh = follower.mesh(key_of(node.mesh), node.mesh.version, node.mesh.pose, [&] { return desc; });
//     ...
//     follower.instance(key_of(node), instance);
//   }
//   follower.end();   // removes, and commits where something has changed
#pragma once

#include <sideray/sideray.hpp>

#include <array>
#include <cstring>
#include <unordered_map>

namespace sideray {

class SceneFollower {
 public:
  // A key of the engine's own: an address, an index, a hash. Two things of one kind never share a key.
  using Key = uint64_t;

  struct Texels {
    uint32_t width, height;
    sideray_texel_format format;
    const void* rgba;  // as in Scene::add_texture()
  };
  struct Material {
    sideray_material_desc desc = sideray_material_defaults();
    std::optional<sideray_fixed_material> fixed;
  };

  // The caller keeps the scene alive, and adds to it no textures, materials, meshes or instances directly.
  explicit SceneFollower(Scene& scene) : scene_(scene) {}

  void begin() { ++round_; }

  // The next three return the object's name. `fill` is called if the object is new or its version has changed; the data
  // that its result points to is read at once.
  template <typename Fill>
  sideray_texture texture(Key key, uint64_t version, const Fill& fill) {
    const auto add = [&] {
      const Texels t = fill();
      return scene_.add_texture(t.width, t.height, t.format, t.rgba);
    };
    const auto replace = [&](sideray_texture name) {
      const Texels t = fill();
      scene_.replace_texture(name, t.width, t.height, t.format, t.rgba);
    };
    return follow(textures_, key, version, add, replace);
  }
  template <typename Fill>
  sideray_material material(Key key, uint64_t version, const Fill& fill) {
    const auto set_fixed = [&](sideray_material name, const Material& m) {
      if (m.fixed) scene_.set_fixed_material(name, *m.fixed);
      return name;
    };
    const auto add = [&] {
      const Material m = fill();
      return set_fixed(scene_.add_material(m.desc), m);
    };
    const auto replace = [&](sideray_material name) {
      const Material m = fill();
      scene_.replace_material(name, m.desc);
      set_fixed(name, m);
    };
    return follow(materials_, key, version, add, replace);
  }
  // `fill` returns a sideray_mesh_desc. If only `pose` has changed, vertices have moved but triangles have not.
  template <typename Fill>
  sideray_mesh mesh(Key key, uint64_t version, uint64_t pose, const Fill& fill) {
    const sideray_mesh name = follow(
        meshes_, key, version, [&] { return scene_.add_mesh(fill()); },
        [&](sideray_mesh replaced) { scene_.replace_mesh(replaced, fill()); });
    Pose& last = poses_[key];
    if (last.of == changes_of(meshes_, key) && last.pose != pose) {
      scene_.set_vertices(name, fill());
      changed_ = true;
    }
    last = {changes_of(meshes_, key), pose};
    return name;
  }
  // Sets the matrix and everything else that has changed. `desc` must be zeroed before it is filled, because its bytes
  // are compared.
  sideray_instance instance(Key key, const sideray_instance_desc& desc) {
    Instance& known = instances_[key];
    if (known.round == 0) {
      known.name = scene_.add_instances({&desc, 1}).front();
      changed_ = true;
    } else if (differs_in_more_than_place(known.desc, desc)) {
      scene_.replace_instances({&known.name, 1}, {&desc, 1});
      changed_ = true;
    } else if (!std::equal(desc.world_from_object, desc.world_from_object + 12, known.desc.world_from_object)) {
      scene_.move_instance(known.name, desc.world_from_object);
      changed_ = true;
    }
    known.desc = desc;
    known.round = round_;
    return known.name;
  }
  // Makes end() commit because of other changes: lights, the environment.
  void commit_at_end() { changed_ = true; }

  // Removes everything that was not named since begin(), and commits if anything has changed. Returns whether it did.
  bool end() {
    sweep(instances_, [&](Key, const Instance& i) { scene_.remove_instances({&i.name, 1}); });
    sweep(materials_, [&](Key, const Thing& t) { scene_.remove_material(t.name); });
    sweep(textures_, [&](Key, const Thing& t) { scene_.remove_texture(t.name); });
    sweep(meshes_, [&](Key key, const Thing& t) {
      scene_.remove_mesh(t.name);
      poses_.erase(key);
    });
    const bool changed = changed_;
    if (changed) scene_.commit();
    changed_ = false;
    return changed;
  }

 private:
  struct Thing {
    uint32_t name = 0;
    uint64_t version = 0, round = 0, changes = 0;
  };
  struct Instance {
    sideray_instance name = 0;
    uint64_t round = 0;
    sideray_instance_desc desc{};
  };
  struct Pose {
    uint64_t of = 0, pose = 0;  // number of times that the mesh was replaced
  };
  using Things = std::unordered_map<Key, Thing>;

  template <typename Add, typename Replace>
  uint32_t follow(Things& things, Key key, uint64_t version, const Add& add, const Replace& replace) {
    Thing& thing = things[key];
    const bool is_new = thing.changes == 0;
    if (is_new || thing.version != version) {
      if (is_new)
        thing.name = add();
      else
        replace(thing.name);
      thing.version = version;
      ++thing.changes;
      changed_ = true;
    }
    thing.round = round_;
    return thing.name;
  }
  static uint64_t changes_of(const Things& things, Key key) { return things.at(key).changes; }

  static bool differs_in_more_than_place(sideray_instance_desc a, const sideray_instance_desc& b) {
    std::copy_n(b.world_from_object, 12, a.world_from_object);
    return std::memcmp(&a, &b, sizeof(a)) != 0;
  }

  template <typename Map, typename Remove>
  void sweep(Map& things, const Remove& remove) {
    for (auto at = things.begin(); at != things.end();) {
      if (at->second.round == round_) {
        ++at;
        continue;
      }
      remove(at->first, at->second);
      at = things.erase(at);
      changed_ = true;
    }
  }

  Scene& scene_;
  uint64_t round_ = 0;
  bool changed_ = true;  // an empty scene must be committed too
  Things textures_, materials_, meshes_;
  std::unordered_map<Key, Pose> poses_;
  std::unordered_map<Key, Instance> instances_;
};

}  // namespace sideray
