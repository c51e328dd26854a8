#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "fuzz/grammar.h"
#include "fuzz/scene_promises.h"

// Fuzzes glTF by grammar: `fuzz_grammar SEED COUNT` loads COUNT documents, of which one in four is valid and must load,
// and the others are broken. `fuzz_grammar SEED 1 FILE` also writes the seed's document. SIGTERM ends a run early.
namespace {

using namespace sideray;

std::vector<uint8_t> document_of(uint64_t seed, bool& whole) {
  fuzz::Random random(seed);
  nlohmann::json document = fuzz::whole_document(random);
  whole = random.one_in(4);
  if (!whole) fuzz::break_document(document, random);
  const std::string text = document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return {text.begin(), text.end()};
}

}  // namespace

int main(int argc, char** argv) {
  const uint64_t first = argc > 1 ? std::strtoull(argv[1], nullptr, 0) : 1;
  const uint64_t count = argc > 2 ? std::strtoull(argv[2], nullptr, 0) : 1000;
  uint64_t done = 0, wholes = 0, loaded = 0;
  fuzz::stop_at_signals();
  for (; done < count && fuzz::has_to_stop == 0; ++done) {
    const uint64_t seed = first + done;
    bool whole = false;
    const std::vector<uint8_t> bytes = document_of(seed, whole);
    if (argc > 3) std::ofstream(argv[3], std::ios::binary) << std::string(bytes.begin(), bytes.end());
    fuzz::note("document", seed);
    const std::string message = fuzz::load_and_use(bytes, {.seconds = 20, .bytes = 500'000'000});
    if (whole && !message.empty()) fuzz::broken("a document that glTF allows is loaded", message);
    wholes += whole, loaded += message.empty();
  }
  std::printf("%llu documents, %llu of them whole, %llu loaded\n", static_cast<unsigned long long>(done),
              static_cast<unsigned long long>(wholes), static_cast<unsigned long long>(loaded));
  return 0;
}
