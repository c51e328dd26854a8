// A preloaded library that lets the n-th allocation or the n-th file call fail. It counts calls of the program and of
// its linked libraries, also those through the C and C++ libraries, but not those of drivers, which are loaded later.
//
// Allocations are counted by place, which is a chain of calls: the first allocation of the n-th chain fails. A loop is
// one place; a function called from two others is two places.
//
//   SIDERAY_FAULT        "allocation:N" or "file:N", from 1 on; with a "+" at its end all later ones fail too
//   SIDERAY_FAULT_COUNT  a file for three numbers of 64 bits: places that allocate, calls about files, failures
//   SIDERAY_NO_EXCHANGE  renameat2() fails as on file systems that cannot exchange two names
//   SIDERAY_FAULT_SHOW   writes the chain of calls of each failure to standard error
#include <dirent.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <unwind.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <new>

extern "C" {
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* old, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void* memory);
}

namespace {

struct Range {
  uintptr_t begin, end;
  bool is_counted;  // false: a C or C++ library, whose caller counts
};

struct Counts {
  std::atomic<uint64_t> allocations, files, failures;
};

// Nothing here is on the heap or destroyed, since calls come before and after main().
constexpr int most_ranges = 256;
Range ranges[most_ranges];
int range_count = 0;
Counts own_counts{};
Counts* counts = &own_counts;
uint64_t failing_allocation = 0, failing_file = 0;
bool lasts = false, shows = false;
std::atomic<bool> is_ready{false}, has_failed{false};
__attribute__((tls_model("initial-exec"))) thread_local bool is_looking = false;

const Range* range_of(uintptr_t address) {
  for (int i = 0; i < range_count; ++i)
    if (address >= ranges[i].begin && address < ranges[i].end) return &ranges[i];
  return nullptr;
}

int add_module(dl_phdr_info* module, size_t, void*) {
  const char* name = std::strrchr(module->dlpi_name, '/');
  name = name ? name + 1 : module->dlpi_name;
  bool is_counted = true;
  for (const char* language : {"libc.so", "libstdc++.so", "libm.so", "libgcc_s.so", "libfailing_calls"})
    if (std::strncmp(name, language, std::strlen(language)) == 0) is_counted = false;
  if (std::strncmp(name, "ld-linux", 8) == 0 || std::strncmp(name, "linux-vdso", 10) == 0) return 0;
  for (int i = 0; i < module->dlpi_phnum && range_count < most_ranges; ++i) {
    const ElfW(Phdr)& part = module->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    const uintptr_t begin = module->dlpi_addr + part.p_vaddr;
    ranges[range_count++] = {begin, begin + part.p_memsz, is_counted};
  }
  return 0;
}

uint64_t number_after(const char* text, const char* kind) {
  const size_t length = std::strlen(kind);
  return std::strncmp(text, kind, length) == 0 ? std::strtoull(text + length, nullptr, 10) : 0;
}

__attribute__((constructor)) void get_ready() {
  dl_iterate_phdr(add_module, nullptr);
  if (const char* fault = std::getenv("SIDERAY_FAULT")) {
    failing_allocation = number_after(fault, "allocation:");
    failing_file = number_after(fault, "file:");
    lasts = fault[std::strlen(fault) - 1] == '+';
  }
  shows = std::getenv("SIDERAY_FAULT_SHOW") != nullptr;
  if (const char* path = std::getenv("SIDERAY_FAULT_COUNT")) {
    const int file = ::open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file >= 0 && ::ftruncate(file, sizeof(Counts)) == 0) {
      void* shared = ::mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
      if (shared != MAP_FAILED) counts = static_cast<Counts*>(shared);
    }
    ::close(file);
  }
  is_ready = true;
}

// Holds a chain of calls, from the innermost caller outside of the C and C++ libraries on.
struct Chain {
  bool is_counted = false, is_found = false;
  int calls = 0;
  uint64_t hash = 0xcbf29ce484222325u;
};

_Unwind_Reason_Code look(_Unwind_Context* frame, void* found) {
  constexpr int most_calls = 40;
  Chain& chain = *static_cast<Chain*>(found);
  const uintptr_t address = _Unwind_GetIP(frame);
  const Range* range = range_of(address);
  if (!chain.is_found && range && !range->is_counted) return _URC_NO_REASON;
  if (!chain.is_found) chain.is_counted = range != nullptr;
  chain.is_found = true;
  chain.hash = (chain.hash ^ address) * 0x100000001b3u;
  return chain.is_counted && ++chain.calls < most_calls ? _URC_NO_REASON : _URC_END_OF_STACK;
}

// Returns the chain of calls. Most calls of drivers are recognized by the caller's address alone.
Chain chain_of(void* caller) {
  Chain chain;
  if (!is_ready || is_looking || !range_of(reinterpret_cast<uintptr_t>(caller))) return chain;
  is_looking = true;
  _Unwind_Backtrace(look, &chain);
  is_looking = false;
  return chain;
}

bool is_new(uint64_t chain) {
  constexpr size_t places = 1 << 16;
  static std::atomic<uint64_t> known[places];
  for (size_t at = chain % places, tries = 0; tries < places; at = (at + 1) % places, ++tries) {
    uint64_t there = 0;
    if (known[at].compare_exchange_strong(there, chain)) return true;
    if (there == chain) return false;
  }
  return false;
}

void show_calls() {
  void* calls[64];
  is_looking = true;
  backtrace_symbols_fd(calls, backtrace(calls, std::size(calls)), STDERR_FILENO);
  is_looking = false;
}

bool fails(bool is_next, std::atomic<uint64_t>& count, uint64_t failing) {
  const bool is_it = is_next && ++count == failing;
  if (is_it) has_failed = true;
  if (!is_it && !(lasts && has_failed && failing != 0)) return false;
  ++counts->failures;
  if (shows) show_calls();
  return true;
}

bool allocation_fails(void* caller) {
  const Chain chain = chain_of(caller);
  return chain.is_counted && fails(is_new(chain.hash), counts->allocations, failing_allocation);
}

bool file_fails(void* caller, int error) {
  if (!chain_of(caller).is_counted || !fails(true, counts->files, failing_file)) return false;
  errno = error;
  return true;
}

// Returns the next library's function of this name.
template <typename F>
F* next(const char* name) {
  is_looking = true;
  void* const found = dlsym(RTLD_NEXT, name);
  is_looking = false;
  F* function = nullptr;
  std::memcpy(&function, &found, sizeof(function));
  return function;
}

// Makes ferror() report an error, as after a full disk.
void set_error(FILE* file) {
  constexpr int error_seen = 0x20;  // _IO_ERR_SEEN of glibc
  file->_flags |= error_seen;
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

#define CALLER __builtin_return_address(0)
#define NEXT(function) next<decltype(function)>(#function)

extern "C" {

void* malloc(size_t bytes) {
  if (allocation_fails(CALLER)) return errno = ENOMEM, nullptr;
  return __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  if (allocation_fails(CALLER)) return errno = ENOMEM, nullptr;
  return __libc_calloc(count, bytes);
}
void* realloc(void* old, size_t bytes) {
  if (allocation_fails(CALLER)) return errno = ENOMEM, nullptr;
  return __libc_realloc(old, bytes);
}
void* memalign(size_t alignment, size_t bytes) {
  if (allocation_fails(CALLER)) return errno = ENOMEM, nullptr;
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  if (allocation_fails(CALLER)) return errno = ENOMEM, nullptr;
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** result, size_t alignment, size_t bytes) {
  if (allocation_fails(CALLER)) return ENOMEM;
  void* const memory = __libc_memalign(alignment, bytes);
  if (memory) *result = memory;
  return memory ? 0 : ENOMEM;
}

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return file_fails(CALLER, EACCES) ? -1 : NEXT(open)(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_of(flags, arguments);
  va_end(arguments);
  return file_fails(CALLER, EACCES) ? -1 : NEXT(open64)(path, flags, mode);
}
int mkostemp(char* name, int flags) {
  return file_fails(CALLER, EACCES) ? -1 : NEXT(mkostemp)(name, flags);
}
int mkostemp64(char* name, int flags) {
  return file_fails(CALLER, EACCES) ? -1 : NEXT(mkostemp64)(name, flags);
}
FILE* fopen(const char* path, const char* mode) {
  return file_fails(CALLER, EACCES) ? nullptr : NEXT(fopen)(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  return file_fails(CALLER, EACCES) ? nullptr : NEXT(fopen64)(path, mode);
}
DIR* opendir(const char* path) {
  return file_fails(CALLER, EACCES) ? nullptr : NEXT(opendir)(path);
}
ssize_t read(int file, void* bytes, size_t count) {
  return file_fails(CALLER, EIO) ? -1 : NEXT(read)(file, bytes, count);
}
// Messages on standard error do not fail, since that could not be reported.
ssize_t write(int file, const void* bytes, size_t count) {
  return file != STDERR_FILENO && file_fails(CALLER, ENOSPC) ? -1 : NEXT(write)(file, bytes, count);
}
size_t fwrite(const void* bytes, size_t size, size_t count, FILE* file) {
  if (file == stderr || !file_fails(CALLER, ENOSPC)) return NEXT(fwrite)(bytes, size, count, file);
  set_error(file);
  return 0;
}
int fflush(FILE* file) {
  if (file == stderr || !file_fails(CALLER, ENOSPC)) return NEXT(fflush)(file);
  set_error(file);
  return EOF;
}
int fsync(int file) {
  return file_fails(CALLER, EIO) ? -1 : NEXT(fsync)(file);
}
// Closes the file also where it reports a failure.
int close(int file) {
  const bool failed = file_fails(CALLER, EIO);
  const int result = NEXT(close)(file);
  return failed ? errno = EIO, -1 : result;
}
int fclose(FILE* file) {
  const bool failed = file_fails(CALLER, EIO);
  const int result = NEXT(fclose)(file);
  return failed ? errno = EIO, EOF : result;
}
int rename(const char* from, const char* to) {
  return file_fails(CALLER, EACCES) ? -1 : NEXT(rename)(from, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  if (std::getenv("SIDERAY_NO_EXCHANGE")) return errno = EINVAL, -1;
  return file_fails(CALLER, EACCES) ? -1 : NEXT(renameat2)(from_folder, from, to_folder, to, flags);
}
char* mkdtemp(char* name) {
  return file_fails(CALLER, EACCES) ? nullptr : NEXT(mkdtemp)(name);
}
int link(const char* from, const char* to) {
  return file_fails(CALLER, EPERM) ? -1 : NEXT(link)(from, to);
}
int mkdir(const char* path, mode_t mode) {
  return file_fails(CALLER, EACCES) ? -1 : NEXT(mkdir)(path, mode);
}
int ftruncate(int file, off_t bytes) {
  return file_fails(CALLER, ENOSPC) ? -1 : NEXT(ftruncate)(file, bytes);
}

}  // extern "C"

// Replace those of libstdc++, whose callers would have to be searched for on the stack.
void* operator new(size_t bytes) {
  void* const memory = allocation_fails(CALLER) ? nullptr : __libc_malloc(bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  return allocation_fails(CALLER) ? nullptr : __libc_malloc(bytes);
}
void* operator new[](size_t bytes) {
  void* const memory = allocation_fails(CALLER) ? nullptr : __libc_malloc(bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept {
  return allocation_fails(CALLER) ? nullptr : __libc_malloc(bytes);
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  void* const memory = allocation_fails(CALLER) ? nullptr : __libc_memalign(static_cast<size_t>(alignment), bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept {
  __libc_free(memory);
}
void operator delete[](void* memory) noexcept {
  __libc_free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  __libc_free(memory);
}
void operator delete[](void* memory, size_t) noexcept {
  __libc_free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  __libc_free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  __libc_free(memory);
}
