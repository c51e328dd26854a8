// Keeps the textures of a snapshot on the GPU: material images, environment, albedo table, and placeholders for missing
// ones. The context must be current.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Throws Failure (OUT_OF_MEMORY, GL_FAILED) where the driver reports that an allocation just failed.
void check_allocation(const Functions& gl, const char* what);

class RasterTextures {
 public:
  explicit RasterTextures(const Functions& gl);

  // Uploads the textures of `snapshot` that are not there yet, and frees those that it no longer uses.
  void set_scene(const model::Snapshot& snapshot);

  // Binds a texture; a white one where `texture` is null.
  void bind(uint32_t texture_unit, const model::Texture* texture, const sideray_texture_slot& slot);
  void bind_environment() const;
  // Binds arrays of one empty texel in place of a layer cache.
  void bind_empty_cache() const;
  // Returns a shadow map of one texel, for samplers without a map.
  uint32_t empty_shadow() const { return empty_shadow_.id(); }
  // Binds a texture without a sampler object, so that its own parameters apply.
  void bind_plain(uint32_t texture_unit, uint32_t target, uint32_t texture) const;

  float environment_last_level() const { return environment_last_level_; }

 private:
  struct Image {
    std::shared_ptr<const model::Texture> source;
    Texture texture;
  };
  uint32_t sampler(const sideray_texture_slot& slot);
  Texture upload(const model::Texture& source) const;
  void upload_level(const model::Texture::Level& level, int place, bool srgb) const;
  Texture upload_environment(std::span<const model::Environment::Image> levels, uint32_t format) const;
  Texture make_array(uint32_t internal_format, uint32_t format, uint32_t type) const;
  void set_environment(const std::shared_ptr<const model::Environment>& environment);

  const Functions& gl_;
  std::map<const model::Texture*, Image> images_;
  std::map<uint32_t, Sampler> samplers_;
  std::shared_ptr<const model::Environment> environment_;
  Texture white_, albedo_terms_, environment_specular_, environment_irradiance_;
  Texture empty_radiance_, empty_distance_, empty_surface_id_, empty_shadow_;
  float environment_last_level_ = 0;
  uint32_t largest_side_ = 0;
};

}  // namespace sideray::gl
