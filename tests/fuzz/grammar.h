// Makes glTF documents by the rules of the format, valid or with some values broken. Test support.
#pragma once

#include <nlohmann/json.hpp>

#include "fuzz/random.h"

namespace sideray::fuzz {

// A document that glTF 2.0 allows and that the loader has to load.
nlohmann::json whole_document(Random& random);

// Breaks some values: types, indices, counts, ranges, missing and doubled parts.
void break_document(nlohmann::json& document, Random& random);

}  // namespace sideray::fuzz
