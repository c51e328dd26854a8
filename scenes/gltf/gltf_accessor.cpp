#include <algorithm>
#include <cstring>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {
namespace {

// Locates elements whose bounds were all checked.
struct Elements {
  const uint8_t* bytes = nullptr;
  size_t stride = 0, count = 0;
  int component_type = 0;
  uint32_t components = 0;
  bool normalized = false;
};

size_t component_bytes(const File& file, int type, const std::string& user) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      refuse("cannot read {}: {} has the component type {}, which glTF lacks; export it again", file.path, user, type);
  }
}

uint32_t components_of(const File& file, int type, const std::string& user) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      refuse("cannot read {}: {} has matrices of another size; export it again", file.path, user);
  }
}

const tinygltf::Accessor& accessor_at(const File& file, int index, const std::string& user) {
  return file.model.accessors[checked_index(file, index, file.model.accessors.size(), "accessor", user)];
}

// Returns the first of `count` elements of `element_bytes` bytes, `stride` apart, from `offset` of the view. Throws
// Error where they are not inside it.
const uint8_t* checked_bytes(const File& file, int view_index, size_t offset, size_t stride, size_t element_bytes,
                             size_t count, const std::string& user) {
  const size_t index = checked_index(file, view_index, file.model.bufferViews.size(), "bufferView", user);
  const tinygltf::BufferView& view = file.model.bufferViews[index];
  const size_t last = count == 0 ? 0 : (count - 1) * stride + element_bytes;
  if (offset > view.byteLength || last > view.byteLength - offset) {
    refuse("cannot read {}: {} reads {} bytes at {} of bufferView {}, which has {}; export it again", file.path, user,
           last, offset, view_index, view.byteLength);
  }
  return file.model.buffers[static_cast<size_t>(view.buffer)].data.data() + view.byteOffset + offset;
}

Elements locate(const File& file, const tinygltf::Accessor& accessor, const std::string& user) {
  Elements elements;
  elements.component_type = accessor.componentType;
  elements.components = components_of(file, accessor.type, user);
  elements.normalized = accessor.normalized;
  elements.count = accessor.count;
  const size_t element_bytes = component_bytes(file, accessor.componentType, user) * elements.components;
  const size_t limit = accessor.bufferView < 0 ? limits::accessor_elements_without_data : limits::accessor_elements;
  if (accessor.count == 0 || accessor.count > limit) {
    refuse("cannot read {}: {} has {} elements, not 1 to {}; split the mesh", file.path, user, accessor.count, limit);
  }
  elements.stride = element_bytes;
  if (accessor.bufferView < 0) return elements;
  const size_t view = checked_index(file, accessor.bufferView, file.model.bufferViews.size(), "bufferView", user);
  if (const size_t stride = file.model.bufferViews[view].byteStride; stride != 0) elements.stride = stride;
  if (elements.stride < element_bytes) {
    refuse("cannot read {}: {} has elements of {} bytes every {} bytes; export it again", file.path, user,
           element_bytes, elements.stride);
  }
  elements.bytes = checked_bytes(file, accessor.bufferView, accessor.byteOffset, elements.stride, element_bytes,
                                 elements.count, user);
  return elements;
}

template <typename T>
T component_at(const uint8_t* element, size_t index) {
  T value;
  std::memcpy(&value, element + index * sizeof(T), sizeof(T));
  return value;
}

// Returns a component as float. Signed normalized integers are max(c / max, -1) (glTF 2.0, 3.11).
float float_at(const Elements& elements, const uint8_t* element, size_t c) {
  const float divide = elements.normalized ? 1.0f : 0.0f;
  const auto scaled = [&](float value, float maximum) {
    return divide > 0.0f ? std::max(value / maximum, -1.0f) : value;
  };
  switch (elements.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return scaled(static_cast<float>(component_at<int8_t>(element, c)), 127.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return scaled(static_cast<float>(component_at<uint8_t>(element, c)), 255.0f);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return scaled(static_cast<float>(component_at<int16_t>(element, c)), 32767.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return scaled(static_cast<float>(component_at<uint16_t>(element, c)), 65535.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return static_cast<float>(component_at<uint32_t>(element, c));
    default:
      return component_at<float>(element, c);
  }
}

uint32_t unsigned_at(int component_type, const uint8_t* element, size_t c) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return component_at<uint8_t>(element, c);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return component_at<uint16_t>(element, c);
    default:
      return component_at<uint32_t>(element, c);
  }
}

bool is_unsigned(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// Calls replace(element index, bytes of its new value) for every substituted element.
template <typename Replace>
void for_each_sparse(const File& file, const tinygltf::Accessor& accessor, const Elements& elements,
                     const std::string& user, Replace&& replace) {
  if (!accessor.sparse.isSparse) return;
  const auto& sparse = accessor.sparse;
  const size_t element_bytes = component_bytes(file, elements.component_type, user) * elements.components;
  const bool in_range = sparse.count >= 0 && static_cast<size_t>(sparse.count) <= elements.count &&
                        sparse.indices.byteOffset >= 0 && sparse.values.byteOffset >= 0;
  if (!in_range || !is_unsigned(sparse.indices.componentType)) {
    refuse("cannot read {}: {} has a broken sparse part; export it again", file.path, user);
  }
  const auto count = static_cast<size_t>(sparse.count);
  const size_t index_bytes = component_bytes(file, sparse.indices.componentType, user);
  const uint8_t* indices =
      checked_bytes(file, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), index_bytes,
                    index_bytes, count, user + " (sparse indices)");
  const uint8_t* values = checked_bytes(file, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
                                        element_bytes, element_bytes, count, user + " (sparse values)");
  for (size_t i = 0; i < count; ++i) {
    const uint32_t index = unsigned_at(sparse.indices.componentType, indices + i * index_bytes, 0);
    if (index >= elements.count) {
      refuse("cannot read {}: {} replaces element {} of {}; export it again", file.path, user, index, elements.count);
    }
    replace(index, values + i * element_bytes);
  }
}

}  // namespace

size_t accessor_count(const File& file, int accessor, const std::string& user) {
  return accessor_at(file, accessor, user).count;
}

uint32_t accessor_components(const File& file, int accessor, const std::string& user) {
  return components_of(file, accessor_at(file, accessor, user).type, user);
}

std::vector<float> read_floats(const File& file, int accessor_index, uint32_t components, size_t expected_count,
                               const std::string& user) {
  const tinygltf::Accessor& accessor = accessor_at(file, accessor_index, user);
  const Elements elements = locate(file, accessor, user);
  if (elements.components != components) {
    refuse("cannot read {}: {} has {} components instead of {}; export it again", file.path, user, elements.components,
           components);
  }
  if (expected_count != 0 && elements.count != expected_count) {
    refuse("cannot read {}: {} has {} elements where {} belong; export it again", file.path, user, elements.count,
           expected_count);
  }
  file.budget.take(elements.count * components * sizeof(float), user);
  file.budget.check_time(user);
  std::vector<float> values(elements.count * components, 0.0f);
  for (size_t i = 0; elements.bytes != nullptr && i < elements.count; ++i) {
    for (uint32_t c = 0; c < components; ++c) {
      values[i * components + c] = float_at(elements, elements.bytes + i * elements.stride, c);
    }
  }
  for_each_sparse(file, accessor, elements, user, [&](size_t index, const uint8_t* element) {
    for (uint32_t c = 0; c < components; ++c) values[index * components + c] = float_at(elements, element, c);
  });
  return values;
}

std::vector<uint32_t> read_unsigned(const File& file, int accessor_index, const std::string& user) {
  const tinygltf::Accessor& accessor = accessor_at(file, accessor_index, user);
  const Elements elements = locate(file, accessor, user);
  if (elements.components != 1 || !is_unsigned(elements.component_type)) {
    refuse("cannot read {}: {} are not unsigned whole numbers; export it again", file.path, user);
  }
  file.budget.take(elements.count * sizeof(uint32_t), user);
  file.budget.check_time(user);
  std::vector<uint32_t> values(elements.count, 0);
  for (size_t i = 0; elements.bytes != nullptr && i < elements.count; ++i) {
    values[i] = unsigned_at(elements.component_type, elements.bytes + i * elements.stride, 0);
  }
  for_each_sparse(file, accessor, elements, user, [&](size_t index, const uint8_t* element) {
    values[index] = unsigned_at(elements.component_type, element, 0);
  });
  return values;
}

}  // namespace sideray::scenes::gltf
