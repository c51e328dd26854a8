// Reads whole files up to a size limit, and writes whole files through a temporary one. Any thread.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <sideray/sideray.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sideray::scenes {

// Returns the text with spaces for control characters: names from files must not break lines or control a terminal.
std::string printable(std::string text);

// Throws Error with the line "what: why; what to do".
template <typename... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(SIDERAY_INVALID_ARGUMENT, printable(fmt::format(format, std::forward<Args>(args)...)));
}

// Returns the size of a regular file; 0 where there is none, which read_file() refuses.
uint64_t file_size(const std::string& path);
// Returns the bytes of a regular file: a device or pipe could be endless. Throws Error, which names the file and the
// remedy.
std::vector<uint8_t> read_file(const std::string& path, uint64_t maximum_bytes);

// Continues the hash `before` over more bytes (FNV-1a, which is not safe against forgery).
constexpr uint64_t empty_hash = 0xcbf29ce484222325u;
uint64_t hash_of(std::span<const uint8_t> bytes, uint64_t before = empty_hash);

// Writes the file whole or not at all. Throws Error, which names the file and the remedy.
void write_file(const std::string& path, std::span<const uint8_t> bytes);

// Returns the lower-case extension with its dot, or "".
std::string extension_of(const std::string& path);

}  // namespace sideray::scenes
