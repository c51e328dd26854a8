#include "retrofit.h"

#include <osg/BlendFunc>
#include <osg/ColorMask>
#include <osg/Depth>
#include <osg/GLExtensions>
#include <osg/Geometry>
#include <osg/Stencil>
#include <osg/TexGenNode>
#include <osg/Texture2D>
#include <osgUtil/CullVisitor>

#include <atomic>
#include <cstring>
#include <string>

#include "retrofit_shaders.h"

namespace {

// Render bins between bin 0 of opaque drawables and the sorted bin 10 of blended ones.
enum { mask_bin = 5, hook_bin = 6, shadow_bin = 7 };
constexpr unsigned stencil_bits = 0x3f, first_unit = 4, position_unit = 1, depth_unit = 3;
// The snippet's samplers with their units, in the order of sideray_service_bind. Until the first frame is bound no two
// may share a unit, because two samplers of different types on one unit make any draw an error.
struct Sampler {
  const char* name;
  unsigned unit;
};
constexpr Sampler samplers[] = {{"sideray_radiance", 0},     {"sideray_distance", 1}, {"sideray_surface_id", 2},
                                {"sideray_shadow_masks", 3}, {"sideray_ao_mask", 4},  {"sideray_mask_depth", 8}};
constexpr unsigned on = osg::StateAttribute::ON, off = osg::StateAttribute::OFF;
constexpr unsigned forced = osg::StateAttribute::OVERRIDE;

void* get_proc_address(void*, const char* name) {
  return osg::getGLExtensionFuncPtr(name);
}

osg::ref_ptr<osg::Program> program_of(const char* name, const std::string& vertex, const std::string& fragment) {
  osg::ref_ptr<osg::Program> program = new osg::Program;
  program->setName(name);
  if (!vertex.empty()) program->addShader(new osg::Shader(osg::Shader::VERTEX, vertex));
  program->addShader(
      new osg::Shader(osg::Shader::FRAGMENT, std::string("#version 130\n") + sideray_glsl(130) + fragment));
  return program;
}

unsigned handle_of(const osg::Program& program, osg::State& state) {
  program.compileGLObjects(state);
  return program.getPCP(state)->getHandle();
}

// Draws a glass drawable a second time, into the stencil only, to count the glass in front of the opaque surface.
class MaskCallback : public osg::DrawableCullCallback {
 public:
  MaskCallback() {
    osg::ref_ptr<osg::Stencil> count = new osg::Stencil;
    count->setFunction(osg::Stencil::NOTEQUAL, stencil_bits, stencil_bits);
    count->setOperation(osg::Stencil::KEEP, osg::Stencil::KEEP, osg::Stencil::INCR);
    count->setWriteMask(stencil_bits);
    state_->setAttributeAndModes(count, on | forced);
    state_->setAttributeAndModes(new osg::ColorMask(false, false, false, false), forced);
    state_->setAttributeAndModes(new osg::Program, forced);
    state_->setMode(GL_BLEND, off | forced);
    state_->setMode(GL_LIGHTING, off | forced);
    state_->setRenderBinDetails(mask_bin, "RenderBin", osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
    state_->setNestRenderBins(false);
  }
  bool cull(osg::NodeVisitor* visitor, osg::Drawable* drawable, osg::RenderInfo*) const override {
    osgUtil::CullVisitor* const cull = visitor->asCullVisitor();
    if (!cull || (drawable->isCullingActive() && cull->isCulled(drawable->getBoundingBox()))) return false;
    cull->pushStateSet(state_);
    cull->addDrawable(drawable, cull->getModelViewMatrix());
    cull->popStateSet();
    return false;
  }

 private:
  osg::ref_ptr<osg::StateSet> state_ = new osg::StateSet;
};

osg::ref_ptr<osg::Geometry> full_screen(const osg::Program& program) {
  osg::ref_ptr<osg::Geometry> quad = osg::createTexturedQuadGeometry({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  quad->setCullingActive(false);
  quad->setComputeBoundingBoxCallback(new osg::Drawable::ComputeBoundingBoxCallback);  // has no bounds
  osg::StateSet& state = *quad->getOrCreateStateSet();
  state.setAttributeAndModes(const_cast<osg::Program*>(&program));
  state.setAttributeAndModes(new osg::BlendFunc(GL_ZERO, GL_SRC_COLOR));
  state.setMode(GL_DEPTH_TEST, off);
  state.setMode(GL_CULL_FACE, off);
  state.setRenderBinDetails(shadow_bin, "RenderBin");
  return quad;
}

}  // namespace

// Draws nothing; OpenSceneGraph calls it when the opaque picture is finished.
class Retrofit::Hook : public osg::Drawable {
 public:
  Hook(const sideray::Scene& scene, const RetrofitSettings& settings, const osg::Program& glass,
       const osg::Program& shadow)
      : settings_(settings), glass_(&glass), shadow_(&shadow), tracer_(create_tracer(scene, settings.threads)) {
    setCullingActive(false);
    setUseDisplayList(false);
    getOrCreateStateSet()->setRenderBinDetails(hook_bin, "RenderBin");
    late_->set(!settings.wait);
    inputs_.frame.source.mask = SIDERAY_MASK_COUNT;
    inputs_.frame.source.stencil_bits = stencil_bits;
    inputs_.frame.budget_ms = settings.budget_ms;
    inputs_.layers->max_layers = settings.layers;
    inputs_.layers->ray_reuse = 1.0f / 64.0f;  // relative to white, which this engine displays as 1
    if (settings.shadows) {
      inputs_.masks = sideray_mask_inputs_defaults();
      inputs_.masks->shadow_lights = 1;
      inputs_.masks->moving = 1;
    }
  }

  // A failure stops the retrofit, not the engine.
  void drawImplementation(osg::RenderInfo& info) const override {
    if (!error_.empty()) return;
    try {
      draw(info);
    } catch (const sideray::Error& error) {
      error_ = error.what();
    }
  }

  // The pass that multiplies the shadows binds this texture, which is filled before that.
  osg::Texture2D& depth() const { return *depth_; }
  osg::Uniform& world_from_clip() const { return *world_from_clip_; }
  osg::Uniform& late() const { return *late_; }
  void set_wait(bool wait) {
    settings_.wait = wait;
    late_->set(!wait);
  }
  void set_budget(float milliseconds) { inputs_.frame.budget_ms = milliseconds; }
  sideray_frame_stats stats() const { return stats_; }
  sideray_ticket newest() const { return newest_; }
  const std::string& error() const { return error_; }
  void close() { service_.reset(); }

 private:
  void draw(osg::RenderInfo& info) const {
    osg::State& state = *info.getState();
    if (!service_) service_.emplace(sideray::Service::create(tracer_, host_).value());
    set_view(state, *info.getCurrentCamera());
    submit_and_take();
    keep_depth(state);
    for (const osg::Program* program : {glass_.get(), shadow_.get()})
      service_->bind(handle_of(*program, state), first_unit);
  }

  static sideray::Tracer create_tracer(const sideray::Scene& scene, uint32_t threads) {
    sideray_tracer_desc desc = sideray_tracer_defaults();
    desc.threads = threads;
    return sideray::Tracer::create(scene, desc).value();
  }

  static osg::ref_ptr<osg::Texture2D> create_depth() {
    osg::ref_ptr<osg::Texture2D> depth = new osg::Texture2D;
    depth->setInternalFormat(GL_DEPTH_COMPONENT24);
    depth->setFilter(osg::Texture::MIN_FILTER, osg::Texture::NEAREST);
    depth->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
    return depth;
  }

  void set_view(const osg::State& state, const osg::Camera& camera) const {
    // The viewport starts at 0, 0. The projection must be the one used for drawing, because OpenSceneGraph fits near
    // and far to the visible objects.
    const osg::Matrixd clip_from_world = camera.getViewMatrix() * state.getProjectionMatrix();
    const osg::Matrixd world_from_clip = osg::Matrixd::inverse(clip_from_world);
    // Row vectors in row-major order are column vectors in column-major order.
    sideray_view& view = inputs_.frame.view;
    std::memcpy(view.clip_from_world, clip_from_world.ptr(), sizeof(view.clip_from_world));
    std::memcpy(view.world_from_clip, world_from_clip.ptr(), sizeof(view.world_from_clip));
    const osg::Viewport& viewport = *camera.getViewport();
    sideray_frame_source& source = inputs_.frame.source;
    source.x = static_cast<int32_t>(viewport.x());
    source.y = static_cast<int32_t>(viewport.y());
    source.width = static_cast<int32_t>(viewport.width());
    source.height = static_cast<int32_t>(viewport.height());
    GLint framebuffer = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    source.framebuffer = static_cast<uint32_t>(framebuffer);
  }

  void keep_depth(osg::State& state) const {
    if (!settings_.shadows) return;
    const sideray_frame_source& source = inputs_.frame.source;
    if (depth_->getTextureWidth() != source.width || depth_->getTextureHeight() != source.height) {
      depth_->setTextureSize(source.width, source.height);
      depth_->dirtyTextureObject();
    }
    state.setActiveTextureUnit(depth_unit);
    depth_->copyTexImage2D(state, source.x, source.y, source.width, source.height);
    osg::Matrixd world_from_clip;
    const sideray_view& view = inputs_.frame.view;
    std::memcpy(world_from_clip.ptr(), view.world_from_clip, sizeof(view.world_from_clip));
    world_from_clip_->set(osg::Matrixf(world_from_clip));
  }

  void submit_and_take() const {
    service_->advance();
    std::optional<sideray_ticket> ticket = service_->submit(inputs_);
    // Without a ticket three frames are in flight. This frame shows the newest answers, or waits until it can be
    // submitted.
    while (!ticket && settings_.wait) {
      service_->advance();
      ticket = service_->submit(inputs_);
    }
    if (settings_.wait) service_->wait(*ticket);
    // This engine's view is continuous, so frames whose budget leaves out rays show older answers.
    if (ticket) inputs_.frame.continues = 1;
    // Layers are a frame's last job here, so that its statistics are complete.
    if (const auto newest = service_->layers()) {
      newest_ = newest->ticket;
      stats_ = service_->stats(newest_);
    }
  }

  RetrofitSettings settings_;
  osg::ref_ptr<const osg::Program> glass_, shadow_;
  sideray::Tracer tracer_;
  const sideray_host_gl host_{sizeof(sideray_host_gl), get_proc_address, nullptr};
  mutable std::optional<sideray::Service> service_;
  mutable sideray::FrameInputs inputs_;
  mutable sideray_frame_stats stats_{};
  mutable sideray_ticket newest_ = 0;
  mutable std::string error_;
  osg::ref_ptr<osg::Texture2D> depth_ = create_depth();
  osg::ref_ptr<osg::Uniform> world_from_clip_ = new osg::Uniform(osg::Uniform::FLOAT_MAT4, "world_from_clip");
  osg::ref_ptr<osg::Uniform> late_ = new osg::Uniform("late", false);
};

Retrofit::Retrofit(osgViewer::Viewer& viewer, osg::Group& root, const sideray_osg::SceneAdapter& adapter,
                   const RetrofitSettings& settings)
    : viewer_(viewer),
      root_(root),
      passes_(new osg::Group),
      glass_(adapter.glass()),
      glass_program_(program_of("glass by rays", "", glass_fragment)),
      shadow_program_(program_of("shadows by rays", shadow_vertex, shadow_fragment)) {
  const osg::ref_ptr<MaskCallback> mask = new MaskCallback;
  osg::ref_ptr<osg::TexGen> world_position = new osg::TexGen;
  world_position->setMode(osg::TexGen::EYE_LINEAR);  // eye planes are transformed when the view is set, which gives
                                                     // world positions
  for (const sideray_osg::Glass& glass : glass_) {
    glass.drawable->setCullCallback(mask);
    glass.own->getOrCreateStateSet()->addUniform(new osg::Uniform("surface", glass.surface_id));
    glass.blended->setAttributeAndModes(glass_program_);
    for (const GLenum coordinate : {GL_TEXTURE_GEN_S, GL_TEXTURE_GEN_T, GL_TEXTURE_GEN_R})
      glass.blended->setTextureMode(position_unit, coordinate, on);
  }
  osg::ref_ptr<osg::TexGenNode> positions = new osg::TexGenNode(world_position);
  positions->setTextureUnit(position_unit);
  hook_ = new Hook(adapter.scene(), settings, *glass_program_, *shadow_program_);
  passes_->addChild(positions);
  passes_->addChild(hook_);
  if (settings.shadows) {
    const osg::ref_ptr<osg::Geometry> multiply = full_screen(*shadow_program_);
    osg::StateSet& state = *multiply->getOrCreateStateSet();
    state.setTextureAttribute(depth_unit, &hook_->depth());
    state.addUniform(&hook_->world_from_clip());
    state.addUniform(&hook_->late());
    state.addUniform(new osg::Uniform("depth", static_cast<int>(depth_unit)));
    const sideray_osg::Lighting& light = adapter.lighting();
    state.addUniform(new osg::Uniform("toward_sun", light.toward_sun));
    state.addUniform(new osg::Uniform("sun", light.sun));
    state.addUniform(new osg::Uniform("ambient", light.ambient));
    passes_->addChild(multiply);
  }
  for (const Sampler& sampler : samplers)
    root_.getOrCreateStateSet()->addUniform(new osg::Uniform(sampler.name, static_cast<int>(first_unit + sampler.unit)));
  root_.addChild(passes_);
  viewer_.getCamera()->setClearMask(viewer_.getCamera()->getClearMask() | GL_STENCIL_BUFFER_BIT);
}

Retrofit::~Retrofit() {
  root_.removeChild(passes_);
  for (const Sampler& sampler : samplers) root_.getStateSet()->removeUniform(sampler.name);
  for (const sideray_osg::Glass& glass : glass_) {
    glass.drawable->setCullCallback(nullptr);
    glass.own->getStateSet()->removeUniform("surface");
    glass.blended->removeAttribute(osg::StateAttribute::PROGRAM);
    for (const GLenum coordinate : {GL_TEXTURE_GEN_S, GL_TEXTURE_GEN_T, GL_TEXTURE_GEN_R})
      glass.blended->removeTextureMode(position_unit, coordinate);
  }
  // Between frames OpenSceneGraph has no current context.
  osg::GraphicsContext* const context = viewer_.getCamera()->getGraphicsContext();
  context->makeCurrent();
  hook_->close();
  context->releaseContext();
}

void Retrofit::set_budget(float milliseconds) {
  hook_->set_budget(milliseconds);
}

void Retrofit::set_wait(bool wait) {
  hook_->set_wait(wait);
}

const std::string& Retrofit::error() const {
  return hook_->error();
}

sideray_ticket Retrofit::newest() const {
  return hook_->newest();
}

sideray_frame_stats Retrofit::stats() const {
  return hook_->stats();
}
