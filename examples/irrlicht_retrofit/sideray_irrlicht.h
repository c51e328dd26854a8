// Adds ray-traced glass and shadows to an Irrlicht 1.8 scene with the fixed function, in one file to copy. It follows
// the scene graph, and is the scene's light manager, so that it can run between the opaque and the transparent pass. On
// the thread that draws.
#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>
#include <irrlicht/irrlicht.h>

#include <cstring>
#include <map>
#include <optional>
#include <sideray/scene_follower.hpp>

namespace sideray_irrlicht {

using namespace irr;
using video::SMaterial;

struct Settings {
  bool wait = true;           // for this frame's rays; otherwise the frame shows the newest answers
  float budget_ms = 0;        // 0: no limit
  bool shadows = true;        // of the lights that have CastShadows
  float reflectance = 0.35f;  // of glass at normal incidence, before its alpha scales it
};

inline constexpr u32 stencil_bits = 0x3f /* as sideray_frame_defaults() */, first_unit = 8, position_unit = 7;

inline void* get_proc_address(void*, const char* name) {
  return reinterpret_cast<void*>(glXGetProcAddress(reinterpret_cast<const GLubyte*>(name)));
}
inline uint64_t key_of(const void* thing, uint64_t part = 0) {
  return reinterpret_cast<uintptr_t>(thing) * 0x9e3779b97f4a7c15u + part;
}
inline void set_color(float (&to)[3], video::SColorf from) { to[0] = from.r, to[1] = from.g, to[2] = from.b; }

// Sets the uniforms of the ready programs when they draw. Irrlicht keeps it as long as its driver exists.
class Programs : public video::IShaderConstantSetCallBack {
 public:
  sideray::Service* service = nullptr;
  void OnSetMaterial(const SMaterial& material) override { drawn_ = &material; }
  void OnSetConstants(video::IMaterialRendererServices* services, s32 which) override {
    if (!service) return;
    GLint program = 0;
    glGetIntegerv(GL_CURRENT_PROGRAM, &program);
    service->bind(static_cast<uint32_t>(program), first_unit);
    const s32 unit = 0, textured = drawn_->getTexture(0) ? 1 : 0, light = static_cast<s32>(drawn_->MaterialTypeParam2);
    const f32 in_shade[] = {0.5f, 0.5f, 0.55f};  // the ambient light and other lamps that remain, an estimate
    if (which == SIDERAY_READY_SHADOWS) {
      services->setPixelShaderConstant("sideray_light", &light, 1);
      services->setPixelShaderConstant("sideray_in_shade", in_shade, 3);
    } else {
      services->setPixelShaderConstant("sideray_texture", &unit, 1);
      services->setPixelShaderConstant("sideray_textured", &textured, 1);
      services->setPixelShaderConstant("sideray_surface", &drawn_->MaterialTypeParam2, 1);
    }
  }

 private:
  const SMaterial* drawn_ = nullptr;
};

class Retrofit : public scene::ILightManager {
 public:
  Retrofit(IrrlichtDevice& device, const Settings& settings)
      : device_(device), driver_(*device.getVideoDriver()), settings_(settings), programs_(new Programs) {
    glass_type_ = add_program(SIDERAY_READY_GLASS_FRAGMENT, video::EMT_TRANSPARENT_VERTEX_ALPHA);
    shadow_type_ = add_program(SIDERAY_READY_SHADOWS, video::EMT_ONETEXTURE_BLEND);
    inputs_.frame.budget_ms = settings.budget_ms;
    inputs_.layers->float_ids = 1, inputs_.layers->ray_reuse = 1.0f / 64;  // ready programs use GLSL 1.20
    update();
    tracer_.emplace(sideray::Tracer::create(scene_).value());
    const sideray_host_gl host{sizeof(host), get_proc_address, nullptr};
    programs_->service = &service_.emplace(sideray::Service::create(*tracer_, host).value());
    device_.getSceneManager()->setLightManager(this);
  }
  // Restores the engine's materials, so that it draws as before.
  ~Retrofit() override {
    device_.getSceneManager()->setLightManager(nullptr);
    programs_->service = nullptr, programs_->drop();
    for (auto& [at, material] : own_) at.first->getMaterial(at.second) = material;
  }

  // Follows changes of the scene graph; call it before each drawAll().
  void update() {
    glass_.clear(), lights_.clear(), casters_.clear();
    follower_.begin();
    follow(*device_.getSceneManager()->getRootSceneNode());
    set_lights();
    follower_.end();
  }
  void set_wait(bool wait) { settings_.wait = wait; }
  // Returns the reason why the retrofit stopped, or an empty string. Destroy it if there is a reason.
  const std::string& error() const { return error_; }
  // Returns statistics of the newest finished frame.
  const sideray_frame_stats& stats() const { return stats_; }

 private:
  using Place = std::pair<scene::ISceneNode*, u32>;  // a node's mesh buffer
  using Follower = sideray::SceneFollower;

  s32 add_program(sideray_ready_program which, video::E_MATERIAL_TYPE base) {
    return driver_.getGPUProgrammingServices()->addHighLevelShaderMaterial(
        sideray_ready_vertex(which), "main", video::EVST_VS_1_1, sideray_ready_fragment(which), "main",
        video::EPST_PS_1_1, programs_, base, which);
  }

  // These functions copy the scene graph to Sideray.

  void follow(scene::ISceneNode& node) {
    if (!node.isVisible()) return;
    node.updateAbsolutePosition();
    const scene::ESCENE_NODE_TYPE type = node.getType();
    if (type == scene::ESNT_LIGHT) follow_light(static_cast<scene::ILightSceneNode&>(node));
    if (type == scene::ESNT_ANIMATED_MESH) {
      auto& animated = static_cast<scene::IAnimatedMeshSceneNode&>(node);
      const auto frame = static_cast<s32>(animated.getFrameNr());
      follow_mesh(node, *animated.getMesh()->getMesh(frame), &node, static_cast<u32>(frame));
    } else if (type == scene::ESNT_MESH || type == scene::ESNT_CUBE || type == scene::ESNT_SPHERE) {
      scene::IMesh* mesh = static_cast<scene::IMeshSceneNode&>(node).getMesh();
      follow_mesh(node, *mesh, mesh, 0);
    }
    for (scene::ISceneNode* child : node.getChildren()) follow(*child);
  }

  // The frames of an animation are poses of one mesh, whose owner is the node. In a left-handed engine where clockwise
  // triangles face front, transforms and triangles need no conversion.
  void follow_mesh(scene::ISceneNode& node, const scene::IMesh& mesh, const void* owner, u32 pose) {
    const core::matrix4& m = node.getAbsoluteTransformation();
    for (u32 i = 0; i < mesh.getMeshBufferCount(); ++i) {
      const auto own = own_.find({&node, i});
      const SMaterial& material = own != own_.end() ? own->second : node.getMaterial(i);
      const bool glass = material.MaterialType == video::EMT_TRANSPARENT_VERTEX_ALPHA;
      sideray_instance_desc desc{};
      desc.mesh = mesh_of(*mesh.getMeshBuffer(i), key_of(owner, i), pose);
      desc.material = material_of(key_of(&node, i), material, glass);
      for (u32 k = 0; k < 12; ++k) desc.world_from_object[k] = static_cast<double>(m[k / 3 * 4 + k % 3]);
      desc.surface_id = glass ? make_glass({&node, i}, *mesh.getMeshBuffer(i)) : 0;
      desc.visibility = SIDERAY_VISIBLE_ALL;
      follower_.instance(key_of(&node, i), desc);
    }
  }

  sideray_mesh mesh_of(const scene::IMeshBuffer& buffer, uint64_t key, u32 pose) {
    return follower_.mesh(key, buffer.getIndexCount(), pose, [&] {
      const size_t stride = video::getVertexPitchFromType(buffer.getVertexType());
      const auto* first = static_cast<const video::S3DVertex*>(buffer.getVertices());
      sideray_mesh_desc desc = sideray_mesh_defaults();
      desc.vertex_count = buffer.getVertexCount(), desc.index_count = buffer.getIndexCount();
      desc.short_indices = buffer.getIndices();
      desc.positions = {&first->Pos.X, stride}, desc.normals = {&first->Normal.X, stride};
      desc.uv0 = {&first->TCoords.X, stride};
      desc.color_bytes = reinterpret_cast<const uint8_t*>(&first->Color);
      desc.color_bytes_stride = stride, desc.color_bytes_bgra = 1;
      return desc;
    });
  }

  sideray_texture texture_of(video::ITexture* texture) {
    if (!texture || texture->getColorFormat() != video::ECF_A8R8G8B8) return 0;
    std::vector<uint8_t> rgba;
    return follower_.texture(key_of(texture), 1, [&] {
      const core::dimension2du size = texture->getSize();
      rgba.resize(size_t{4} * size.Width * size.Height);
      std::memcpy(rgba.data(), texture->lock(video::ETLM_READ_ONLY), rgba.size());
      texture->unlock();
      for (size_t i = 0; i < rgba.size(); i += 4) std::swap(rgba[i], rgba[i + 2]);
      return Follower::Texels{size.Width, size.Height, SIDERAY_RGBA8, rgba.data()};
    });
  }

  sideray_material material_of(uint64_t key, const SMaterial& from, bool glass) {
    // Indexed by E_COLOR_MATERIAL.
    constexpr uint32_t follows[] = {0, SIDERAY_FOLLOW_DIFFUSE, SIDERAY_FOLLOW_AMBIENT, SIDERAY_FOLLOW_EMISSION,
                                    SIDERAY_FOLLOW_SPECULAR, SIDERAY_FOLLOW_AMBIENT_AND_DIFFUSE};
    uint64_t version = key_of(from.getTexture(0)) + (from.Lighting ? 8 : 0) + (from.BackfaceCulling ? 16 : 0);
    for (const u32 word : {from.AmbientColor.color, from.DiffuseColor.color, from.EmissiveColor.color,
                           from.SpecularColor.color, static_cast<u32>(256 * from.Shininess), u32{from.ColorMaterial}})
      version = version * 0x100000001b3u ^ word;
    const sideray_texture texture = texture_of(from.getTexture(0));
    return follower_.material(key, version, [&] {
      Follower::Material m;
      m.desc.base_color_texture.texture = texture;
      m.desc.base_color[3] = video::SColorf(from.DiffuseColor).a;
      m.desc.unlit = !from.Lighting, m.desc.double_sided = !from.BackfaceCulling;
      m.desc.alpha_mode = glass ? SIDERAY_BLEND : SIDERAY_OPAQUE;
      sideray_fixed_material& fixed = m.fixed.emplace(sideray_fixed_material_defaults());
      set_color(fixed.ambient, from.AmbientColor), set_color(fixed.diffuse, from.DiffuseColor);
      set_color(fixed.emission, from.EmissiveColor);
      if (from.Shininess > 0) set_color(fixed.specular, from.SpecularColor);  // Irrlicht draws no highlight without an
                                                                              // exponent
      fixed.shininess = core::min_(from.Shininess, 128.0f);
      fixed.follows_color = follows[from.ColorMaterial];
      for (float& r : fixed.reflectance) r = glass ? settings_.reflectance : 0;
      fixed.fresnel = glass;
      return m;
    });
  }

  // Gives glass the ready program, which draws as before where there is no answer, and returns its surface id, which
  // the material carries to the program.
  uint32_t make_glass(Place place, const scene::IMeshBuffer& buffer) {
    glass_.emplace_back(place, &buffer);
    const uint32_t id = ids_.try_emplace(place, static_cast<uint32_t>(ids_.size() + 1)).first->second;
    SMaterial& material = place.first->getMaterial(place.second);
    if (material.MaterialType != glass_type_) own_.insert_or_assign(place, material);
    material.MaterialType = static_cast<video::E_MATERIAL_TYPE>(glass_type_);
    material.MaterialTypeParam2 = static_cast<f32>(id);
    return id;
  }

  void follow_light(scene::ILightSceneNode& node) {
    const video::SLight& from = node.getLightData();
    const bool distant = from.Type == video::ELT_DIRECTIONAL;
    const core::vector3df at = distant ? -from.Direction : node.getAbsolutePosition();
    sideray_fixed_light& light = lights_.emplace_back(sideray_fixed_light_defaults());
    set_color(light.ambient, from.AmbientColor), set_color(light.diffuse, from.DiffuseColor);
    set_color(light.specular, from.SpecularColor);
    std::copy_n(&at.X, 3, light.position), std::copy_n(&from.Direction.X, 3, light.spot_direction);
    light.position[3] = distant ? 0 : 1;
    light.constant_attenuation = from.Attenuation.X;
    light.linear_attenuation = from.Attenuation.Y, light.quadratic_attenuation = from.Attenuation.Z;
    if (from.Type == video::ELT_SPOT) light.spot_cutoff_deg = from.OuterCone, light.spot_exponent = from.Falloff;
    light.casts_shadows = settings_.shadows && from.CastShadows;
    if (!light.casts_shadows) return;
    sideray_light& caster = casters_.emplace_back(sideray_light_defaults());
    caster.type = distant ? SIDERAY_LIGHT_DIRECTIONAL : SIDERAY_LIGHT_POINT;
    std::copy_n(light.position, 3, caster.position), std::copy_n(light.spot_direction, 3, caster.direction);
  }

  void set_lights() {
    sideray_fixed_function model = sideray_fixed_function_defaults();
    set_color(model.ambient, device_.getSceneManager()->getAmbientLight());
    std::string state(reinterpret_cast<const char*>(model.ambient), sizeof(model.ambient));
    state.append(reinterpret_cast<const char*>(lights_.data()), lights_.size() * sizeof(sideray_fixed_light));
    if (state == last_lighting_) return;
    last_lighting_ = state;
    model.local_viewer = model.separate_specular = 1;  // as Irrlicht configures OpenGL
    model.lights = lights_.data(), model.light_count = lights_.size();
    scene_.set_fixed_function(model);
    scene_.set_lights(casters_);
    follower_.commit_at_end();
    inputs_.masks.reset();
    if (!casters_.empty())
      inputs_.masks.emplace(sideray_mask_inputs_defaults()).shadow_lights = (1u << casters_.size()) - 1;
  }

  // These functions draw the frame.

  void OnPreRender(core::array<scene::ISceneNode*>&) override {}
  void OnPostRender() override {}
  void OnRenderPassPostRender(scene::E_SCENE_NODE_RENDER_PASS) override {}
  void OnNodePreRender(scene::ISceneNode*) override {}
  void OnNodePostRender(scene::ISceneNode*) override {}
  void OnRenderPassPreRender(scene::E_SCENE_NODE_RENDER_PASS pass) override {
    if (pass != scene::ESNRP_TRANSPARENT || !error_.empty()) return;
    try {
      draw_mask();
      set_view();
      submit_and_take();
      draw_shadows();
    } catch (const sideray::Error& error) {
      error_ = error.what();
    }
  }

  // Counts the glass in front of the opaque surface at each pixel.
  void draw_mask() const {
    glClearStencil(0), glClear(GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST), glStencilMask(stencil_bits);
    glStencilFunc(GL_NOTEQUAL, stencil_bits, stencil_bits), glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
    for (const auto& [place, buffer] : glass_) {
      SMaterial material = own_.at(place);
      material.ColorMask = video::ECP_NONE, material.ZWriteEnable = false;
      driver_.setMaterial(material);
      driver_.setTransform(video::ETS_WORLD, place.first->getAbsoluteTransformation());
      driver_.drawMeshBuffer(buffer);
    }
    glDisable(GL_STENCIL_TEST), glStencilMask(~0u);
  }

  // Passes OpenGL's view to Sideray, and makes OpenGL generate world positions as texture coordinates for glass.
  void set_view() {
    driver_.setTransform(video::ETS_WORLD, core::IdentityMatrix);
    double projection[16], view[16];
    glGetDoublev(GL_PROJECTION_MATRIX, projection), glGetDoublev(GL_MODELVIEW_MATRIX, view);
    sideray_view& to = inputs_.frame.view;
    sideray::check([&](sideray_error* e) { return sideray_view_from_matrices(projection, view, &to, e); });
    GLint unit = 0, viewport[4];
    glGetIntegerv(GL_ACTIVE_TEXTURE, &unit), glGetIntegerv(GL_VIEWPORT, viewport);
    glActiveTexture(GL_TEXTURE0 + position_unit);
    constexpr double planes[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    for (u32 i = 0; i < 3; ++i) {
      glTexGeni(GL_S + i, GL_TEXTURE_GEN_MODE, GL_EYE_LINEAR);  // planes of the world, because MODELVIEW is the view
      glTexGendv(GL_S + i, GL_EYE_PLANE, planes[i]), glEnable(GL_TEXTURE_GEN_S + i);
    }
    glActiveTexture(static_cast<GLenum>(unit));
    sideray_frame_source& source = inputs_.frame.source;
    source.x = viewport[0], source.y = viewport[1], source.width = viewport[2], source.height = viewport[3];
  }

  void submit_and_take() {
    std::optional<sideray_ticket> ticket;
    do service_->advance();
    while (!(ticket = service_->submit(inputs_)) && settings_.wait);
    if (settings_.wait) service_->wait(*ticket);
    if (ticket) inputs_.frame.continues = 1;
    if (const auto newest = service_->layers()) stats_ = service_->stats(newest->ticket);
  }

  // Multiplies the opaque picture by the shadows.
  void draw_shadows() {
    SMaterial material;
    material.MaterialType = static_cast<video::E_MATERIAL_TYPE>(shadow_type_);
    material.MaterialTypeParam = video::pack_textureBlendFunc(video::EBF_DST_COLOR, video::EBF_ZERO);
    material.ZBuffer = video::ECFN_NEVER, material.ZWriteEnable = false;
    material.BackfaceCulling = material.Lighting = false;
    for (size_t i = 0; i < casters_.size(); ++i) {
      material.MaterialTypeParam2 = static_cast<f32>(i);
      driver_.setMaterial(material);
      const u16 indices[] = {0, 1, 2, 0, 2, 3};
      video::S3DVertex corners[4];
      for (u32 k = 0; k < 4; ++k) corners[k].Pos = {k == 1 || k == 2 ? 1.0f : -1.0f, k < 2 ? -1.0f : 1.0f, 0.0f};
      driver_.drawIndexedTriangleList(corners, 4, indices, 2);
    }
  }

  IrrlichtDevice& device_;
  video::IVideoDriver& driver_;
  Settings settings_;
  sideray::Scene scene_ = sideray::Scene::create().value();
  Follower follower_{scene_};
  std::optional<sideray::Tracer> tracer_;
  std::optional<sideray::Service> service_;
  sideray::FrameInputs inputs_;  // its default mask is a count in the stencil
  sideray_frame_stats stats_{};
  std::string error_, last_lighting_;
  Programs* programs_;
  s32 glass_type_, shadow_type_;
  std::map<Place, uint32_t> ids_;
  std::map<Place, SMaterial> own_;                                  // the engine's own materials of glass
  std::vector<std::pair<Place, const scene::IMeshBuffer*>> glass_;  // of this frame
  std::vector<sideray_fixed_light> lights_;                         // of this frame; casters_ are those that cast
                                                                    // shadows
  std::vector<sideray_light> casters_;
};

}  // namespace sideray_irrlicht
