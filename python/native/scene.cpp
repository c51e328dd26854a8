// Provides sideray_scene with arrays.
#include <sideray/plan.h>

#include <array>

#include "python/native/structs.h"

namespace sideray::python {
namespace {

// Holds the attributes of a mesh until it is copied.
struct MeshArrays {
  Array<float> positions;
  std::optional<Array<uint32_t>> indices;
  std::optional<Array<float>> normals, tangents, uv0, uv1, colors;

  static sideray_attribute attribute(const std::optional<Array<float>>& array, py::ssize_t vertices, py::ssize_t width,
                                     const char* what) {
    if (!array) return {};
    require_shape(*array, {vertices, width}, what);
    return {array->data(), 0};
  }

  sideray_mesh_desc desc() const {
    require_shape(positions, {-1, 3}, "positions");
    const py::ssize_t vertices = positions.shape(0);
    sideray_mesh_desc desc = sideray_mesh_defaults();
    desc.vertex_count = static_cast<uint32_t>(vertices);
    desc.positions = {positions.data(), 0};
    if (indices) {
      require_shape(*indices, {-1, 3}, "triangles");
      desc.index_count = static_cast<uint32_t>(indices->size());
      desc.indices = indices->data();
    }
    desc.normals = attribute(normals, vertices, 3, "normals");
    desc.tangents = attribute(tangents, vertices, 4, "tangents");
    desc.uv0 = attribute(uv0, vertices, 2, "uv");
    desc.uv1 = attribute(uv1, vertices, 2, "uv1");
    desc.colors = attribute(colors, vertices, 4, "colors");
    return desc;
  }
};

void define_mesh_arrays(py::module_& module) {
  py::class_<MeshArrays>(module, "MeshArrays")
      .def(py::init([](Array<float> positions, std::optional<Array<uint32_t>> indices,
                       std::optional<Array<float>> normals, std::optional<Array<float>> tangents,
                       std::optional<Array<float>> uv0, std::optional<Array<float>> uv1,
                       std::optional<Array<float>> colors) {
             return MeshArrays{std::move(positions), std::move(indices), std::move(normals), std::move(tangents),
                               std::move(uv0), std::move(uv1), std::move(colors)};
           }),
           py::arg("positions"), py::arg("indices"), py::arg("normals"), py::arg("tangents"), py::arg("uv0"),
           py::arg("uv1"), py::arg("colors"));
}

py::tuple add_mesh(SceneHandle& s, const MeshArrays& arrays) {
  const sideray_mesh_desc desc = arrays.desc();
  sideray_mesh mesh = 0;
  uint32_t dropped = 0;
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_add_mesh(s.scene.get(), &desc, &mesh, &dropped, e); });
  return py::make_tuple(mesh, dropped);
}

uint32_t replace_mesh(SceneHandle& s, sideray_mesh mesh, const MeshArrays& arrays) {
  const sideray_mesh_desc desc = arrays.desc();
  uint32_t dropped = 0;
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_replace_mesh(s.scene.get(), mesh, &desc, &dropped, e); });
  return dropped;
}

void set_vertices(SceneHandle& s, sideray_mesh mesh, const MeshArrays& arrays) {
  const sideray_mesh_desc desc = arrays.desc();
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_set_vertices(s.scene.get(), mesh, &desc, e); });
}

sideray_texture add_texture(SceneHandle& s, const Array<uint8_t>& texels, bool srgb) {
  require_shape(texels, {-1, -1, 4}, "texels");
  sideray_texture texture = 0;
  const auto height = static_cast<uint32_t>(texels.shape(0)), width = static_cast<uint32_t>(texels.shape(1));
  const void* data = texels.data();
  const sideray_texel_format format = srgb ? SIDERAY_RGBA8_SRGB : SIDERAY_RGBA8;
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_add_texture(s.scene.get(), width, height, format, data, &texture, e);
  });
  return texture;
}

void replace_texture(SceneHandle& s, sideray_texture texture, const Array<uint8_t>& texels, bool srgb) {
  require_shape(texels, {-1, -1, 4}, "texels");
  const auto height = static_cast<uint32_t>(texels.shape(0)), width = static_cast<uint32_t>(texels.shape(1));
  const void* data = texels.data();
  const sideray_texel_format format = srgb ? SIDERAY_RGBA8_SRGB : SIDERAY_RGBA8;
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_replace_texture(s.scene.get(), texture, width, height, format, data, e);
  });
}

sideray_material add_material(SceneHandle& s, const py::dict& fields) {
  const sideray_material_desc desc = material_of(fields);
  sideray_material material = 0;
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_add_material(s.scene.get(), &desc, &material, e); });
  return material;
}

void replace_material(SceneHandle& s, sideray_material material, const py::dict& fields) {
  const sideray_material_desc desc = material_of(fields);
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_replace_material(s.scene.get(), material, &desc, e); });
}

// Holds instances: each array has one entry for each.
struct InstanceArrays {
  Array<uint32_t> meshes, materials, surface_ids, visibility;
  Array<double> transforms;

  std::vector<sideray_instance_desc> descs() const {
    require_shape(meshes, {-1}, "meshes");
    const py::ssize_t count = meshes.shape(0);
    require_shape(materials, {count}, "materials");
    require_shape(surface_ids, {count}, "surface ids");
    require_shape(visibility, {count}, "visibility");
    require_shape(transforms, {count, 12}, "transforms");
    std::vector<sideray_instance_desc> descs(static_cast<size_t>(count));
    for (size_t i = 0; i < descs.size(); ++i) {
      descs[i].mesh = meshes.data()[i];
      descs[i].material = materials.data()[i];
      descs[i].surface_id = surface_ids.data()[i];
      descs[i].visibility = visibility.data()[i];
      std::copy_n(transforms.data() + 12 * i, 12, descs[i].world_from_object);
    }
    return descs;
  }
};

Array<uint32_t> add_instances(SceneHandle& s, const Array<uint32_t>& meshes, const Array<uint32_t>& materials,
                              const Array<double>& transforms, const Array<uint32_t>& surface_ids,
                              const Array<uint32_t>& visibility) {
  const std::vector<sideray_instance_desc> descs =
      InstanceArrays{meshes, materials, surface_ids, visibility, transforms}.descs();
  Array<uint32_t> names(static_cast<py::ssize_t>(descs.size()));
  uint32_t* written = names.mutable_data();
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_add_instances(s.scene.get(), descs.data(), sizeof(sideray_instance_desc), descs.size(),
                                       written, e);
  });
  return names;
}

void replace_instances(SceneHandle& s, const Array<uint32_t>& names, const Array<uint32_t>& meshes,
                       const Array<uint32_t>& materials, const Array<double>& transforms,
                       const Array<uint32_t>& surface_ids, const Array<uint32_t>& visibility) {
  const std::vector<sideray_instance_desc> descs =
      InstanceArrays{meshes, materials, surface_ids, visibility, transforms}.descs();
  require_shape(names, {static_cast<py::ssize_t>(descs.size())}, "instances");
  const uint32_t* given = names.data();
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_replace_instances(s.scene.get(), given, descs.data(), sizeof(sideray_instance_desc),
                                           descs.size(), e);
  });
}

void remove_instances(SceneHandle& s, const Array<uint32_t>& names) {
  require_shape(names, {-1}, "instances");
  const uint32_t* given = names.data();
  const auto count = static_cast<size_t>(names.size());
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_remove_instances(s.scene.get(), given, count, e); });
}

void move_instances(SceneHandle& s, const Array<uint32_t>& names, const Array<double>& transforms) {
  require_shape(names, {-1}, "instances");
  require_shape(transforms, {names.shape(0), 12}, "transforms");
  const uint32_t* given = names.data();
  const double* placed = transforms.data();
  const auto count = static_cast<size_t>(names.size());
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_move_instances(s.scene.get(), given, count, placed, e); });
}

void set_visibility(SceneHandle& s, sideray_instance instance, uint32_t visibility) {
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_set_visibility(s.scene.get(), instance, visibility, e); });
}

sideray_particles add_particles(SceneHandle& s, const py::dict& fields) {
  const sideray_particles_desc desc = particles_of(fields);
  sideray_particles particles = 0;
  call(s.mutex, [&](sideray_error* e) { return sideray_scene_add_particles(s.scene.get(), &desc, &particles, e); });
  return particles;
}

void set_sprites(SceneHandle& s, sideray_particles particles, const Array<double>& positions, const Array<float>& sizes,
                 const Array<float>& colors, const Array<float>& rotations, const Array<float>& cells) {
  require_shape(positions, {-1, 3}, "positions");
  const py::ssize_t count = positions.shape(0);
  require_shape(sizes, {count, 2}, "sizes");
  require_shape(colors, {count, 4}, "colors");
  require_shape(rotations, {count}, "rotations");
  require_shape(cells, {count}, "cells");
  std::vector<sideray_sprite> sprites(static_cast<size_t>(count));
  for (size_t i = 0; i < sprites.size(); ++i) {
    std::copy_n(positions.data() + 3 * i, 3, sprites[i].position);
    sprites[i].width = sizes.data()[2 * i];
    sprites[i].height = sizes.data()[2 * i + 1];
    sprites[i].rotation = rotations.data()[i];
    std::copy_n(colors.data() + 4 * i, 4, sprites[i].color);
    sprites[i].cell = cells.data()[i];
  }
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_set_sprites(s.scene.get(), particles, sprites.data(), sizeof(sideray_sprite), sprites.size(),
                                     e);
  });
}

void set_lights(SceneHandle& s, const std::vector<py::dict>& given) {
  std::vector<sideray_light> lights;
  for (const py::dict& fields : given) lights.push_back(light_of(fields));
  call(s.mutex,
       [&](sideray_error* e) { return sideray_scene_set_lights(s.scene.get(), lights.data(), lights.size(), e); });
}

void set_environment(SceneHandle& s, const std::optional<Array<float>>& rgb, float scale, float rotation_deg) {
  uint32_t width = 0, height = 0;
  const float* texels = nullptr;
  if (rgb) {
    require_shape(*rgb, {-1, -1, 3}, "environment");
    height = static_cast<uint32_t>(rgb->shape(0)), width = static_cast<uint32_t>(rgb->shape(1));
    texels = rgb->data();
  }
  call(s.mutex, [&](sideray_error* e) {
    return sideray_scene_set_environment(s.scene.get(), width, height, texels, scale, rotation_deg, e);
  });
}

py::object bounds(SceneHandle& s) {
  std::array<double, 3> minimum{}, maximum{};
  sideray_status status = SIDERAY_OK;
  call(s.mutex, [&](sideray_error* e) {
    return status = sideray_scene_bounds(s.scene.get(), minimum.data(), maximum.data(), e);
  });
  if (status == SIDERAY_NOT_READY) return py::none();
  return py::make_tuple(minimum, maximum);
}

py::dict facts(SceneHandle& s) {
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  call(s.mutex, [&](sideray_error* e) { return sideray_plan_scene(s.scene.get(), &facts, e); });
  py::dict result;
  result["triangles"] = facts.triangles;
  result["instances"] = facts.instances;
  result["materials"] = facts.materials;
  result["translucent_objects"] = facts.translucent_objects;
  result["layered_objects"] = facts.layered_objects;
  result["sprites"] = facts.sprites;
  result["lit_lights"] = facts.lit_lights;
  result["bending_objects"] = facts.bending_objects;
  result["has_environment"] = facts.has_environment != 0;
  result["auto_ao"] = facts.auto_ao != 0;
  result["auto_reflections"] = facts.auto_reflections != 0;
  return result;
}

template <auto Function>
void remove_named(SceneHandle& s, uint32_t name) {
  call(s.mutex, [&](sideray_error* e) { return Function(s.scene.get(), name, e); });
}

}  // namespace

void define_scene(py::module_& module) {
  define_mesh_arrays(module);
  py::class_<SceneHandle>(module, "Scene")
      .def(py::init<>())
      .def("add_mesh", add_mesh, py::arg("arrays"))
      .def("replace_mesh", replace_mesh, py::arg("mesh"), py::arg("arrays"))
      .def("set_vertices", set_vertices, py::arg("mesh"), py::arg("arrays"))
      .def("remove_mesh", remove_named<sideray_scene_remove_mesh>, py::arg("mesh"))
      .def("add_texture", add_texture, py::arg("texels"), py::arg("srgb"))
      .def("replace_texture", replace_texture, py::arg("texture"), py::arg("texels"), py::arg("srgb"))
      .def("remove_texture", remove_named<sideray_scene_remove_texture>, py::arg("texture"))
      .def("add_material", add_material, py::arg("fields"))
      .def("replace_material", replace_material, py::arg("material"), py::arg("fields"))
      .def("remove_material", remove_named<sideray_scene_remove_material>, py::arg("material"))
      .def("add_instances", add_instances, py::arg("meshes"), py::arg("materials"), py::arg("transforms"),
           py::arg("surface_ids"), py::arg("visibility"))
      .def("replace_instances", replace_instances, py::arg("instances"), py::arg("meshes"), py::arg("materials"),
           py::arg("transforms"), py::arg("surface_ids"), py::arg("visibility"))
      .def("remove_instances", remove_instances, py::arg("instances"))
      .def("move_instances", move_instances, py::arg("instances"), py::arg("transforms"))
      .def("set_visibility", set_visibility, py::arg("instance"), py::arg("visibility"))
      .def("add_particles", add_particles, py::arg("fields"))
      .def("set_sprites", set_sprites, py::arg("particles"), py::arg("positions"), py::arg("sizes"), py::arg("colors"),
           py::arg("rotations"), py::arg("cells"))
      .def("set_lights", set_lights, py::arg("lights"))
      .def("set_environment", set_environment, py::arg("rgb"), py::arg("scale"), py::arg("rotation_deg"))
      .def("set_time",
           [](SceneHandle& s, double time_s, double previous_time_s) {
             call(s.mutex,
                  [&](sideray_error* e) { return sideray_scene_set_time(s.scene.get(), time_s, previous_time_s, e); });
           },
           py::arg("time_s"), py::arg("previous_time_s"))
      .def("commit",
           [](SceneHandle& s) {
             call(s.mutex, [&](sideray_error* e) { return sideray_scene_commit(s.scene.get(), e); });
           })
      .def("bounds", bounds)
      .def("facts", facts);
}

}  // namespace sideray::python
