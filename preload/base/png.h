// Writes PNG without compression: pictures for reports, without a library.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sideray::run {

// Returns the bytes of a file. `channels`: 3 or 4, 8 bits each; top row first.
std::string png(int width, int height, int channels, const std::vector<uint8_t>& texels);

std::string base64(const std::string& bytes);

}  // namespace sideray::run
