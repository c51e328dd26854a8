// Holds tinygltf's implementation; no other translation unit may.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
