// Writes the terrace as OpenSceneGraph's own files, with the materials of an engine without shaders: retrofit_scene
// FOLDER makes FOLDER/terrace.osgt and its pictures. No OpenGL.
#include <osg/AlphaFunc>
#include <osg/AnimationPath>
#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/Geode>
#include <osg/Geometry>
#include <osg/LightModel>
#include <osg/LightSource>
#include <osg/Material>
#include <osg/MatrixTransform>
#include <osg/TexEnv>
#include <osg/TexGen>
#include <osg/Texture2D>
#include <osgDB/WriteFile>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <string>

#include "scenes/images/images.h"
#include "terrace.h"

namespace {

using sideray::scenes::Content;
using sideray::scenes::Material;
using sideray::scenes::Mesh;
using sideray::scenes::Texture;

constexpr unsigned on = osg::StateAttribute::ON, off = osg::StateAttribute::OFF;

// Converts a linear factor on linear texels to a factor on codes: the engine computes with displayed values.
float code(float linear) {
  return std::pow(std::clamp(linear, 0.0f, 1.0f), 1.0f / 2.2f);
}
glm::vec3 code(glm::vec3 linear) {
  return {code(linear.x), code(linear.y), code(linear.z)};
}
glm::vec3 vec3_of(const float* v) {
  return {v[0], v[1], v[2]};
}
osg::Vec4 color(glm::vec3 rgb, float alpha = 1.0f) {
  return {rgb.x, rgb.y, rgb.z, alpha};
}
float luminance(glm::vec3 c) {
  return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

// Returns the share of the sky's light that a material takes: such engines darkened rooms by their materials.
float ambient_share(const std::string& material) {
  for (const char* inside : {"plaster", "ceiling", "floor tiles", "painted panel", "lacquered bar top"})
    if (material == inside) return 0.4f;
  return 1.0f;
}

osg::ref_ptr<osg::Image> image_of(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba,
                                  const std::string& name) {
  osg::ref_ptr<osg::Image> image = new osg::Image;
  image->allocateImage(static_cast<int>(width), static_cast<int>(height), 1, GL_RGBA, GL_UNSIGNED_BYTE);
  std::memcpy(image->data(), rgba.data(), rgba.size());
  image->flipVertical();  // it had the top row first
  image->setFileName(name + ".png");
  return image;
}

// Returns the sphere map that all glass of such an engine reflects, wherever it is: a picture of no real place.
osg::ref_ptr<osg::Image> sheen() {
  constexpr uint32_t size = 128;
  std::vector<uint8_t> rgba;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const glm::vec2 p = (glm::vec2(x, y) + 0.5f) / (0.5f * size) - 1.0f;
      const float r2 = std::min(glm::dot(p, p), 0.999f);
      // The height of the texel's reflected direction sets its brightness, plus a rim as on all glass.
      const float up = 2.0f * std::sqrt(1.0f - r2) * -p.y, rim = 0.55f * r2 * r2 * r2;
      const float window = glm::smoothstep(0.35f, 0.45f, up) * glm::smoothstep(0.5f, 0.4f, std::abs(p.x + 0.2f));
      const glm::vec3 sky(0.62f, 0.74f, 0.90f), ground(0.22f, 0.19f, 0.16f);
      const glm::vec3 c = glm::mix(ground, sky, glm::smoothstep(-0.15f, 0.25f, up)) * (0.10f + rim) + 0.18f * window;
      for (const float v : {c.x, c.y, c.z}) rgba.push_back(static_cast<uint8_t>(255.0f * std::min(v, 1.0f)));
      rgba.push_back(255);
    }
  return image_of(size, size, rgba, "sheen");
}

// Holds the arrays of a geometry, whose triangles are split until no side is longer than five metres: lighting is at
// vertices, and a rasterizer that clips a longer triangle at the eye interpolates depth less exactly.
struct Vertices {
  osg::ref_ptr<osg::Vec3Array> positions = new osg::Vec3Array, normals = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec2Array> uvs = new osg::Vec2Array;
  std::vector<unsigned> indices;

  void add(unsigned a, unsigned b, unsigned c) {
    const auto square = [&](unsigned u, unsigned v) { return ((*positions)[u] - (*positions)[v]).length2(); };
    // The longest side from a to b.
    const float ab = square(a, b), bc = square(b, c), ca = square(c, a);
    if (bc > ab && bc >= ca) return add(b, c, a);
    if (ca > ab && ca > bc) return add(c, a, b);
    if (ab <= 25.0f) return static_cast<void>(indices.insert(indices.end(), {a, b, c}));
    const unsigned middle = between(a, b);
    add(a, middle, c);
    add(middle, b, c);
  }

 private:
  unsigned between(unsigned a, unsigned b) {
    positions->push_back(((*positions)[a] + (*positions)[b]) * 0.5f);
    osg::Vec3 normal = (*normals)[a] + (*normals)[b];
    normal.normalize();
    normals->push_back(normal);
    if (!uvs->empty()) uvs->push_back(((*uvs)[a] + (*uvs)[b]) * 0.5f);
    return static_cast<unsigned>(positions->size()) - 1;
  }
};

class SceneWriter {
 public:
  explicit SceneWriter(const Content& content) : content_(content), states_(content.materials.size()) {}

  osg::ref_ptr<osg::Group> make() {
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->setName("terrace");
    add_lights(*root);
    osg::Group* const van = add_path(*root, "van ", false);
    osg::Group* const lantern = add_path(*root, "lantern ", true);
    for (const sideray::scenes::Object& object : content_.objects) {
      const bool of_van = object.name.starts_with("van "), of_lantern = object.name.starts_with("lantern ");
      osg::Matrixd matrix = matrix_of(object);
      if (of_van || of_lantern) matrix.setTrans(0, 0, 0);
      osg::ref_ptr<osg::MatrixTransform> node = new osg::MatrixTransform(matrix);
      node->setName(object.name);
      node->addChild(geode(object.mesh, object.material));
      (of_van ? *van : of_lantern ? *lantern : *root).addChild(node);
    }
    return root;
  }

  void write_images(const std::string& folder) const {
    for (const auto& [name, image] : images_) {
      osg::ref_ptr<osg::Image> top_down = new osg::Image(*image, osg::CopyOp::DEEP_COPY_ALL);
      top_down->flipVertical();
      const std::span<const uint8_t> pixels(top_down->data(), top_down->getTotalSizeInBytes());
      const std::vector<uint8_t> file = sideray::scenes::encode_png(
          static_cast<uint32_t>(top_down->s()), static_cast<uint32_t>(top_down->t()), 4, pixels, name);
      std::FILE* const out = std::fopen((folder + "/" + name + ".png").c_str(), "wb");
      if (!out || std::fwrite(file.data(), 1, file.size(), out) != file.size() || std::fclose(out) != 0)
        throw std::runtime_error(folder + "/" + name + ".png: cannot be written");
    }
  }

 private:
  static osg::Matrixd matrix_of(const sideray::scenes::Object& object) {
    const double* m = object.world_from_object;
    return {m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, m[9], m[10], m[11], 1};
  }

  static void add_lights(osg::Group& root) {
    struct Lamp {
      const char* name;
      osg::Vec4 toward, ambient, diffuse, specular;
    };
    const Lamp lamps[] = {
        {"sun", {-0.62f, 1.0f, -0.52f, 0}, {0.35f, 0.38f, 0.43f, 1}, {0.68f, 0.62f, 0.52f, 1}, {1, 0.95f, 0.85f, 1}},
        {"fill", {0.4f, 0.5f, 0.8f, 0}, {0, 0, 0, 1}, {0.24f, 0.25f, 0.27f, 1}, {0, 0, 0, 1}}};
    int number = 0;
    for (const Lamp& lamp : lamps) {
      osg::ref_ptr<osg::Light> light = new osg::Light(static_cast<unsigned>(number++));
      light->setName(lamp.name);
      light->setPosition(lamp.toward);
      light->setAmbient(lamp.ambient);
      light->setDiffuse(lamp.diffuse);
      light->setSpecular(lamp.specular);
      osg::ref_ptr<osg::LightSource> source = new osg::LightSource;
      source->setName(lamp.name);
      source->setLight(light);
      source->setStateSetModes(*root.getOrCreateStateSet(), on);
      root.addChild(source);
    }
    osg::StateSet& state = *root.getOrCreateStateSet();
    osg::ref_ptr<osg::LightModel> model = new osg::LightModel;
    model->setAmbientIntensity({0, 0, 0, 1});
    state.setAttributeAndModes(model);
    state.setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK), on);
    state.setMode(GL_LIGHTING, on);
    state.setMode(GL_NORMALIZE, on);
  }

  // Adds an animation: the object drives past in eight seconds, or swings in four.
  osg::Group* add_path(osg::Group& root, const std::string& prefix, bool swings) const {
    const auto of_it = [&](const sideray::scenes::Object& o) { return o.name.starts_with(prefix); };
    const auto found = std::find_if(content_.objects.begin(), content_.objects.end(), of_it);
    if (found == content_.objects.end()) throw std::runtime_error("the terrace has no " + prefix);
    const osg::Vec3d pivot = matrix_of(*found).getTrans();
    osg::ref_ptr<osg::AnimationPath> path = new osg::AnimationPath;
    path->setLoopMode(osg::AnimationPath::LOOP);
    constexpr int steps = 32;
    for (int i = 0; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps, turn = 0.16 * std::sin(2 * osg::PI * share);
      const osg::Vec3d at = swings ? pivot : pivot + osg::Vec3d(28.0 * (share < 0.5 ? share : share - 1.0), 0, 0);
      path->insert((swings ? 4.0 : 8.0) * share,
                   osg::AnimationPath::ControlPoint(at, osg::Quat(swings ? turn : 0.0, osg::Vec3d(0, 0, 1))));
    }
    osg::ref_ptr<osg::MatrixTransform> node = new osg::MatrixTransform(osg::Matrixd::translate(pivot));
    node->setName(prefix.substr(0, prefix.size() - 1));
    node->setDataVariance(osg::Object::DYNAMIC);
    node->setUpdateCallback(new osg::AnimationPathCallback(path));
    root.addChild(node);
    return node;
  }

  osg::Geode* geode(uint32_t mesh, uint32_t material) {
    osg::ref_ptr<osg::Geode>& made = geodes_[{mesh, material}];
    if (made) return made;
    made = new osg::Geode;
    made->addDrawable(geometry(content_.meshes[mesh]));
    made->setStateSet(state(material));
    return made;
  }

  static osg::ref_ptr<osg::Geometry> geometry(const Mesh& mesh) {
    Vertices vertices;
    for (size_t i = 0; i < mesh.positions.size() / 3; ++i) {
      const float *p = &mesh.positions[3 * i], *n = &mesh.normals[3 * i];
      vertices.positions->push_back({p[0], p[1], p[2]});
      vertices.normals->push_back({n[0], n[1], n[2]});
      if (!mesh.uv0.empty()) vertices.uvs->push_back({mesh.uv0[2 * i], 1.0f - mesh.uv0[2 * i + 1]});
    }
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
      vertices.add(mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]);
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices.positions);
    geometry->setNormalArray(vertices.normals, osg::Array::BIND_PER_VERTEX);
    if (!mesh.uv0.empty()) geometry->setTexCoordArray(0, vertices.uvs, osg::Array::BIND_PER_VERTEX);
    geometry->addPrimitiveSet(
        new osg::DrawElementsUInt(GL_TRIANGLES, vertices.indices.begin(), vertices.indices.end()));
    return geometry;
  }

  osg::StateSet* state(uint32_t index) {
    osg::ref_ptr<osg::StateSet>& made = states_[index];
    if (made) return made;
    const Material& material = content_.materials[index];
    const sideray_material_desc& d = material.desc;
    made = new osg::StateSet;
    made->setName(material.name);
    if (d.unlit) {
      made->setMode(GL_LIGHTING, off);
      made->setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0, 1, false));
      made->setRenderBinDetails(-1, "RenderBin");
    }
    if (d.double_sided) {
      osg::ref_ptr<osg::LightModel> two_sided = new osg::LightModel;
      two_sided->setAmbientIntensity({0, 0, 0, 1});
      two_sided->setTwoSided(true);
      made->setAttributeAndModes(two_sided);
      made->setMode(GL_CULL_FACE, off);
    }
    if (d.blend_mode == SIDERAY_BLEND_ADDITIVE) {
      make_glow(*made, material);
    } else if (d.alpha_mode == SIDERAY_BLEND || d.transmission > 0.0f) {
      make_glass(*made, material);
    } else {
      make_opaque(*made, material);
    }
    return made;
  }

  void make_opaque(osg::StateSet& state, const Material& material) {
    const sideray_material_desc& d = material.desc;
    const glm::vec3 base = code(vec3_of(d.base_color));
    const float gloss = (1.0f - d.roughness) * (1.0f - d.roughness);
    osg::ref_ptr<osg::Material> m = new osg::Material;
    m->setName(material.name);
    const glm::vec3 diffuse = base * (1.0f - 0.45f * d.metallic);
    m->setAmbient(osg::Material::FRONT_AND_BACK, color(diffuse * ambient_share(material.name)));
    m->setDiffuse(osg::Material::FRONT_AND_BACK, color(diffuse));
    m->setSpecular(osg::Material::FRONT_AND_BACK, color(glm::mix(glm::vec3(0.5f * gloss), base, d.metallic)));
    m->setShininess(osg::Material::FRONT_AND_BACK, std::clamp(4.0f / std::pow(d.roughness, 3.0f), 4.0f, 100.0f));
    // By day lamps glow faintly, and windows across the street do not glow.
    if (d.emissive_texture.texture == 0)
      m->setEmission(osg::Material::FRONT_AND_BACK, color(0.5f * code(vec3_of(d.emissive))));
    state.setAttributeAndModes(m);
    if (d.base_color_texture.texture) add_texture(state, d);
    if (d.alpha_mode == SIDERAY_MASK)
      state.setAttributeAndModes(new osg::AlphaFunc(osg::AlphaFunc::GEQUAL, d.alpha_cutoff));
  }

  void add_texture(osg::StateSet& state, const sideray_material_desc& d) {
    const Texture& from = content_.textures[d.base_color_texture.texture - 1];
    std::string name = from.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    osg::ref_ptr<osg::Image>& image = images_[name];
    if (!image) image = image_of(from.width, from.height, from.rgba, name);
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D(image);
    const auto wrap = d.base_color_texture.wrap_u == SIDERAY_CLAMP ? osg::Texture::CLAMP_TO_EDGE : osg::Texture::REPEAT;
    texture->setWrap(osg::Texture::WRAP_S, wrap);
    texture->setWrap(osg::Texture::WRAP_T, wrap);
    state.setTextureAttributeAndModes(0, texture);
  }

  static void make_glow(osg::StateSet& state, const Material& material) {
    osg::ref_ptr<osg::Material> m = new osg::Material;
    m->setName(material.name);
    m->setAmbient(osg::Material::FRONT_AND_BACK, {0, 0, 0, 1});
    m->setDiffuse(osg::Material::FRONT_AND_BACK, {0, 0, 0, 1});
    m->setEmission(osg::Material::FRONT_AND_BACK, color(code(vec3_of(material.desc.emissive))));
    state.setAttributeAndModes(m);
    state.setAttributeAndModes(new osg::BlendFunc(GL_ONE, GL_ONE));
    state.setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0, 1, false));
    state.setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
  }

  // Makes glass as it was blended then: dst = colour + dst * (1 - alpha), with the sphere map added to the lit colour.
  void make_glass(osg::StateSet& state, const Material& material) {
    const sideray_material_desc& d = material.desc;
    glm::vec3 passes(1.0f - d.base_color[3]), tint = code(vec3_of(d.base_color));
    if (d.transmission > 0.0f) {
      tint = code(vec3_of(d.attenuation_color));
      passes = vec3_of(d.base_color);
      if (d.thickness > 0.0f)
        for (int c = 0; c < 3; ++c) passes[c] *= std::pow(d.attenuation_color[c], d.thickness / d.attenuation_distance);
    }
    const float alpha = std::clamp(1.0f - luminance(code(passes)), 0.04f, 0.94f);
    osg::ref_ptr<osg::Material> m = new osg::Material;
    m->setName(material.name);
    m->setAmbient(osg::Material::FRONT_AND_BACK, color(tint * alpha));
    m->setDiffuse(osg::Material::FRONT_AND_BACK, color(tint * alpha, alpha));
    m->setSpecular(osg::Material::FRONT_AND_BACK, color(glm::vec3(0.8f)));
    m->setShininess(osg::Material::FRONT_AND_BACK, 90.0f);
    state.setAttributeAndModes(m);
    state.setAttributeAndModes(new osg::BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA));
    state.setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0, 1, false));
    state.setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
    if (!images_["sheen"]) images_["sheen"] = sheen();
    osg::ref_ptr<osg::TexGen> sphere = new osg::TexGen;
    sphere->setMode(osg::TexGen::SPHERE_MAP);
    state.setTextureAttributeAndModes(0, new osg::Texture2D(images_["sheen"]));
    state.setTextureAttribute(0, sphere);
    for (const GLenum coordinate : {GL_TEXTURE_GEN_S, GL_TEXTURE_GEN_T}) state.setTextureMode(0, coordinate, on);
    state.setTextureAttributeAndModes(0, new osg::TexEnv(osg::TexEnv::ADD));
  }

  const Content& content_;
  std::vector<osg::ref_ptr<osg::StateSet>> states_;
  std::map<std::pair<uint32_t, uint32_t>, osg::ref_ptr<osg::Geode>> geodes_;
  std::map<std::string, osg::ref_ptr<osg::Image>> images_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("usage: retrofit_scene FOLDER");
  const std::string folder = argv[1];
  std::filesystem::create_directories(folder);
  const Content content = sideray::retrofit::make_terrace();
  SceneWriter writer(content);
  const osg::ref_ptr<osg::Group> root = writer.make();
  writer.write_images(folder);
  // Five digits are a tenth of a millimetre here, and half the file.
  const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("WriteImageHint=UseExternal Precision=6");
  if (!osgDB::writeNodeFile(*root, folder + "/terrace.osgt", options))
    throw std::runtime_error(folder + "/terrace.osgt: cannot be written; are OpenSceneGraph's plugins installed?");
} catch (const std::exception& error) {
  std::fprintf(stderr, "retrofit_scene: %s\n", error.what());
  return 1;
}
