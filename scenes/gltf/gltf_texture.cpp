#include "scenes/gltf/gltf_texture.h"

#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"

namespace sideray::scenes::gltf {
namespace {

constexpr int gl_nearest = 9728, gl_linear = 9729;
constexpr int gl_clamp_to_edge = 33071, gl_mirrored_repeat = 33648;

sideray_texture_slot plain_slot() {
  sideray_texture_slot slot{};
  slot.texture_from_uv[0] = slot.texture_from_uv[3] = 1.0f;
  return slot;
}

// Returns the bytes of a data URI. tinygltf decodes only media types that it knows, not webp, and takes others for
// names of files.
std::vector<uint8_t> data_uri_bytes(const std::string& uri) {
  static constexpr const char* mark = ";base64,";
  const size_t at = uri.substr(0, 256).find(mark);
  std::vector<uint8_t> bytes;
  std::string media_type;
  if (at == std::string::npos) return bytes;
  const std::string known = "data:application/octet-stream" + uri.substr(at);
  tinygltf::DecodeDataURI(&bytes, media_type, known, 0, false);
  return bytes;
}

bool is_ktx(std::span<const uint8_t> bytes) {
  static constexpr uint8_t mark[] = {0xab, 'K', 'T', 'X', ' '};
  return bytes.size() > std::size(mark) && std::equal(std::begin(mark), std::end(mark), bytes.begin());
}

// Returns the remedy for KTX2 images: neither Debian nor a package registry has a library that decodes them.
// docs/gltf.md says what the command needs.
std::string ktx_remedy(const std::string& path) {
  return fmt::format("convert it by `npx @gltf-transform/cli ktxdecompress {} decoded.glb` (docs/gltf.md, KTX2)", path);
}

}  // namespace

sideray_texture_slot TextureReader::slot(const TextureUse& use, Colors colors, const std::string& user) {
  std::optional<TextureSource> found = source(use, user);
  if (!found) return plain_slot();
  found->slot.texture = content_texture(*found, colors == Colors::srgb);
  return found->slot;
}

std::optional<TextureSource> TextureReader::source(const TextureUse& use, const std::string& user) const {
  if (use.index < 0) return std::nullopt;
  const auto& textures = file_.model.textures;
  const tinygltf::Texture& texture = textures[checked_index(file_, use.index, textures.size(), "texture", user)];
  // glTF 2.0 does not define a texture without a source.
  if (texture.source < 0 && texture.extensions.empty()) {
    content_.warnings.push_back(fmt::format("{}: texture {} has no image; its factor is used", user, use.index));
    return std::nullopt;
  }
  TextureSource source{plain_slot(), image_of(texture, user), texture.name};
  int uv_set = use.uv_set;
  transform(use.extensions, user, source.slot, uv_set);
  if (uv_set < 0 || uv_set > 1) {
    content_.warnings.push_back(
        fmt::format("{}: a texture uses TEXCOORD_{}, and 0 and 1 are read; its factor is used", user, uv_set));
    return std::nullopt;
  }
  source.slot.uv_set = static_cast<uint32_t>(uv_set);
  if (texture.sampler >= 0) sample(texture.sampler, source.slot, user);
  return source;
}

// Returns the image of a texture; EXT_texture_webp has precedence over the fallback in the texture itself.
size_t TextureReader::image_of(const tinygltf::Texture& texture, const std::string& user) const {
  int image = texture.source;
  if (const auto* e = extension(texture.extensions, "EXT_texture_webp")) {
    image = static_cast<int>(std::clamp(number(file_, *e, "source", -1.0), -1.0, 2e9));
  }
  if (const auto* e = extension(texture.extensions, "KHR_texture_basisu"); e != nullptr && image < 0) {
    const int compressed = static_cast<int>(std::clamp(number(file_, *e, "source", -1.0), -1.0, 2e9));
    const size_t index = checked_index(file_, compressed, file_.model.images.size(), "image", user);
    refuse("cannot read {}: it is KTX2, which no decoder is built in for, and {} uses it; {}", name_of_image(index),
           user, ktx_remedy(file_.path));
  }
  if (image < 0) {
    refuse("cannot read {}: {} uses a texture without a PNG, JPEG or WebP image; use a decoded copy", file_.path, user);
  }
  return checked_index(file_, image, file_.model.images.size(), "image", user);
}

TextureTransform read_transform(const File& file, const tinygltf::Value& e) {
  const std::vector<double> offset = numbers(file, e, "offset", {0, 0}), scale = numbers(file, e, "scale", {1, 1});
  return {{offset[0], offset[1]}, {scale[0], scale[1]}, number(file, e, "rotation", 0.0)};
}

void TextureReader::transform(const tinygltf::ExtensionMap& extensions, const std::string& user, sideray_texture_slot& slot,
                              int& uv_set) const {
  const tinygltf::Value* e = extension(extensions, "KHR_texture_transform");
  if (e == nullptr) return;
  const std::array<double, 6> texture_from_uv = scenes::texture_from_uv(read_transform(file_, *e));
  for (int i = 0; i < 6; ++i) {
    const double number = texture_from_uv[static_cast<size_t>(i)];
    if (!(std::abs(number) <= limits::coordinate))
      refuse("cannot read {}: {} has a KHR_texture_transform with numbers beyond 1e15; correct it", file_.path, user);
    slot.texture_from_uv[i] = static_cast<float>(number);
  }
  uv_set = static_cast<int>(std::clamp(number(file_, *e, "texCoord", uv_set), -1.0, 2e9));
}

void TextureReader::sample(int index, sideray_texture_slot& slot, const std::string& user) const {
  const auto& samplers = file_.model.samplers;
  const tinygltf::Sampler& sampler = samplers[checked_index(file_, index, samplers.size(), "sampler", user)];
  const auto wrap = [](int mode) {
    if (mode == gl_clamp_to_edge) return SIDERAY_CLAMP;
    return mode == gl_mirrored_repeat ? SIDERAY_MIRROR : SIDERAY_REPEAT;
  };
  slot.wrap_u = wrap(sampler.wrapS);
  slot.wrap_v = wrap(sampler.wrapT);
  if (sampler.magFilter == gl_nearest || sampler.minFilter == gl_nearest)
    slot.filter = SIDERAY_NEAREST;
  else if (sampler.minFilter == gl_linear)
    slot.filter = SIDERAY_BILINEAR;
}

uint32_t TextureReader::content_texture(const TextureSource& source, bool srgb) {
  // Only successful reads are kept: a broken picture is an error again for the next material that uses it.
  if (const auto found = kept_.find({source.image, srgb}); found != kept_.end()) return found->second;
  Texture texture;
  texture.name = !source.name.empty() ? source.name : file_.model.images[source.image].name;
  if (texture.name.empty()) texture.name = fmt::format("image{}", source.image);
  texture.srgb = srgb;
  if (const auto other = kept_.find({source.image, !srgb}); other != kept_.end()) {
    const Texture& same = content_.textures[other->second - 1];
    file_.budget.take(same.rgba.size(), texture.name);
    texture.width = same.width, texture.height = same.height, texture.rgba = same.rgba;
  } else {
    Decoded decoded = pixels(source.image);
    texture.width = decoded.width, texture.height = decoded.height, texture.rgba = std::move(decoded.rgba);
  }
  return kept_[{source.image, srgb}] = add(std::move(texture));
}

Decoded TextureReader::pixels(size_t index) const {
  if (const auto broken = file_.broken_images.find(index); broken != file_.broken_images.end())
    throw Error(SIDERAY_INVALID_ARGUMENT, broken->second);
  const tinygltf::Image& image = file_.model.images[index];
  const bool is_data = image.uri.starts_with("data:");
  const std::string what = name_of_image(index);
  const std::vector<uint8_t> data = is_data ? data_uri_bytes(image.uri) : std::vector<uint8_t>{};
  if (is_data && data.empty()) refuse("cannot read {}: its data URI holds no base64; export it again", what);
  const std::vector<uint8_t>& bytes = is_data ? data : image.image;
  if (is_ktx(bytes))
    refuse("cannot read {}: it is KTX2, which no decoder is built in for; {}", what, ktx_remedy(file_.path));
  return decode_image(bytes, what, &file_.budget);
}

std::string TextureReader::name_of_image(size_t index) const {
  const tinygltf::Image& image = file_.model.images[index];
  const std::string& name = image.uri.empty() || image.uri.starts_with("data:") ? image.name : image.uri;
  return fmt::format("image {}{}{} of {}", index, name.empty() ? "" : " ", name, file_.path);
}

uint32_t TextureReader::add(Texture texture) {
  texels_ += uint64_t{texture.width} * texture.height;
  if (texels_ > limits::texels) {
    refuse("cannot read {}: its textures have more than {} texels; use smaller pictures", file_.path, limits::texels);
  }
  content_.textures.push_back(std::move(texture));
  return static_cast<uint32_t>(content_.textures.size());
}

}  // namespace sideray::scenes::gltf
