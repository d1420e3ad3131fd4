// C++ exceptions on WebAssembly's exceptions: Debian's libc++abi for wasm has none of these functions. Interface of compiled
// code: Itanium C++ ABI, Level II, with one phase of unwinding; LLVM's "Exception Handling in LLVM", WebAssembly.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <typeinfo>

namespace __cxxabiv1 {

// Base of all type descriptions in libc++abi, by its table of virtual functions.
class __shim_type_info : public std::type_info {
 public:
  ~__shim_type_info() override;
  virtual void noop1() const;
  virtual void noop2() const;
  /// Whether a handler of this type takes an object of the other; `object` is then the handler's part of it.
  virtual bool can_catch(const __shim_type_info* thrown, void*& object) const = 0;
};

}  // namespace __cxxabiv1

namespace {

using Type = __cxxabiv1::__shim_type_info;

/// Stands before each thrown object.
struct Header {
  const Type* type;
  void* (*destroy)(void*);  // destructors return their object on this machine
  void* caught;             // part of the object that the handler takes
  int handlers;             // that run for it; negative: thrown once more by the innermost
  Header* outer;            // of the handlers that run, from the innermost
};
// The object behind it needs the largest alignment.
constexpr std::size_t header_bytes =
    (sizeof(Header) + alignof(std::max_align_t) - 1) / alignof(std::max_align_t) * alignof(std::max_align_t);

Header* innermost = nullptr;  // the module has one thread

Header* header_of(void* object) { return reinterpret_cast<Header*>(static_cast<char*>(object) - header_bytes); }
void* object_of(Header* header) { return reinterpret_cast<char*>(header) + header_bytes; }

/// Table of one function's handlers, as the compiler wrote it.
class HandlerTable {
 public:
  explicit HandlerTable(const std::uint8_t* at) : at_(at) {
    constexpr std::uint8_t omitted = 0xff;
    if (*at_++ != omitted) std::abort();  // landing pads have a base of their own: not on this machine
    if (*at_++ != omitted) {
      const std::uint64_t to_types = number();
      types_ = at_ + to_types;
    }
    ++at_;  // encoding of call sites: always as `number`
    const std::uint64_t bytes = number();
    actions_ = at_ + bytes;
  }

  /// Number of the first handler of this call site that takes the exception; 0: none. Sets its `caught`.
  std::uintptr_t handler(std::uintptr_t site, Header& exception) {
    for (std::uintptr_t i = 0; i < site; ++i) {
      number();
      number();
    }
    number();
    const std::uint64_t first = number();
    if (first == 0) return 0;
    at_ = actions_ + first - 1;
    for (;;) {
      const std::int64_t type = signed_number();
      if (type > 0 && takes(static_cast<std::size_t>(type), exception)) return static_cast<std::uintptr_t>(type);
      const std::uint8_t* const from = at_;
      const std::int64_t next = signed_number();
      if (next == 0) return 0;
      at_ = from + next;
    }
  }

 private:
  bool takes(std::size_t number, Header& exception) const {
    const Type* type;
    std::memcpy(&type, types_ - number * sizeof type, sizeof type);
    void* object = object_of(&exception);
    const bool is_taken = type == nullptr || type->can_catch(exception.type, object);
    if (is_taken) exception.caught = object;
    return is_taken;
  }
  // LEB128.
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      const std::uint8_t byte = *at_++;
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if ((byte & 0x80) == 0) return value;
    }
  }
  std::int64_t signed_number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0;;) {
      const std::uint8_t byte = *at_++;
      value |= std::uint64_t{byte & 0x7fu} << shift;
      shift += 7;
      if ((byte & 0x80) != 0) continue;
      if ((byte & 0x40) != 0 && shift < 64) value |= ~std::uint64_t{0} << shift;
      return static_cast<std::int64_t>(value);
    }
  }

  const std::uint8_t* at_;
  const std::uint8_t* types_ = nullptr;
  const std::uint8_t* actions_ = nullptr;
};

constexpr int cpp_exception = 0;  // number of WebAssembly's tag for exceptions of C++

}  // namespace

extern "C" {

/// Between compiled code and `_Unwind_CallPersonality`.
struct LandingPad {
  std::uintptr_t site;
  const std::uint8_t* table;
  std::uintptr_t handler;
} __wasm_lpad_context;

int _Unwind_CallPersonality(void* object) {
  __wasm_lpad_context.handler = HandlerTable(__wasm_lpad_context.table).handler(__wasm_lpad_context.site, *header_of(object));
  return 0;
}

void* __cxa_allocate_exception(std::size_t bytes) noexcept {
  void* const made = std::calloc(1, header_bytes + bytes);
  if (!made) std::terminate();
  return object_of(static_cast<Header*>(made));
}

void __cxa_free_exception(void* object) noexcept { std::free(header_of(object)); }

[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void* (*destroy)(void*)) {
  Header* const header = header_of(object);
  header->type = static_cast<const Type*>(type);
  header->destroy = destroy;
  __builtin_wasm_throw(cpp_exception, object);
}

void* __cxa_begin_catch(void* object) noexcept {
  Header* const header = header_of(object);
  header->handlers = (header->handlers < 0 ? -header->handlers : header->handlers) + 1;
  if (header != innermost) {
    header->outer = innermost;
    innermost = header;
  }
  return header->caught;
}

void __cxa_end_catch() {
  Header* const header = innermost;
  if (!header) return;
  if (header->handlers < 0) {  // on its way out
    if (++header->handlers == 0) innermost = header->outer;
    return;
  }
  if (--header->handlers > 0) return;
  innermost = header->outer;
  if (header->destroy) header->destroy(object_of(header));
  std::free(header);
}

[[noreturn]] void __cxa_rethrow() {
  Header* const header = innermost;
  if (!header) std::terminate();
  header->handlers = -header->handlers;
  __builtin_wasm_throw(cpp_exception, object_of(header));
}
}
