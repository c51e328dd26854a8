// Whole files in and out: reading with a size limit, writing through a temporary file. Any thread.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <sideray/sideray.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sideray::scenes {

// Spaces instead of control characters: names from files must neither break a line nor command a terminal.
std::string printable(std::string text);

// Throws Error with the line "what: why; what to do".
template <typename... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(SIDERAY_INVALID_ARGUMENT, printable(fmt::format(format, std::forward<Args>(args)...)));
}

// Of a regular file; 0 where there is none, which read_file() refuses.
uint64_t file_size(const std::string& path);
// Regular files only: a device or pipe could be endless. Throws Error naming the file and the remedy.
std::vector<uint8_t> read_file(const std::string& path, uint64_t maximum_bytes);

// Continues the hash `before` over more bytes (FNV-1a): it tells files apart, and resists no attack.
constexpr uint64_t empty_hash = 0xcbf29ce484222325u;
uint64_t hash_of(std::span<const uint8_t> bytes, uint64_t before = empty_hash);

// The file appears whole under its name or not at all. Throws Error naming the file and the remedy.
void write_file(const std::string& path, std::span<const uint8_t> bytes);

// Lower-case extension with its dot, or "".
std::string extension_of(const std::string& path);

}  // namespace sideray::scenes
