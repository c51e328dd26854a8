#include "sideray_osg.h"

#include <osg/AlphaFunc>
#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/LightModel>
#include <osg/LightSource>
#include <osg/Material>
#include <osg/Texture2D>
#include <osg/Transform>
#include <osg/TriangleIndexFunctor>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sideray_osg {
namespace {

using States = std::vector<osg::StateSet*>;

template <typename T>
const T* attribute(const osg::StateSet& state, osg::StateAttribute::Type type) {
  return dynamic_cast<const T*>(state.getAttribute(type));
}

bool is_on(const osg::StateSet& state, GLenum mode) {
  return (state.getMode(mode) & osg::StateAttribute::ON) != 0;
}

osg::ref_ptr<osg::StateSet> merged(const States& states) {
  osg::ref_ptr<osg::StateSet> all = new osg::StateSet;
  for (const osg::StateSet* state : states) all->merge(*state);
  return all;
}

void set(float* to, const osg::Vec4& from) {
  for (unsigned i = 0; i < 3; ++i) to[i] = from[i];
}

// Writes four columns of three, from a matrix for OpenSceneGraph's row vectors.
void set(double* to, const osg::Matrixd& matrix) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) to[3 * column + row] = matrix(column, row);
}

struct Triangles {
  std::vector<uint32_t> indices;
  void operator()(unsigned a, unsigned b, unsigned c) { indices.insert(indices.end(), {a, b, c}); }
};

sideray_attribute floats(const osg::Array* array, osg::Array::Type type, unsigned vertices) {
  const bool usable = array && array->getType() == type && array->getNumElements() == vertices;
  return {usable ? static_cast<const float*>(array->getDataPointer()) : nullptr, 0};
}

sideray_blend_mode blend_mode_of(const osg::StateSet& state) {
  const auto* function = attribute<osg::BlendFunc>(state, osg::StateAttribute::BLENDFUNC);
  const GLenum source = function ? function->getSource() : GLenum{GL_SRC_ALPHA};
  const GLenum destination = function ? function->getDestination() : GLenum{GL_ONE_MINUS_SRC_ALPHA};
  if (destination == GL_ONE) return SIDERAY_BLEND_ADDITIVE;
  if (destination != GL_ONE_MINUS_SRC_ALPHA) return SIDERAY_BLEND_MULTIPLY;
  return source == GL_ONE ? SIDERAY_BLEND_PREMULTIPLIED : SIDERAY_BLEND_ALPHA;
}

// Returns whether rays may draw it. Additive and multiplied surfaces (flames, smudges) stay as they were.
bool is_glass(const osg::StateSet& state) {
  const sideray_blend_mode mode = blend_mode_of(state);
  return is_on(state, GL_BLEND) && (mode == SIDERAY_BLEND_ALPHA || mode == SIDERAY_BLEND_PREMULTIPLIED);
}

// Converts a classic material, which has no units, so that the tracer's Lambert and Blinn-Phong-like lobes look about
// as in the fixed function: diffuse becomes albedo, the exponent roughness, and the specular colour scales the
// reflectance of plastic.
void set_colors(const osg::StateSet& state, sideray_material_desc& d) {
  const auto front = osg::Material::FRONT;
  const auto* m = attribute<osg::Material>(state, osg::StateAttribute::MATERIAL);
  d.roughness = 1.0f;
  d.specular = 0.0f;
  d.unlit = !is_on(state, GL_LIGHTING);
  if (d.unlit || !m) return;
  set(d.base_color, m->getDiffuse(front));
  d.base_color[3] = m->getDiffuse(front).a();
  set(d.emissive, m->getEmission(front));
  const osg::Vec4 specular = m->getSpecular(front);
  if (specular.r() + specular.g() + specular.b() <= 0.0f) return;
  d.specular = 1.0f;
  set(d.specular_color, specular);
  d.roughness = std::pow(2.0f / (m->getShininess(front) + 2.0f), 0.25f);
}

sideray_wrap wrap_of(osg::Texture::WrapMode mode) {
  if (mode == osg::Texture::REPEAT) return SIDERAY_REPEAT;
  return mode == osg::Texture::MIRROR ? SIDERAY_MIRROR : SIDERAY_CLAMP;
}

// Makes an environment that lights as the engine's ambient term does, and as its lights without shadows do: each is a
// texel, scaled by its solid angle for the same irradiance. Where a sky is drawn, rays see that instead.
class Surroundings {
 public:
  explicit Surroundings(osg::Vec4 ambient) : rgb_(3 * width * height) {
    for (size_t i = 0; i < rgb_.size(); ++i) rgb_[i] = ambient[static_cast<unsigned>(i % 3)];
  }
  void add(const osg::Vec3d& toward, const osg::Vec4& irradiance) {
    const double u = 0.5 + std::atan2(toward.x(), -toward.z()) / (2 * osg::PI), v = std::acos(toward.y()) / osg::PI;
    const int x = std::min(static_cast<int>(u * width), width - 1),
              y = std::min(static_cast<int>(v * height), height - 1);
    const double top = osg::PI * y / height, bottom = osg::PI * (y + 1) / height;
    const double solid_angle = 2 * osg::PI / width * (std::cos(top) - std::cos(bottom));
    for (unsigned c = 0; c < 3; ++c)
      rgb_[3 * static_cast<size_t>(y * width + x) + c] += static_cast<float>(double{irradiance[c]} / solid_angle);
  }
  void give(sideray::Scene& scene) const { scene.set_environment(width, height, rgb_.data(), 1.0f, 0.0f); }

 private:
  static constexpr int width = 64, height = 32;
  std::vector<float> rgb_;
};

}  // namespace

// Visits every geometry, with the state sets above it.
class Walk : public osg::NodeVisitor {
 public:
  explicit Walk(SceneAdapter& adapter) : NodeVisitor(TRAVERSE_ACTIVE_CHILDREN), adapter_(adapter) {}

  void apply(osg::Node& node) override {
    osg::StateSet* const state = node.getStateSet();
    if (state) states_.push_back(state);
    if (states_.size() == 1) read_ambient(*states_[0]);
    meet(node);
    traverse(node);
    if (state) states_.pop_back();
  }

  std::vector<SceneAdapter::Lamp> lamps;
  osg::Vec4 ambient = {0.2f, 0.2f, 0.2f, 1};  // OpenGL's own

 private:
  void meet(osg::Node& node) {
    if (osg::Geometry* const geometry = node.asGeometry()) adapter_.place(*geometry, getNodePath(), states_);
    if (const auto* source = dynamic_cast<osg::LightSource*>(&node))
      lamps.push_back({source->getLight(), osg::computeLocalToWorld(getNodePath())});
  }
  void read_ambient(const osg::StateSet& state) {
    const auto* model = attribute<osg::LightModel>(state, osg::StateAttribute::LIGHTMODEL);
    if (model) ambient = model->getAmbientIntensity();
  }

  SceneAdapter& adapter_;
  States states_;
};

SceneAdapter::SceneAdapter(osg::Node& root, const Rules& rules)
    : scene_(sideray::Scene::create().value()), rules_(rules) {
  Walk walk(*this);
  root.accept(walk);
  set_lights(walk.lamps, walk.ambient);
  scene_.commit();
}

size_t SceneAdapter::update() {
  size_t moved = 0;
  for (Placed& placed : placed_) {
    const osg::Matrixd now = osg::computeLocalToWorld(placed.path);
    if (now == placed.world_from_object) continue;
    placed.world_from_object = now;
    double columns[12];
    set(columns, now);
    scene_.move_instance(placed.instance, columns);
    ++moved;
  }
  if (moved > 0) scene_.commit();
  return moved;
}

void SceneAdapter::place(osg::Geometry& geometry, const osg::NodePath& path, const States& states) {
  const osg::ref_ptr<osg::StateSet> state = merged(states);
  const bool blended = is_on(*state, GL_BLEND), glass = is_glass(*state);
  sideray_instance_desc instance{};
  instance.mesh = mesh_of(geometry);
  instance.material = material_of(states, *state);
  const osg::Matrixd world_from_object = osg::computeLocalToWorld(path);
  set(instance.world_from_object, world_from_object);
  instance.surface_id = static_cast<uint32_t>(placed_.size()) + 1;
  // Geometry that writes no depth is scenery, such as a sky: it is visible but casts no shadow.
  const auto* depth = attribute<osg::Depth>(*state, osg::StateAttribute::DEPTH);
  const bool scenery = !blended && depth && !depth->getWriteMask();
  instance.visibility = scenery ? SIDERAY_VISIBLE_REFLECTION : SIDERAY_VISIBLE_ALL;
  if (blended && !glass) instance.visibility &= ~uint32_t{SIDERAY_VISIBLE_LAYERS};
  placed_.push_back({scene_.add_instances({&instance, 1}).front(), path, world_from_object});
  if (glass) add_glass(geometry, path, states, instance.surface_id);
}

void SceneAdapter::add_glass(osg::Geometry& geometry, const osg::NodePath& path, const States& states,
                             uint32_t surface_id) {
  osg::StateSet* blends = nullptr;
  for (osg::StateSet* s : states)
    if (is_on(*s, GL_BLEND)) blends = s;
  osg::Node* own = path.front();
  for (osg::Node* node : path) {
    if (node->getNumParents() > 1) break;
    own = node;
  }
  const auto is_taken = [&](const Glass& other) { return other.own == own; };
  if (std::any_of(glass_.begin(), glass_.end(), is_taken))
    throw std::runtime_error("\"" + own->getName() +
                             "\" shows several blended drawables below it that are shared: give "
                             "each a node of its own, so that it can carry a surface id");
  glass_.push_back({&geometry, blends, own, surface_id});
}

sideray_mesh SceneAdapter::mesh_of(osg::Geometry& geometry) {
  sideray_mesh& mesh = meshes_[&geometry];
  if (mesh != 0) return mesh;
  const osg::Array* const positions = geometry.getVertexArray();
  if (!positions || positions->getType() != osg::Array::Vec3ArrayType)
    throw std::runtime_error("geometry \"" + geometry.getName() + "\": its positions are not floats in threes");
  osg::TriangleIndexFunctor<Triangles> triangles;
  geometry.accept(triangles);
  const unsigned count = positions->getNumElements();
  sideray_mesh_desc desc = sideray_mesh_defaults();
  desc.vertex_count = count;
  desc.positions = floats(positions, osg::Array::Vec3ArrayType, count);
  desc.normals = floats(geometry.getNormalArray(), osg::Array::Vec3ArrayType, count);
  // Image rows are from the bottom up, as in OpenGL, so that texture coordinates need no change.
  desc.uv0 = floats(geometry.getTexCoordArray(0), osg::Array::Vec2ArrayType, count);
  desc.index_count = static_cast<uint32_t>(triangles.indices.size());
  desc.indices = triangles.indices.data();
  return mesh = scene_.add_mesh(desc);
}

sideray_material SceneAdapter::material_of(const States& states, const osg::StateSet& state) {
  sideray_material& material = materials_[states];
  if (material != 0) return material;
  sideray_material_desc d = sideray_material_defaults();
  set_colors(state, d);
  d.base_color_texture = slot_of(state);
  set_ambient(state, d);
  d.double_sided = !is_on(state, GL_CULL_FACE);
  const auto* alpha = attribute<osg::AlphaFunc>(state, osg::StateAttribute::ALPHAFUNC);
  if (is_on(state, GL_BLEND)) {
    d.alpha_mode = SIDERAY_BLEND;
    d.blend_mode = blend_mode_of(state);
  } else if (is_on(state, GL_ALPHA_TEST) && alpha) {
    d.alpha_mode = SIDERAY_MASK;
    d.alpha_cutoff = alpha->getReferenceValue();
  }
  if (rules_.adjust) rules_.adjust(state, d);
  return material = scene_.add_material(d);
}

sideray_texture_slot SceneAdapter::slot_of(const osg::StateSet& state) {
  sideray_texture_slot slot = sideray_material_defaults().base_color_texture;
  const auto* texture = dynamic_cast<const osg::Texture2D*>(state.getTextureAttribute(0, osg::StateAttribute::TEXTURE));
  // Generated coordinates are faked reflections, which rays replace by real ones.
  if (!texture || !texture->getImage() || state.getTextureAttribute(0, osg::StateAttribute::TEXGEN)) return slot;
  slot.texture = texture_of(*texture->getImage());
  slot.wrap_u = wrap_of(texture->getWrap(osg::Texture::WRAP_S));
  slot.wrap_v = wrap_of(texture->getWrap(osg::Texture::WRAP_T));
  return slot;
}

// Sets a classic material's ambient colour, where it is darker than the diffuse one, as uniform occlusion.
void SceneAdapter::set_ambient(const osg::StateSet& state, sideray_material_desc& d) {
  const auto* m = attribute<osg::Material>(state, osg::StateAttribute::MATERIAL);
  if (d.unlit || !m) return;
  const osg::Vec4 ambient = m->getAmbient(osg::Material::FRONT), diffuse = m->getDiffuse(osg::Material::FRONT);
  const float of_diffuse = diffuse.r() + diffuse.g() + diffuse.b();
  const float share = of_diffuse > 0.0f ? (ambient.r() + ambient.g() + ambient.b()) / of_diffuse : 1.0f;
  if (share >= 1.0f) return;
  constexpr uint8_t texel[4] = {0, 0, 0, 255};
  if (black_ == 0) black_ = scene_.add_texture(1, 1, SIDERAY_RGBA8, texel);
  d.occlusion_texture.texture = black_;
  d.occlusion_strength = 1.0f - share;
}

sideray_texture SceneAdapter::texture_of(const osg::Image& image) {
  sideray_texture& texture = textures_[&image];
  if (texture != 0) return texture;
  std::vector<uint8_t> texels;
  for (int y = 0; y < image.t(); ++y)
    for (int x = 0; x < image.s(); ++x)
      for (unsigned c = 0; c < 4; ++c)
        texels.push_back(static_cast<uint8_t>(std::lround(255.0f * image.getColor(x, y)[c])));
  // Not sRGB: the engine adds light in the space of displayed values, and so do the rays.
  return texture = scene_.add_texture(static_cast<uint32_t>(image.s()), static_cast<uint32_t>(image.t()), SIDERAY_RGBA8,
                                      texels.data());
}

void SceneAdapter::set_lights(const std::vector<Lamp>& lamps, osg::Vec4 ambient) {
  for (const Lamp& lamp : lamps) ambient += lamp.light->getAmbient();
  Surroundings surroundings(ambient);
  std::vector<sideray_light> lights;
  for (const Lamp& lamp : lamps) {
    const osg::Vec4 position = lamp.light->getPosition();
    if (position.w() != 0.0f)
      throw std::runtime_error("light \"" + lamp.light->getName() +
                               "\": only directional lights are mapped; OpenGL's attenuation is no inverse square");
    osg::Vec3d toward =
        osg::Matrixd::transform3x3(osg::Vec3d(position.x(), position.y(), position.z()), lamp.world_from_light);
    toward.normalize();
    // The tracer divides diffuse light by pi, the engine does not.
    const osg::Vec4 irradiance = lamp.light->getDiffuse() * static_cast<float>(osg::PI);
    if (!rules_.shadow_lights.contains(lamp.light->getLightNum())) {
      surroundings.add(toward, irradiance);
      continue;
    }
    const osg::Vec4 sun = lamp.light->getDiffuse();
    if (lights.empty()) lighting_ = {toward, {sun.r(), sun.g(), sun.b()}, {ambient.r(), ambient.g(), ambient.b()}};
    sideray_light light{};
    light.size = sizeof(light);
    for (unsigned c = 0; c < 3; ++c)
      light.direction[c] = static_cast<float>(-toward[c]), light.intensity[c] = irradiance[c];
    lights.push_back(light);
  }
  scene_.set_lights(lights);
  surroundings.give(scene_);
}

}  // namespace sideray_osg
