// Reads the textures of a glTF file as slots of materials. Each image is decoded once as sRGB and once as linear
// values, where both are used. Knows tinygltf and the image codecs. One thread.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "scenes/gltf/gltf.h"
#include "scenes/images/images.h"

namespace sideray::scenes::gltf {

enum class Colors { srgb, linear };

// Holds a textureInfo of the file; index -1 = none.
struct TextureUse {
  int index = -1;
  int uv_set = 0;
  tinygltf::ExtensionMap extensions;
};

// Holds the image of a textureInfo, before its pixels are read.
struct TextureSource {
  sideray_texture_slot slot;  // without a texture
  size_t image;
  std::string name;
};

// Returns the values of a KHR_texture_transform.
TextureTransform read_transform(const File& file, const tinygltf::Value& e);

class TextureReader {
 public:
  TextureReader(const File& file, Content& content) : file_(file), content_(content) {}

  // `user` names the material in an Error.
  sideray_texture_slot slot(const TextureUse& use, Colors colors, const std::string& user);
  std::optional<TextureSource> source(const TextureUse& use, const std::string& user) const;
  Decoded pixels(size_t image) const;
  Budget& budget() { return file_.budget; }
  // Adds a texture and returns its index + 1 in Content::textures.
  uint32_t add(Texture texture);

 private:
  std::string name_of_image(size_t index) const;
  size_t image_of(const tinygltf::Texture& texture, const std::string& user) const;
  void transform(const tinygltf::ExtensionMap& extensions, const std::string& user, sideray_texture_slot& slot,
                 int& uv_set) const;
  void sample(int index, sideray_texture_slot& slot, const std::string& user) const;
  uint32_t content_texture(const TextureSource& source, bool srgb);

  const File& file_;
  Content& content_;
  std::map<std::pair<size_t, bool>, uint32_t> kept_;  // (image, is sRGB) -> index + 1 into Content::textures
  uint64_t texels_ = 0;
};

}  // namespace sideray::scenes::gltf
