// A host with a wall, a plate that shades it, and a pane of glass, with depth in every place that the service reads and
// textures for every input. Its picture does not matter, only its requests of the service. Test support.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "embed/hosts/frame_outputs.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"
#include "gl/resources/state_guard.h"

namespace sideray::tests {

class SmallHost {
 public:
  static constexpr int width = 56, height = 40;
  static constexpr uint32_t glass_id = 5;
  struct Case {
    const char* name;
    void (*ask)(const SmallHost&, FrameInputs&);
  };

  explicit SmallHost(std::unique_ptr<gl::Context> context)
      : context_(std::move(context)), gl(context_->functions()), own_(gl) {
    context_->make_current();
    fill_textures();
    clear_depths();
    create_scene();
    tracer_.emplace(sideray::Tracer::create(*scene_).value());
  }
  ~SmallHost() {
    own_.reset();
    context_->release_current();
  }
  SmallHost(const SmallHost&) = delete;
  SmallHost& operator=(const SmallHost&) = delete;

  static glm::dmat4 clip_from_world(double eye_x = 0) {
    return glm::perspective(0.9, double{width} / height, 0.1, 50.0) *
           glm::translate(glm::dmat4(1.0), glm::dvec3(-eye_x, 0, -3));
  }
  static void set_view(FrameInputs& in, const glm::dmat4& clip) {
    const glm::dmat4 world = glm::inverse(clip);
    std::memcpy(in.frame.view.clip_from_world, glm::value_ptr(clip), sizeof(in.frame.view.clip_from_world));
    std::memcpy(in.frame.view.world_from_clip, glm::value_ptr(world), sizeof(in.frame.view.world_from_clip));
  }
  FrameInputs inputs() const {
    FrameInputs in;
    set_view(in, clip_from_world());
    in.frame.source.framebuffer = own_->framebuffer.id();
    in.frame.source.width = width;
    in.frame.source.height = height;
    in.layers->max_layers = 2;
    return in;
  }
  static const std::vector<Case>& cases();

  // Returns every meaningful texel of the outputs; of layers without a surface only the distance is. Keeps all state.
  std::vector<uint8_t> texels(const FrameOutputs& out) const {
    std::vector<uint8_t> bytes;
    const auto append = [&](const std::vector<uint8_t>& more) { bytes.insert(bytes.end(), more.begin(), more.end()); };
    if (out.layers) append(texels(*out.layers));
    if (out.masks) append(texels(*out.masks));
    if (out.reflections) append(texels(*out.reflections));
    return bytes;
  }
  std::vector<uint8_t> texels(const sideray_layer_outputs& out) const {
    const gl::PixelTransferGuard transfer(gl);
    const gl::TextureGuard textures(gl, 0, 1);
    gl.ActiveTexture(GL_TEXTURE0);
    const bool cache = out.mode == SIDERAY_CACHE;
    const GLenum colour = cache ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    std::vector<uint8_t> bytes = read(colour, out.distance_texture, cache ? GL_RED : GL_RGBA, GL_FLOAT);
    std::vector<uint8_t> radiance = read(colour, out.radiance_texture, GL_RGBA, GL_FLOAT), ids;
    if (out.surface_id_texture != 0) {
      gl.BindTexture(GL_TEXTURE_2D_ARRAY, out.surface_id_texture);
      GLint type = 0;
      gl.GetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, 0, GL_TEXTURE_RED_TYPE, &type);
      const bool floats = type == GL_FLOAT;
      ids = read(GL_TEXTURE_2D_ARRAY, out.surface_id_texture, floats ? GL_RED : GL_RED_INTEGER,
                 floats ? GL_FLOAT : GL_UNSIGNED_INT);
    }
    if (cache) {
      clear_where_nothing_is(bytes, radiance);
      clear_where_nothing_is(bytes, ids);
    }
    bytes.insert(bytes.end(), radiance.begin(), radiance.end());
    bytes.insert(bytes.end(), ids.begin(), ids.end());
    return bytes;
  }
  std::vector<uint8_t> texels(const sideray_mask_outputs& out) const {
    const gl::PixelTransferGuard transfer(gl);
    const gl::TextureGuard textures(gl, 0, 1);
    gl.ActiveTexture(GL_TEXTURE0);
    std::vector<uint8_t> bytes = read(GL_TEXTURE_2D_ARRAY, out.shadow_texture, GL_RED, GL_UNSIGNED_BYTE);
    const std::vector<uint8_t> open = read(GL_TEXTURE_2D, out.ao_texture, GL_RED, GL_UNSIGNED_BYTE);
    bytes.insert(bytes.end(), open.begin(), open.end());
    return bytes;
  }
  std::vector<uint8_t> texels(const sideray_reflection_outputs& out) const {
    const gl::PixelTransferGuard transfer(gl);
    const gl::TextureGuard textures(gl, 0, 1);
    gl.ActiveTexture(GL_TEXTURE0);
    return read(GL_TEXTURE_2D, out.reflection_texture, GL_RGBA, GL_FLOAT);
  }

  // Returns how two results of texels() differ; "" where they do not.
  static std::string difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    if (a.size() != b.size()) return std::to_string(a.size()) + " bytes, not " + std::to_string(b.size());
    size_t count = 0, first = 0;
    for (size_t i = a.size(); i-- > 0;)
      if (a[i] != b[i]) ++count, first = i;
    if (count == 0) return "";
    return std::to_string(count) + " of " + std::to_string(a.size()) + " bytes, the first at " + std::to_string(first);
  }

  gl::Context& context() const { return *context_; }
  sideray_tracer* tracer() const { return tracer_->get(); }
  sideray::Scene& scene() { return *scene_; }
  sideray_instance pane() const { return pane_; }
  sideray_host_gl loader() const { return {sizeof(sideray_host_gl), gl::Context::get_proc_address, context_.get()}; }
  gl::Program program() const {
    return {gl, "host's", "#version 330\nvoid main() { gl_Position = vec4(0.0); }\n",
            std::string("#version 330\n") + sideray_glsl(330) +
                "out vec4 c;\nvoid main() { c = vec4(sideray_translucent(vec3(0.5), vec3(gl_FragCoord), 5u) * "
                "sideray_shadow(0) * sideray_ao(), 1.0); }\n"};
  }

 private:
  struct Own {
    explicit Own(const gl::Functions& gl)
        : framebuffer(gl),
          sampled_framebuffer(gl),
          other(gl),
          depth(gl),
          sampled(gl),
          plain(gl),
          flat(gl),
          array(gl),
          sampled_texture(gl),
          mask(gl),
          rest(gl),
          normals(gl),
          motion(gl) {}
    gl::Framebuffer framebuffer, sampled_framebuffer, other;
    gl::Renderbuffer depth, sampled, plain;
    gl::Texture flat, array, sampled_texture, mask, rest, normals, motion;
  };

  static void clear_where_nothing_is(const std::vector<uint8_t>& distances, std::vector<uint8_t>& texels) {
    const size_t count = distances.size() / sizeof(float), each = count ? texels.size() / count : 0;
    for (size_t i = 0; i < count; ++i) {
      float distance = 0;
      std::memcpy(&distance, &distances[i * sizeof(float)], sizeof(float));
      if (distance == 0.0f) std::fill_n(texels.begin() + static_cast<std::ptrdiff_t>(i * each), each, uint8_t{0});
    }
  }

  // Reads a texture; empty where there is none.
  std::vector<uint8_t> read(GLenum target, uint32_t texture, GLenum format, GLenum type) const {
    if (texture == 0) return {};
    EXPECT_EQ(gl.IsTexture(texture), GL_TRUE);
    gl.BindTexture(target, texture);
    GLint size[3] = {};
    gl.GetTexLevelParameteriv(target, 0, GL_TEXTURE_WIDTH, &size[0]);
    gl.GetTexLevelParameteriv(target, 0, GL_TEXTURE_HEIGHT, &size[1]);
    gl.GetTexLevelParameteriv(target, 0, GL_TEXTURE_DEPTH, &size[2]);
    const size_t texel = (format == GL_RGBA ? 4u : 1u) * (type == GL_UNSIGNED_BYTE ? 1u : 4u);
    std::vector<uint8_t> texels(texel * static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
                                static_cast<size_t>(size[2]));
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.GetTexImage(target, 0, format, type, texels.data());
    return texels;
  }

  template <size_t channels>
  void fill(const gl::Texture& texture, GLint internal, GLenum format, std::array<float, channels> value) const {
    std::vector<std::array<float, channels>> texels(size_t{width} * height, value);
    gl.BindTexture(GL_TEXTURE_2D, texture.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, GL_FLOAT, texels.data());
  }
  void fill_textures() const {
    fill<1>(own_->mask, GL_R8, GL_RED, {1.0f});
    fill<4>(own_->rest, GL_RGBA32F, GL_RGBA, {0.02f, 0.0f, 0.0f, 0.0f});
    fill<4>(own_->normals, GL_RGBA32F, GL_RGBA, {0.6f, 0.0f, 0.8f, 0.0f});
    fill<2>(own_->motion, GL_RG32F, GL_RG, {0.0f, 0.0f});
    gl.BindTexture(GL_TEXTURE_2D, own_->flat.id());
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH24_STENCIL8, width, height, 0, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8,
                  nullptr);
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, own_->array.id());
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, width, height, 2, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                  nullptr);
    gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, own_->sampled_texture.id());
    gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, 4, GL_DEPTH32F_STENCIL8, width, height, GL_TRUE);
    for (const GLenum target : {GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_2D_MULTISAMPLE})
      gl.BindTexture(target, 0);
  }

  // Clears to the wall's depth and a stencil of two layers.
  void clear(const gl::Framebuffer& framebuffer, GLenum attachment, const std::function<void(GLenum)>& attach) const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl.DrawBuffer(GL_NONE);
    gl.ReadBuffer(GL_NONE);
    attach(attachment);
    ASSERT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
    const glm::dvec4 clip = clip_from_world() * glm::dvec4(0, 0, 0, 1);
    gl.ClearDepth(0.5 + 0.5 * clip.z / clip.w);
    gl.ClearStencil(2);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }
  void clear_depths() const {
    const auto storage = [&](const gl::Renderbuffer& buffer, int samples, GLenum format) {
      return [&, samples, format](GLenum attachment) {
        gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
        gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
        gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
      };
    };
    clear(own_->framebuffer, GL_DEPTH_STENCIL_ATTACHMENT, storage(own_->depth, 0, GL_DEPTH24_STENCIL8));
    clear(own_->sampled_framebuffer, GL_DEPTH_STENCIL_ATTACHMENT, storage(own_->sampled, 4, GL_DEPTH24_STENCIL8));
    clear(own_->other, GL_DEPTH_ATTACHMENT, storage(own_->plain, 0, GL_DEPTH_COMPONENT16));
    clear(own_->other, GL_DEPTH_ATTACHMENT,
          [&](GLenum a) { gl.FramebufferTextureLayer(GL_FRAMEBUFFER, a, own_->array.id(), 0, 1); });
    clear(own_->other, GL_DEPTH_STENCIL_ATTACHMENT,
          [&](GLenum a) { gl.FramebufferTexture2D(GL_FRAMEBUFFER, a, GL_TEXTURE_2D, own_->flat.id(), 0); });
    clear(own_->other, GL_DEPTH_STENCIL_ATTACHMENT, [&](GLenum a) {
      gl.FramebufferTexture2D(GL_FRAMEBUFFER, a, GL_TEXTURE_2D_MULTISAMPLE, own_->sampled_texture.id(), 0);
    });
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.BindRenderbuffer(GL_RENDERBUFFER, 0);
  }

  void create_scene() {
    scene_.emplace(sideray::Scene::create().value());
    constexpr float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    constexpr uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 4, mesh.index_count = 6;
    mesh.positions.data = positions, mesh.indices = indices;
    sideray_material_desc material = sideray_material_defaults();
    material.double_sided = 1;
    sideray_instance_desc instance{};
    instance.mesh = scene_->add_mesh(mesh);
    instance.material = scene_->add_material(material);
    instance.visibility = SIDERAY_VISIBLE_ALL;
    const auto add = [&](double size, double z) {
      for (int i : {0, 4, 8}) instance.world_from_object[i] = size;
      instance.world_from_object[11] = z;
      pane_ = scene_->add_instances({&instance, 1}).front();
    };
    add(5.0, 0.0);
    add(0.4, 0.5);
    material.alpha_mode = SIDERAY_BLEND;
    material.base_color[3] = 0.5f;
    material.emissive[0] = 0.25f, material.emissive[1] = 0.5f;
    instance.material = scene_->add_material(material);
    instance.surface_id = glass_id;
    add(0.9, 1.0);
    sideray_light sun{};
    sun.size = sizeof(sun);
    sun.direction[0] = 0.8f, sun.direction[2] = -1.0f;
    sun.angular_diameter_deg = 20.0f;
    for (float& c : sun.intensity) c = 1.0f;
    scene_->set_lights({&sun, 1});
    scene_->commit();
  }

  std::unique_ptr<gl::Context> context_;

 public:
  const gl::Functions& gl;

 private:
  std::optional<Own> own_;
  std::optional<sideray::Scene> scene_;
  sideray_instance pane_ = 0;
  std::optional<sideray::Tracer> tracer_;
};

inline const std::vector<SmallHost::Case>& SmallHost::cases() {
  using In = FrameInputs;
  static constexpr std::array<uint8_t, size_t{width}* height> bytes = [] {
    std::array<uint8_t, size_t{width} * height> all{};
    all.fill(255);
    return all;
  }();
  // Adds masks of one light and the sky.
  static const auto add_masks = [](In& in) {
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    in.masks->ao_rays = 2;
  };
  static const auto masks_alone = [](In& in) {
    in.layers.reset();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    add_masks(in);
  };
  static const auto add_reflections = [](const SmallHost& h, In& in) {
    in.reflections = sideray_reflection_inputs_defaults();
    in.reflections->normal_texture = h.own_->normals.id();
    in.reflections->max_roughness = 0.5f;
  };
  static const std::vector<Case> all = {
      {"count in stencil", [](const SmallHost&, In&) {}},
      {"bit in stencil",
       [](const SmallHost&, In& in) {
         in.frame.source.mask = SIDERAY_MASK_STENCIL;
         in.frame.source.stencil_bits = 3;
       }},
      {"mask texture",
       [](const SmallHost& h, In& in) {
         in.frame.source.mask = SIDERAY_MASK_TEXTURE;
         in.frame.source.mask_texture = h.own_->mask.id();
       }},
      {"mask in memory",
       [](const SmallHost&, In& in) {
         in.frame.source.mask = SIDERAY_MASK_MEMORY;
         in.frame.source.mask_texels = bytes.data();
         in.frame.source.mask_row_bytes = width;
       }},
      {"depth texture", [](const SmallHost& h, In& in) { in.frame.source.depth_texture = h.own_->flat.id(); }},
      {"array layer",
       [](const SmallHost& h, In& in) {
         in.frame.source.mask = SIDERAY_MASK_NONE;
         in.frame.source.depth_texture = h.own_->array.id();
         in.frame.source.depth_layer = 1;
         in.frame.source.depth_texture_target = GL_TEXTURE_2D_ARRAY;
       }},
      {"renderbuffer, no mask",
       [](const SmallHost& h, In& in) {
         in.frame.source.mask = SIDERAY_MASK_NONE;
         in.frame.source.depth_renderbuffer = h.own_->plain.id();
       }},
      {"multisampled framebuffer",
       [](const SmallHost& h, In& in) { in.frame.source.framebuffer = h.own_->sampled_framebuffer.id(); }},
      {"multisampled texture",
       [](const SmallHost& h, In& in) {
         in.frame.source.depth_texture = h.own_->sampled_texture.id();
         in.frame.source.depth_texture_target = GL_TEXTURE_2D_MULTISAMPLE;
       }},
      {"masks", [](const SmallHost&, In& in) { masks_alone(in); }},
      {"masks of what moves",
       [](const SmallHost& h, In& in) {
         masks_alone(in);
         in.frame.source.motion_texture = h.own_->motion.id();
       }},
      {"inexact masks with a rest pose",
       [](const SmallHost& h, In& in) {
         masks_alone(in);
         in.masks->inexact = SIDERAY_INEXACT_RESTPOSE;
         in.masks->inexact_bits = 2;
         in.masks->rest_texture = h.own_->rest.id();
       }},
      {"reflections and layers", [](const SmallHost& h, In& in) { add_reflections(h, in); }},
      {"everything",
       [](const SmallHost& h, In& in) {
         add_masks(in);
         add_reflections(h, in);
       }},
      {"gamma space, float ids",
       [](const SmallHost&, In& in) {
         in.layers->radiance_space = SIDERAY_SPACE_GAMMA22;
         in.layers->radiance_scale = 2.0f;
         in.layers->float_ids = 1;
       }},
      {"composite", [](const SmallHost&, In& in) { in.layers->mode = SIDERAY_COMPOSITE; }},
      {"checkerboard", [](const SmallHost&, In& in) { in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD; }},
      {"a deadline that is never met", [](const SmallHost&, In& in) { in.frame.deadline_ms = 1e6f; }},
      {"another view", [](const SmallHost&, In& in) { in.frame.view_id = 1; }},
  };
  return all;
}

}  // namespace sideray::tests
