// Converts cameras, lights and materials from and to dictionaries of their fields.
#include "python/native/structs.h"

#include <algorithm>

#include "scenes/base/material_slots.h"

namespace sideray::python {
namespace {

// Sets a field; throws where the value has the wrong type, naming what the field takes.
template <typename T>
void put(T& field, const py::handle& value, const std::string& name, const char* takes) {
  try {
    field = value.cast<T>();
  } catch (const py::cast_error&) {
    throw Error(SIDERAY_INVALID_ARGUMENT,
                name + ": " + py::repr(value).cast<std::string>() + " is not " + takes + "; give " + takes);
  }
}

template <typename T, size_t N>
void put(T (&field)[N], const py::handle& value, const std::string& name, const char*) {
  const std::string takes = std::to_string(N) + " numbers";
  std::vector<T> numbers;
  if (const Array<T> array = Array<T>::ensure(value)) numbers.assign(array.data(), array.data() + array.size());
  if (numbers.size() != N)
    throw Error(SIDERAY_INVALID_ARGUMENT,
                name + ": " + py::repr(value).cast<std::string>() + " are not " + takes + "; give " + takes);
  std::copy(numbers.begin(), numbers.end(), field);
}

template <typename T, size_t N>
py::tuple tuple_of(const T (&field)[N]) {
  py::tuple result(N);
  for (size_t i = 0; i < N; ++i) result[i] = field[i];
  return result;
}

template <typename Enum>
struct Word {
  const char* word;
  Enum value;
};

template <typename Enum, size_t N>
void put_word(Enum& field, const py::handle& value, const std::string& name, const Word<Enum> (&words)[N]) {
  const std::string text = py::str(value);
  std::string all;
  for (const Word<Enum>& w : words) {
    if (text == w.word) {
      field = w.value;
      return;
    }
    all += (all.empty() ? "" : ", ") + std::string(w.word);
  }
  throw Error(SIDERAY_INVALID_ARGUMENT, name + ": unknown value \"" + text + "\"; one of " + all);
}

template <typename Enum, size_t N>
const char* word_of(Enum value, const Word<Enum> (&words)[N]) {
  for (const Word<Enum>& w : words)
    if (w.value == value) return w.word;
  return "";
}

constexpr Word<sideray_alpha_mode> alpha_modes[] = {
    {"opaque", SIDERAY_OPAQUE}, {"mask", SIDERAY_MASK}, {"blend", SIDERAY_BLEND}};
constexpr Word<sideray_blend_mode> blend_modes[] = {{"alpha", SIDERAY_BLEND_ALPHA},
                                                    {"premultiplied", SIDERAY_BLEND_PREMULTIPLIED},
                                                    {"additive", SIDERAY_BLEND_ADDITIVE},
                                                    {"multiply", SIDERAY_BLEND_MULTIPLY}};
constexpr Word<sideray_wrap> wraps[] = {
    {"repeat", SIDERAY_REPEAT}, {"clamp", SIDERAY_CLAMP}, {"mirror", SIDERAY_MIRROR}};
constexpr Word<sideray_filter> filters[] = {
    {"trilinear", SIDERAY_TRILINEAR}, {"bilinear", SIDERAY_BILINEAR}, {"nearest", SIDERAY_NEAREST}};
constexpr Word<sideray_light_type> light_types[] = {
    {"directional", SIDERAY_LIGHT_DIRECTIONAL}, {"point", SIDERAY_LIGHT_POINT}, {"spot", SIDERAY_LIGHT_SPOT}};

[[noreturn]] void unknown_field(const char* what, const std::string& name, const std::string& known) {
  throw Error(SIDERAY_INVALID_ARGUMENT, std::string(what) + ": there is no " + name + "; there are " + known);
}

// Sets the field named by each entry. `fields` calls visit(name, put function) for each field.
struct Reader {
  const char* what;
  const py::dict& given;
  std::string known;
  size_t read = 0;

  template <typename Put>
  void operator()(const std::string& name, Put&& put_field) {
    known += (known.empty() ? "" : ", ") + name;
    if (!given.contains(name)) return;
    ++read;
    put_field(given[name.c_str()], name);
  }
  void finish() const {
    if (read == given.size()) return;
    for (const auto& [key, value] : given)
      if ((", " + known + ", ").find(", " + key.cast<std::string>() + ", ") == std::string::npos)
        unknown_field(what, key.cast<std::string>(), known);
  }
};

constexpr const char* number = "a number";
constexpr const char* truth = "True or False";

void put_truth(int32_t& field, const py::handle& value, const std::string& name) {
  bool flag = false;
  put(flag, value, name, truth);
  field = flag;
}

sideray_texture_slot slot_of(const py::handle& value, const std::string& name) {
  sideray_texture_slot slot{};
  const float identity[6] = {1, 0, 0, 1, 0, 0};
  std::copy(std::begin(identity), std::end(identity), slot.texture_from_uv);
  if (!py::isinstance<py::dict>(value)) {
    put(slot.texture, value, name, "a texture");
    return slot;
  }
  const auto fields = value.cast<py::dict>();
  Reader reader{name.c_str(), fields, {}};
  reader("texture", [&](auto v, auto n) { put(slot.texture, v, n, "a texture"); });
  reader("uv_set", [&](auto v, auto n) { put(slot.uv_set, v, n, "0 or 1"); });
  reader("wrap_u", [&](auto v, auto n) { put_word(slot.wrap_u, v, n, wraps); });
  reader("wrap_v", [&](auto v, auto n) { put_word(slot.wrap_v, v, n, wraps); });
  reader("filter", [&](auto v, auto n) { put_word(slot.filter, v, n, filters); });
  reader("texture_from_uv", [&](auto v, auto n) { put(slot.texture_from_uv, v, n, number); });
  reader.finish();
  return slot;
}

}  // namespace

sideray_camera camera_of(const py::dict& fields) {
  sideray_camera camera = sideray_camera_defaults();
  Reader reader{"camera", fields, {}};
  reader("world_from_camera", [&](auto v, auto n) { put(camera.world_from_camera, v, n, number); });
  reader("orthographic", [&](auto v, auto n) { put_truth(camera.orthographic, v, n); });
  reader("yfov", [&](auto v, auto n) { put(camera.yfov, v, n, number); });
  reader("half_height", [&](auto v, auto n) { put(camera.half_height, v, n, number); });
  reader("z_near", [&](auto v, auto n) { put(camera.z_near, v, n, number); });
  reader("z_far", [&](auto v, auto n) { put(camera.z_far, v, n, number); });
  reader("fx_per_fy", [&](auto v, auto n) { put(camera.fx_per_fy, v, n, number); });
  reader("shift_x", [&](auto v, auto n) { put(camera.shift_x, v, n, number); });
  reader("shift_y", [&](auto v, auto n) { put(camera.shift_y, v, n, number); });
  reader.finish();
  return camera;
}

py::dict fields_of(const sideray_camera& camera) {
  py::dict fields;
  fields["world_from_camera"] = tuple_of(camera.world_from_camera);
  fields["orthographic"] = camera.orthographic != 0;
  fields["yfov"] = camera.yfov;
  fields["half_height"] = camera.half_height;
  fields["z_near"] = camera.z_near;
  fields["z_far"] = camera.z_far;
  fields["fx_per_fy"] = camera.fx_per_fy;
  fields["shift_x"] = camera.shift_x;
  fields["shift_y"] = camera.shift_y;
  return fields;
}

sideray_light light_of(const py::dict& fields) {
  sideray_light light = sideray_light_defaults();
  Reader reader{"light", fields, {}};
  reader("type", [&](auto v, auto n) { put_word(light.type, v, n, light_types); });
  reader("position", [&](auto v, auto n) { put(light.position, v, n, number); });
  reader("direction", [&](auto v, auto n) { put(light.direction, v, n, number); });
  reader("intensity", [&](auto v, auto n) { put(light.intensity, v, n, number); });
  reader("range", [&](auto v, auto n) { put(light.range, v, n, number); });
  reader("inner_cone", [&](auto v, auto n) { put(light.inner_cone, v, n, number); });
  reader("outer_cone", [&](auto v, auto n) { put(light.outer_cone, v, n, number); });
  reader("radius", [&](auto v, auto n) { put(light.radius, v, n, number); });
  reader("angular_diameter_deg", [&](auto v, auto n) { put(light.angular_diameter_deg, v, n, number); });
  reader("shadow_filter_radius", [&](auto v, auto n) { put(light.shadow_filter_radius, v, n, number); });
  reader("shadow_filter_frames", [&](auto v, auto n) { put(light.shadow_filter_frames, v, n, number); });
  reader.finish();
  return light;
}

py::dict fields_of(const sideray_light& light) {
  py::dict fields;
  fields["type"] = word_of(light.type, light_types);
  fields["position"] = tuple_of(light.position);
  fields["direction"] = tuple_of(light.direction);
  fields["intensity"] = tuple_of(light.intensity);
  fields["range"] = light.range;
  fields["inner_cone"] = light.inner_cone;
  fields["outer_cone"] = light.outer_cone;
  fields["radius"] = light.radius;
  fields["angular_diameter_deg"] = light.angular_diameter_deg;
  fields["shadow_filter_radius"] = light.shadow_filter_radius;
  fields["shadow_filter_frames"] = light.shadow_filter_frames;
  return fields;
}

sideray_material_desc material_of(const py::dict& fields) {
  sideray_material_desc m = sideray_material_defaults();
  Reader reader{"material", fields, {}};
  const auto numbers = [&](const char* name, auto& field) {
    reader(name, [&](auto v, auto n) { put(field, v, n, number); });
  };
  const auto flag = [&](const char* name, int32_t& field) {
    reader(name, [&](auto v, auto n) { put_truth(field, v, n); });
  };
  numbers("base_color", m.base_color);
  numbers("metallic", m.metallic);
  numbers("roughness", m.roughness);
  numbers("emissive", m.emissive);
  numbers("normal_scale", m.normal_scale);
  numbers("occlusion_strength", m.occlusion_strength);
  reader("alpha_mode", [&](auto v, auto n) { put_word(m.alpha_mode, v, n, alpha_modes); });
  numbers("alpha_cutoff", m.alpha_cutoff);
  reader("blend_mode", [&](auto v, auto n) { put_word(m.blend_mode, v, n, blend_modes); });
  flag("double_sided", m.double_sided);
  flag("unlit", m.unlit);
  numbers("transmission", m.transmission);
  numbers("ior", m.ior);
  numbers("thickness", m.thickness);
  numbers("attenuation_distance", m.attenuation_distance);
  numbers("attenuation_color", m.attenuation_color);
  numbers("specular", m.specular);
  numbers("specular_color", m.specular_color);
  numbers("clearcoat", m.clearcoat);
  numbers("clearcoat_roughness", m.clearcoat_roughness);
  numbers("clearcoat_normal_scale", m.clearcoat_normal_scale);
  numbers("sheen_color", m.sheen_color);
  numbers("sheen_roughness", m.sheen_roughness);
  numbers("diffuse_transmission", m.diffuse_transmission);
  numbers("diffuse_transmission_color", m.diffuse_transmission_color);
  numbers("iridescence", m.iridescence);
  numbers("iridescence_ior", m.iridescence_ior);
  numbers("iridescence_thickness_min", m.iridescence_thickness_min);
  numbers("iridescence_thickness_max", m.iridescence_thickness_max);
  numbers("anisotropy", m.anisotropy);
  numbers("anisotropy_rotation", m.anisotropy_rotation);
  numbers("dispersion", m.dispersion);
  numbers("distortion", m.distortion);
  flag("inexact_shadow", m.inexact_shadow);
  for (const scenes::MaterialSlot& s : scenes::material_slots)
    reader(s.name + std::string("_texture"), [&](auto v, auto n) { m.*s.slot = slot_of(v, n); });
  reader.finish();
  return m;
}

sideray_particles_desc particles_of(const py::dict& fields) {
  sideray_particles_desc desc = sideray_particles_defaults();
  Reader reader{"particles", fields, {}};
  reader("texture", [&](auto v, auto n) { put(desc.texture, v, n, "a texture"); });
  reader("columns", [&](auto v, auto n) { put(desc.columns, v, n, number); });
  reader("rows", [&](auto v, auto n) { put(desc.rows, v, n, number); });
  reader("blend_mode", [&](auto v, auto n) { put_word(desc.blend_mode, v, n, blend_modes); });
  reader("soft_distance", [&](auto v, auto n) { put(desc.soft_distance, v, n, number); });
  reader("lit", [&](auto v, auto n) { put_truth(desc.lit, v, n); });
  reader.finish();
  return desc;
}

}  // namespace sideray::python
