#include <draco/compression/config/compression_shared.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <algorithm>
#include <cstring>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

// Decodes KHR_draco_mesh_compression; only this file knows draco. A few bytes can ask for any size, so decoders are
// stopped where sizes become known: before the triangles and before the attributes.
namespace sideray::scenes::gltf {
namespace {

constexpr const char* draco_extension = "KHR_draco_mesh_compression";
constexpr uint64_t bytes_per_triangle = 96;  // corner table and its traversal, while decoding

// Bounds the decoded size of one primitive.
struct Bounds {
  uint64_t triangles = 0, vertices = 0;
  Budget& budget;
  uint64_t taken = 0;   // from the budget, as work space
  std::string refusal;  // why decoding was stopped; empty where it was not

  bool refuse_more(std::string why, std::string what_to_do = "export it again") {
    refusal = fmt::format("{}; {}", why, what_to_do);
    return false;
  }
  uint64_t most_vertices(uint32_t stored_triangles) const {
    return std::max(uint64_t{3} * stored_triangles, std::min(vertices, uint64_t{limits::accessor_elements}));
  }
  bool admit_triangles(uint32_t stored, uint32_t stored_vertices) {
    if (stored > triangles) {
      return refuse_more(fmt::format("holds {} triangles where the accessor has {}", stored, triangles));
    }
    // Each corner may have its own vertex. Unused vertices count too: some exporters keep them.
    if (most_vertices(stored) < stored_vertices)
      return refuse_more(fmt::format("holds {} vertices where the accessor has {}", stored_vertices, vertices));
    return take(uint64_t{stored} * bytes_per_triangle);
  }
  bool admit_attributes(const draco::PointCloud& cloud) {
    uint64_t vertex_bytes = 0;
    for (int i = 0; i < cloud.num_attributes(); ++i) {
      const draco::PointAttribute& a = *cloud.attribute(i);
      // Space for the values, and for the integers from which they are computed.
      vertex_bytes += uint64_t{static_cast<uint8_t>(a.num_components())} *
                      static_cast<uint64_t>(std::max(draco::DataTypeLength(a.data_type()), 0) + 4);
    }
    return take(vertex_bytes * cloud.num_points());
  }
  bool take(uint64_t count) {
    if (count > budget.left()) return refuse_more(budget.memory_reason(), budget.memory_remedy());
    budget.take(count, "Draco data");
    taken += count;
    return true;
  }
};

struct Sizes {
  uint32_t triangles = 0, vertices = 0;
};

// Reads the two counts ahead of the decoder: the edgebreaker method stores vertices first, the sequential one
// triangles.
bool peek(draco::DecoderBuffer at, bool vertices_first, Sizes& sizes) {
  uint32_t* const order[] = {vertices_first ? &sizes.vertices : &sizes.triangles,
                             vertices_first ? &sizes.triangles : &sizes.vertices};
  return draco::DecodeVarint(order[0], &at) && draco::DecodeVarint(order[1], &at);
}

// Reads one vertex number of an uncompressed triangle list, in as many bytes as the number of vertices needs.
bool read_corner(draco::DecoderBuffer& from, uint32_t vertices, uint32_t& corner) {
  uint8_t byte = 0;
  uint16_t word = 0;
  if (vertices < 256) return from.Decode(&byte) && (corner = byte, true);
  if (vertices < 65536) return from.Decode(&word) && (corner = word, true);
  return vertices < 1u << 21 ? draco::DecodeVarint(&corner, &from) : from.Decode(&corner);
}

// Decodes a compressed list, which holds twice the difference of each corner from the previous one, plus 1 where it is
// negative.
bool undo_distances(std::vector<uint32_t>& corners) {
  int64_t last = 0;
  for (uint32_t& corner : corners) {
    const int64_t distance = corner >> 1;
    last += (corner & 1) != 0 ? -distance : distance;
    if (last < 0 || last > INT32_MAX) return false;
    corner = static_cast<uint32_t>(last);
  }
  return true;
}

// Decodes the triangles of the sequential method as the library does, which however refuses more vertices than corners.
bool decode_sequential_triangles(const Sizes& sizes, draco::DecoderBuffer& from, draco::Mesh& mesh) {
  uint32_t passed = 0;
  uint8_t is_stored = 0;
  if (!draco::DecodeVarint(&passed, &from) || !draco::DecodeVarint(&passed, &from) || !from.Decode(&is_stored))
    return false;
  std::vector<uint32_t> corners(size_t{3} * sizes.triangles);
  const auto count = static_cast<uint32_t>(corners.size());
  if (is_stored != 0) {
    for (uint32_t& corner : corners)
      if (!read_corner(from, sizes.vertices, corner)) return false;
  } else if (!draco::DecodeSymbols(count, 1, &from, corners.data()) || !undo_distances(corners)) {
    return false;
  }
  for (size_t i = 0; i < corners.size(); i += 3)
    mesh.AddFace({draco::PointIndex(corners[i]), draco::PointIndex(corners[i + 1]), draco::PointIndex(corners[i + 2])});
  mesh.set_num_points(sizes.vertices);
  return true;
}

template <typename Decoder, bool vertices_first>
class Bounded : public Decoder {
 public:
  explicit Bounded(Bounds& bounds) : bounds_(bounds) {}

 protected:
  bool DecodeConnectivity() override {
    Sizes sizes;
    if (!peek(*this->buffer(), vertices_first, sizes)) return false;
    if (!bounds_.admit_triangles(sizes.triangles, sizes.vertices)) return false;
    if (!vertices_first && sizes.vertices > uint64_t{3} * sizes.triangles)
      return decode_sequential_triangles(sizes, *this->buffer(), *this->mesh());
    return Decoder::DecodeConnectivity();
  }
  bool DecodeAllAttributes() override {
    return bounds_.admit_attributes(*this->point_cloud()) && Decoder::DecodeAllAttributes();
  }

 private:
  Bounds& bounds_;
};

using BoundedEdgebreaker = Bounded<draco::MeshEdgebreakerDecoder, true>;
using BoundedSequential = Bounded<draco::MeshSequentialDecoder, false>;

// Returns false where the stream is damaged, or `bounds` stopped it.
bool decode(std::span<const uint8_t> bytes, Bounds& bounds, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::DracoHeader header;
  draco::DecoderBuffer ahead = buffer;
  if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) return false;
  if (header.encoder_type != draco::TRIANGULAR_MESH) return bounds.refuse_more("holds points instead of triangles");
  if (header.version_major != 2 || header.version_minor != 2) {
    return bounds.refuse_more(
        fmt::format("is of version {}.{} instead of 2.2", header.version_major, header.version_minor));
  }
  const draco::DecoderOptions options;
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) {
    return BoundedEdgebreaker(bounds).Decode(options, &buffer, &mesh).ok();
  }
  if (header.encoder_method != draco::MESH_SEQUENTIAL_ENCODING) return false;
  return BoundedSequential(bounds).Decode(options, &buffer, &mesh).ok();
}

// Packs the elements of an accessor tightly. Returns false where a value does not fit its type.
template <typename T>
bool pack_as(const draco::Mesh& mesh, const draco::PointAttribute& attribute, int8_t components,
             std::vector<uint8_t>& to) {
  std::vector<T> value(static_cast<size_t>(components));
  const size_t element = value.size() * sizeof(T);
  to.resize(element * mesh.num_points());
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
    if (index.value() >= attribute.size() || !attribute.ConvertValue<T>(index, components, value.data())) return false;
    std::memcpy(&to[i * element], value.data(), element);
  }
  return true;
}

bool pack(const draco::Mesh& mesh, const draco::PointAttribute& attribute, int component_type, int8_t components,
          std::vector<uint8_t>& to) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return pack_as<int8_t>(mesh, attribute, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return pack_as<uint8_t>(mesh, attribute, components, to);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return pack_as<int16_t>(mesh, attribute, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return pack_as<uint16_t>(mesh, attribute, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return pack_as<uint32_t>(mesh, attribute, components, to);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return pack_as<float>(mesh, attribute, components, to);
    default:
      return false;
  }
}

class PrimitiveDecoder {
 public:
  PrimitiveDecoder(File& file, tinygltf::Primitive& primitive, const std::string& user)
      : file_(file), primitive_(primitive), user_(user) {}
  PrimitiveDecoder(const PrimitiveDecoder&) = delete;
  PrimitiveDecoder& operator=(const PrimitiveDecoder&) = delete;
  ~PrimitiveDecoder() { file_.budget.give_back(work_bytes_); }

  void decode_into_accessors(const tinygltf::Value& e) {
    decode_stream(e);
    put_indices();
    if (!e.Has("attributes")) return;
    const tinygltf::Value& attributes = e.Get("attributes");
    for (const std::string& attribute : attributes.Keys()) put_attribute(attribute, attributes);
    primitive_.mode = TINYGLTF_MODE_TRIANGLES;
  }

 private:
  void decode_stream(const tinygltf::Value& e) {
    const auto view_index = static_cast<int>(std::clamp(number(file_, e, "bufferView", -1.0), -1.0, 2e9));
    const auto& views = file_.model.bufferViews;
    const tinygltf::BufferView& view = views[checked_index(file_, view_index, views.size(), "bufferView", user_)];
    const std::vector<unsigned char>& data = file_.model.buffers[static_cast<size_t>(view.buffer)].data;
    // hide_draco_indices() has moved it there.
    primitive_.indices = static_cast<int>(std::clamp(number(file_, e, "indices", -1.0), -1.0, 2e9));
    const auto position = primitive_.attributes.find("POSITION");
    Bounds bounds{.triangles = accessor_count(file_, primitive_.indices, user_ + ", indices") / 3,
                  .vertices = position == primitive_.attributes.end()
                                  ? 0
                                  : accessor_count(file_, position->second, user_ + ", POSITION"),
                  .budget = file_.budget,
                  .refusal = {}};
    const bool decoded = decode(std::span(data).subspan(view.byteOffset, view.byteLength), bounds, mesh_);
    if (!decoded && bounds.refusal.empty()) {
      refuse("cannot read {}: the Draco data of {} is damaged; get the file again", file_.path, user_);
    }
    if (!decoded) refuse("cannot read {}: the Draco data of {} {}", file_.path, user_, bounds.refusal);
    work_bytes_ = bounds.taken;
    file_.budget.check_time(user_);
  }

  // Adds an accessor for this primitive alone: others may use the file's accessor with other data.
  int add_accessor(tinygltf::Accessor accessor, std::vector<uint8_t> bytes, size_t count) {
    tinygltf::BufferView view;
    view.byteLength = bytes.size();
    view.buffer = add_buffer(file_, std::move(bytes));
    file_.model.bufferViews.push_back(view);
    accessor.bufferView = static_cast<int>(file_.model.bufferViews.size() - 1);
    accessor.byteOffset = 0;
    accessor.count = count;
    file_.model.accessors.push_back(std::move(accessor));
    return static_cast<int>(file_.model.accessors.size() - 1);
  }

  void put_indices() {
    const size_t triangles = mesh_.num_faces();
    file_.budget.take(triangles * 12, user_);
    std::vector<uint8_t> bytes(triangles * 12);
    for (uint32_t i = 0; i < triangles; ++i) {
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh_.face(draco::FaceIndex(i))[k].value();
        std::memcpy(&bytes[12 * size_t{i} + 4 * k], &vertex, 4);
      }
    }
    tinygltf::Accessor accessor = file_.model.accessors[static_cast<size_t>(primitive_.indices)];
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    primitive_.indices = add_accessor(std::move(accessor), std::move(bytes), 3 * triangles);
  }

  void put_attribute(const std::string& attribute, const tinygltf::Value& ids) {
    const auto found = primitive_.attributes.find(attribute);
    if (found == primitive_.attributes.end()) return;
    const std::string user = user_ + ", " + attribute;
    const uint32_t components = accessor_components(file_, found->second, user);
    const tinygltf::Accessor accessor = file_.model.accessors[static_cast<size_t>(found->second)];
    const double id = number(file_, ids, attribute.c_str(), -1.0);
    const draco::PointAttribute* stored =
        id >= 0.0 && id <= 4294967295.0 ? mesh_.GetAttributeByUniqueId(static_cast<uint32_t>(id)) : nullptr;
    if (stored == nullptr) {
      refuse("cannot read {}: {} is the Draco attribute {}, which is not there; export it again", file_.path, user, id);
    }
    file_.budget.take(uint64_t{mesh_.num_points()} * components * 4, user);
    std::vector<uint8_t> bytes;
    if (!pack(mesh_, *stored, accessor.componentType, static_cast<int8_t>(components), bytes)) {
      refuse("cannot read {}: {} has Draco data that does not fit its accessor; export it again", file_.path, user);
    }
    found->second = add_accessor(accessor, std::move(bytes), mesh_.num_points());
  }

  File& file_;
  tinygltf::Primitive& primitive_;
  const std::string& user_;
  draco::Mesh mesh_;
  uint64_t work_bytes_ = 0;  // of mesh_ and of decoding it
};

}  // namespace

void decode_draco(File& file) {
  for (size_t m = 0; m < file.model.meshes.size(); ++m) {
    for (size_t p = 0; p < file.model.meshes[m].primitives.size(); ++p) {
      tinygltf::Primitive& primitive = file.model.meshes[m].primitives[p];
      const tinygltf::Value* e = extension(primitive.extensions, draco_extension);
      if (e == nullptr) continue;
      const std::string user = fmt::format("mesh {}, primitive {}", m, p);
      PrimitiveDecoder(file, primitive, user).decode_into_accessors(*e);
    }
  }
}

}  // namespace sideray::scenes::gltf
