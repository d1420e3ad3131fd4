// Counter of the calling thread's operator new, for one source file of a test program: replaces the global operators.
#pragma once

#include <cstdlib>
#include <new>

namespace palpa::test {
inline thread_local long allocations = 0;
}

// Never inlined: g++ 12 reports an inlined pair as a mismatch of new and free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++palpa::test::allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++palpa::test::allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
