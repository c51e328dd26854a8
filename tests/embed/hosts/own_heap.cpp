#include "embed/hosts/own_heap.h"

#include <link.h>
#include <unwind.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <unordered_map>

namespace sideray::tests {
namespace {

// Allocates memory for the counter itself, which must not be counted.
template <typename T>
struct Malloc {
  using value_type = T;
  Malloc() = default;
  template <typename U>
  explicit Malloc(const Malloc<U>&) {}
  T* allocate(size_t count) {
    if (void* const memory = std::malloc(count * sizeof(T))) return static_cast<T*>(memory);
    std::abort();
  }
  void deallocate(T* memory, size_t) { std::free(memory); }
  bool operator==(const Malloc&) const { return true; }
};

struct Shard {
  std::mutex mutex;
  std::unordered_map<const void*, size_t, std::hash<const void*>, std::equal_to<>,
                     Malloc<std::pair<const void* const, size_t>>>
      sizes;
};

struct Range {
  uintptr_t begin, end;
  bool is_language;  // the C++ library, whose caller counts
};

struct Modules {
  std::array<Range, 256> ranges;
  size_t count = 0;

  const Range* of(uintptr_t address) const {
    for (size_t i = 0; i < count; ++i)
      if (address >= ranges[i].begin && address < ranges[i].end) return &ranges[i];
    return nullptr;
  }
};

std::atomic<bool> counts{false};
std::atomic<size_t> bytes{0}, blocks{0};

// Never destroyed, since memory is freed until the very end.
std::array<Shard, 64>& all_shards() {
  static std::array<Shard, 64>& shards = *new (std::malloc(sizeof(std::array<Shard, 64>))) std::array<Shard, 64>;
  return shards;
}
Shard& shard_of(const void* memory) {
  return all_shards()[reinterpret_cast<uintptr_t>(memory) / 64 % all_shards().size()];
}

int add_module(dl_phdr_info* module, size_t, void* found) {
  Modules& modules = *static_cast<Modules*>(found);
  const bool is_language = std::strstr(module->dlpi_name, "libstdc++") != nullptr;
  for (int i = 0; i < module->dlpi_phnum && modules.count < modules.ranges.size(); ++i) {
    const ElfW(Phdr)& part = module->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    const uintptr_t begin = module->dlpi_addr + part.p_vaddr;
    modules.ranges[modules.count++] = {begin, begin + part.p_memsz, is_language};
  }
  return 0;
}

// Returns the modules loaded before main().
Modules find_modules() {
  Modules modules;
  dl_iterate_phdr(add_module, &modules);
  return modules;
}
const Modules modules = find_modules();

struct Search {
  uintptr_t caller;
  bool is_reached = false, is_own = false;
};

// Finds the first caller outside of the C++ library.
_Unwind_Reason_Code look(_Unwind_Context* frame, void* found) {
  Search& search = *static_cast<Search*>(found);
  const uintptr_t address = _Unwind_GetIP(frame);
  search.is_reached = search.is_reached || address == search.caller;
  if (!search.is_reached) return _URC_NO_REASON;
  const Range* const range = modules.of(address);
  if (range && range->is_language) return _URC_NO_REASON;
  search.is_own = range != nullptr;
  return _URC_END_OF_STACK;
}

bool is_own(void* caller) {
  const Range* const range = modules.of(reinterpret_cast<uintptr_t>(caller));
  if (!range || !range->is_language) return range != nullptr;
  Search search{reinterpret_cast<uintptr_t>(caller)};
  _Unwind_Backtrace(look, &search);
  return search.is_own;
}

[[maybe_unused]] void* note(void* memory, size_t size, void* caller) {
  if (!memory) throw std::bad_alloc();
  if (!counts || !is_own(caller)) return memory;
  Shard& shard = shard_of(memory);
  const std::lock_guard lock(shard.mutex);
  shard.sizes.emplace(memory, size);
  bytes += size, ++blocks;
  return memory;
}

[[maybe_unused]] void forget(const void* memory) {
  if (!counts || !memory) return;
  Shard& shard = shard_of(memory);
  const std::lock_guard lock(shard.mutex);
  const auto known = shard.sizes.find(memory);
  if (known == shard.sizes.end()) return;
  bytes -= known->second, --blocks;
  shard.sizes.erase(known);
}

}  // namespace

OwnHeap::OwnHeap() {
  for (Shard& shard : all_shards()) {
    const std::lock_guard lock(shard.mutex);
    shard.sizes.clear();
  }
  bytes = 0, blocks = 0;
  counts = true;
}
OwnHeap::~OwnHeap() {
  counts = false;
}
OwnHeap::Use OwnHeap::use() const {
  return {bytes, blocks};
}

}  // namespace sideray::tests

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

#define CALLER __builtin_return_address(0)

// The forms for arrays and those that do not throw call these.
void* operator new(size_t size) {
  return sideray::tests::note(std::malloc(size == 0 ? 1 : size), size, CALLER);
}
void* operator new(size_t size, std::align_val_t alignment) {
  const auto boundary = static_cast<size_t>(alignment);
  return sideray::tests::note(std::aligned_alloc(boundary, (size + boundary - 1) / boundary * boundary), size, CALLER);
}
void operator delete(void* memory) noexcept {
  sideray::tests::forget(memory);
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  sideray::tests::forget(memory);
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  sideray::tests::forget(memory);
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  sideray::tests::forget(memory);
  std::free(memory);
}

#endif
